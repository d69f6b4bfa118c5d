// Shards of complete runs, written without opening their sixty arrays one by one: HDF5 creates the
// file once with room for every value, and the values of each run are inserted into a copy of its
// bytes.
#pragma once

#include <atomic>
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

/// The HDF5 file of a run, and the positions of its chunks.
struct ShardFile {
  std::vector<std::byte> image;
  std::vector<IndexedChunk> chunks;
};

/// Writes shards of runs with one template and the same models. Threads: any.
class PreparedShard {
 public:
  /// Null if the shards of the plan hold more than one chunk of a series, contacts or errors, or if
  /// the position of a value cannot be found. `models`: the attribute of /provenance. Throws
  /// hdf5::Error.
  static std::unique_ptr<PreparedShard> Make(std::shared_ptr<const ShardTemplate> from,
                                             const plan::Plan& plan, const store::PlanFacts& facts,
                                             const plan::Run& run, const std::string& models);

  /// Nullopt if the run is not complete, if HDF5 did not read the first file back correctly, or
  /// after an error of HDF5 or in its bytes.
  std::optional<ShardFile> Write(const plan::Run& run, const store::RunResult& result,
                                 const std::string& run_text);

 private:
  /// A series, and the place that describes its only chunk.
  struct SeriesPlace {
    const store::Array* array;
    std::uint64_t chunk;
  };
  struct CoordinatePlace {
    RunCoordinate coordinate;
    hdf5::NumberPlace number;  ///< or its text
  };
  PreparedShard(std::shared_ptr<const ShardTemplate> from, const plan::Plan& plan,
                const store::PlanFacts& facts, std::vector<std::byte> image);
  void FindPlaces(const hdf5::File& file, const plan::Run& run);
  void FindCoordinates(const hdf5::File& file);
  std::vector<std::span<const std::byte>> SeriesOf(const store::RunResult& result) const;
  ShardFile Fill(const plan::Run& run, const store::RunResult& result,
                 std::span<const std::span<const std::byte>> values,
                 const std::string& run_text) const;
  bool ReadsBack(const ShardFile& shard, const plan::Run& run, const store::RunResult& result,
                 const std::string& run_text) const;

  const std::shared_ptr<const ShardTemplate> template_;
  const plan::Plan& plan_;
  const store::PlanFacts& facts_;
  hdf5::EditableImage image_;
  std::vector<hdf5::Extent> head_;          ///< in the order of HeadOfRun
  std::vector<hdf5::NumberPlace> numbers_;  ///< in the order of PlanFacts::numbers
  std::vector<CoordinatePlace> coordinates_;
  std::vector<std::pair<const store::Dimension*, std::uint64_t>> labels_;
  std::vector<std::uint64_t> texts_;  ///< in the order of PlanFacts::texts, followed by the text of
                                      ///< the run
  std::vector<SeriesPlace> series_;   ///< in the order of the layout
  std::mutex mutex_;                  ///< for is_checked_, while the first shard is read back
  bool is_checked_ = false;
  std::atomic<bool> is_good_ = true;
};

/// Prepared shards by template and models, each from its third run on: preparing one takes as long
/// as writing two shards. If one cannot be prepared, or fails, HDF5 has to write the shard.
/// Threads: any.
class PreparedShards {
 public:
  PreparedShards(const plan::Plan& plan, const store::PlanFacts& facts)
      : plan_(plan), facts_(facts) {}
  /// As PreparedShard::Write; nullopt also if none is prepared.
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
    std::shared_ptr<PreparedShard> shard;  ///< null before it is prepared, and if it cannot be
  };
  std::map<Key, Entry> shards_;
};

}  // namespace cdb::shards
