// Shards: one file for each run, written when the run ends, and merged into the results file.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/store/store.h"

namespace cdb::shards {

/// Writes one shard for each run of a plan. What follows from the plan alone is worked out once, in
/// the constructor: where there are many runs it takes longer than writing one. Holds references to
/// plan and provenance. Threads: Write may be called by several at once, for different runs.
class ShardWriter {
 public:
  ShardWriter(const plan::Plan& plan, const store::Provenance& provenance);
  ~ShardWriter();

  /// Writes `folder/<run id>.h5`: under a temporary name, closed, fsynced, renamed, and the folder
  /// fsynced; when it returns the run is safe. Throws StoreError; then no file of the final name
  /// was made or changed.
  void Write(const plan::Run& run, const store::RunResult& result,
             const std::filesystem::path& folder) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

/// `ShardWriter(plan, provenance).Write(run, result, folder)`: for one run.
void WriteShard(const plan::Plan& plan, const plan::Run& run, const store::RunResult& result,
                const store::Provenance& provenance, const std::filesystem::path& folder);

struct ShardInfo {
  std::string run_id;
  std::string plan_sha256;
  store::Outcome outcome;
  std::string omitted, decisions;  ///< as in RunResult
};
/// Throws StoreError for what is not a whole shard (truncated, not HDF5, another schema version).
ShardInfo ReadShardInfo(const std::filesystem::path& file);

/// Makes `out` from `shards`, folders of them or single files (of a run that stands twice, the
/// first): under a temporary name, verified against the shards, fsynced, renamed. Runs without a
/// shard are as in `base`, a results file of the same plan that may be `out`, where that is given,
/// else cells with status `missing`. The shards are left alone. Throws StoreError; then `out` is as
/// before.
void Merge(const plan::Plan& plan, const store::Provenance& provenance,
           const std::vector<std::filesystem::path>& shards, const std::filesystem::path& out,
           const std::filesystem::path& base = {});
void Merge(const plan::Plan& plan, const store::Provenance& provenance,
           const std::filesystem::path& folder, const std::filesystem::path& out);

/// Every run of the plan, and every reference, has a file of its name in `shards`, which are as
/// Merge takes them.
bool HasAllShards(const plan::Plan& plan, const std::vector<std::filesystem::path>& shards);

}  // namespace cdb::shards
