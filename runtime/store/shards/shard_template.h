// Shards without the values of a run, which are copied for each shard: creating its sixty arrays
// and their attributes takes HDF5 longer than writing the values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/store/hdf5/file.h"
#include "runtime/store/layout.h"
#include "runtime/store/layout_file.h"
#include "runtime/store/run_facts.h"
#include "runtime/store/store.h"

namespace cdb::shards {

struct ShardTemplate {
  store::Layout layout;
  std::vector<std::byte> image;  ///< HDF5, without `models` in /provenance
};

/// Templates of the shards of one plan, which must outlive it, as must facts and provenance.
/// Threads: any.
class ShardTemplates {
 public:
  ShardTemplates(const plan::Plan& plan, const store::PlanFacts& facts,
                 const store::Provenance& provenance)
      : plan_(plan), facts_(facts), provenance_(provenance) {}

  /// `rows`: number of rows of contacts. Throws hdf5::Error.
  std::shared_ptr<const ShardTemplate> Get(const plan::Run& run, std::uint64_t rows) const;

 private:
  const plan::Plan& plan_;
  const store::PlanFacts& facts_;
  const store::Provenance& provenance_;
  mutable std::mutex mutex_;
  mutable std::map<std::uint64_t, std::shared_ptr<const ShardTemplate>> templates_;  ///< by rows
};

/// The attributes of the file that differ between runs, with their names.
store::HeadTexts HeadOfRun(const plan::Run& run);

/// A coordinate with one value, which differs between runs.
struct RunCoordinate {
  std::string dataset;     ///< including its group
  const plan::Axis* axis;  ///< of the plan; null for `rep`
};
std::vector<RunCoordinate> RunCoordinates(const plan::Plan& plan, const store::PlanFacts& facts);
plan::Coordinate ValueOf(const RunCoordinate& coordinate, const plan::Plan& plan,
                         const plan::Run& run);
/// The coordinates of text that do not differ between runs, such as `phase`.
std::vector<const store::Dimension*> Labels(const store::Layout& layout,
                                            std::span<const RunCoordinate> coordinates);

// Both write into a copy of a template, and throw hdf5::Error.

void WriteHeadOfRun(hdf5::File& file, const plan::Run& run);
/// Writes all coordinates that a template lacks.
void WriteCoordinates(hdf5::File& file, const plan::Plan& plan, const store::PlanFacts& facts,
                      const store::Layout& layout, const plan::Run& run);

}  // namespace cdb::shards
