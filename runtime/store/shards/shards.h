// Shards: one file for each run, written when the run ends, and merged into the results file.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/store/store.h"

namespace cdb::shards {

/// Writes one shard for each run of a plan. Data that depends only on the plan is computed once, in
/// the constructor: with many runs this takes longer than writing one shard. Refers to plan and
/// provenance. Threads: several may call Write at the same time, for different runs.
class ShardWriter {
 public:
  ShardWriter(const plan::Plan& plan, const store::Provenance& provenance);
  ~ShardWriter();

  /// Writes `folder/<run id>.h5`: under a temporary name, closed, synced, renamed, and the folder
  /// synced; when it returns, the run is safe. Throws StoreError; no file with the final name was
  /// created or changed then.
  void Write(const plan::Run& run, const store::RunResult& result,
             const std::filesystem::path& folder) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

/// For one run: `ShardWriter(plan, provenance).Write(run, result, folder)`.
void WriteShard(const plan::Plan& plan, const plan::Run& run, const store::RunResult& result,
                const store::Provenance& provenance, const std::filesystem::path& folder);

struct ShardInfo {
  std::string run_id;
  std::string plan_sha256;
  store::Outcome outcome;
  std::string omitted, decisions;  ///< as in RunResult
};
/// Throws StoreError for a file that is not an intact shard (truncated, not HDF5, another schema
/// version).
ShardInfo ReadShardInfo(const std::filesystem::path& file);

/// Merges `shards`, which are folders of them or single files, into `out` (of a run that is present
/// twice, the first): under a temporary name, verified against the shards, synced, renamed. Runs
/// without a shard are taken from `base` if given, a results file of the same plan that may be
/// `out`; else their cells have the status `missing`. The shards are left unchanged. Throws
/// StoreError; `out` is then unchanged.
void Merge(const plan::Plan& plan, const store::Provenance& provenance,
           const std::vector<std::filesystem::path>& shards, const std::filesystem::path& out,
           const std::filesystem::path& base = {});
void Merge(const plan::Plan& plan, const store::Provenance& provenance,
           const std::filesystem::path& folder, const std::filesystem::path& out);

/// True if every run of the plan, and every reference, has a file of its name in `shards`, which
/// are given as for Merge.
bool HasAllShards(const plan::Plan& plan, const std::vector<std::filesystem::path>& shards);

}  // namespace cdb::shards
