// Shards without values, which are copied for each shard: creating its sixty arrays and their
// attributes takes HDF5 longer than writing the values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/store/hdf5/file.h"
#include "runtime/store/layout.h"
#include "runtime/store/run_facts.h"
#include "runtime/store/store.h"

namespace cdb::shards {

struct ShardTemplate {
  store::Layout layout;
  std::vector<std::byte> image;  ///< HDF5, without `models` in /provenance
};

/// Templates of the shards of one plan, which must outlive it, as must facts and provenance. Runs
/// with the same labels on text axes share one. Threads: any.
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
  mutable std::map<std::vector<std::size_t>, std::shared_ptr<const ShardTemplate>> templates_;
};

/// Writes into a copy of a template the attributes specific to the shard of `run`. Throws
/// hdf5::Error.
void WriteHeadOfRun(hdf5::File& file, const plan::Run& run);
/// Writes into a copy of a template the data specific to the shard of `run`, except the run's
/// values: its id, its numeric coordinates, and the date. Throws hdf5::Error.
void WritePlace(hdf5::File& file, const plan::Plan& plan, const store::PlanFacts& facts,
                const plan::Run& run);

}  // namespace cdb::shards
