// Shards of complete runs, written without opening their sixty arrays one by one: HDF5 makes the
// file once with room for every value, and the values of each run are put into a copy of its bytes.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/store/hdf5/image_editor.h"
#include "runtime/store/run_facts.h"
#include "runtime/store/shards/shard_index.h"
#include "runtime/store/shards/shard_template.h"
#include "runtime/store/store.h"

namespace cdb::shards {

/// The HDF5 file of a run, and where its chunks are.
struct ShardFile {
  std::vector<std::byte> image;
  std::vector<IndexedChunk> chunks;
};

/// Of runs with one template and the same models. Threads: any.
class PreparedShard {
 public:
  /// Null if the shards of the plan hold more than one chunk of a series, contacts or errors, or if
  /// a place of a value cannot be found. `models`: the attribute of /provenance. Throws
  /// hdf5::Error.
  static std::unique_ptr<PreparedShard> Make(std::shared_ptr<const ShardTemplate> from,
                                             const plan::Plan& plan, const store::PlanFacts& facts,
                                             const plan::Run& run, const std::string& models);

  /// Nullopt if the run is not complete, if the first file was not what HDF5 reads back, or after
  /// an error of HDF5's or in its bytes.
  std::optional<ShardFile> Write(const plan::Run& run, const store::RunResult& result,
                                 const std::string& run_text);

 private:
  /// A series, and the entry of its only chunk in the index of chunks.
  struct SeriesPlace {
    const store::Array* array;
    std::uint64_t entry;
  };
  PreparedShard(std::shared_ptr<const ShardTemplate> from, const plan::Plan& plan,
                const store::PlanFacts& facts, const std::string& models);
  bool FindPlaces(const plan::Run& run);
  bool FindSeries();
  bool FindTexts();
  std::vector<std::span<const std::byte>> SeriesOf(const store::RunResult& result) const;
  ShardFile Fill(const plan::Run& run, const store::RunResult& result,
                 std::span<const std::span<const std::byte>> values, const std::string& run_text);
  bool ReadsBack(const ShardFile& shard, const plan::Run& run, const store::RunResult& result,
                 const std::string& run_text) const;

  const std::shared_ptr<const ShardTemplate> template_;
  const plan::Plan& plan_;
  const store::PlanFacts& facts_;
  std::mutex mutex_;
  hdf5::File file_;
  std::vector<hdf5::NumberPlace> numbers_;  ///< of PlanFacts::numbers
  /// Of the coordinates that are numbers, with the axis; the last of a group is `rep`.
  std::vector<std::pair<hdf5::NumberPlace, std::size_t>> coordinates_;
  std::vector<std::uint64_t> texts_;  ///< of PlanFacts::texts, then of the run as text
  std::vector<SeriesPlace> series_;   ///< in the order of the layout
  bool is_checked_ = false, is_good_ = true;
};

/// Prepared shards by template and models, each from its third run on: preparing one takes as long
/// as writing two shards. Where one cannot be, or fails, HDF5 has to write the shard. Threads: any.
class PreparedShards {
 public:
  PreparedShards(const plan::Plan& plan, const store::PlanFacts& facts)
      : plan_(plan), facts_(facts) {}
  /// As PreparedShard::Write; nullopt also if nothing is prepared.
  std::optional<ShardFile> Write(const std::shared_ptr<const ShardTemplate>& from,
                                 const plan::Run& run, const store::RunResult& result,
                                 const std::string& run_text);

 private:
  using Key = std::pair<std::shared_ptr<const ShardTemplate>, std::string>;
  std::shared_ptr<PreparedShard> Prepare(const std::shared_ptr<const ShardTemplate>& from,
                                         const plan::Run& run, const std::string& models) const;
  const plan::Plan& plan_;
  const store::PlanFacts& facts_;
  std::mutex mutex_;
  struct Entry {
    std::size_t runs = 0;
    std::shared_ptr<PreparedShard> shard;  ///< null before, and if it cannot be
  };
  std::map<Key, Entry> shards_;
};

}  // namespace cdb::shards
