// Watches a sweep on a cluster until its jobs have ended: by the shards in its folder, and by
// Slurm.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>

#include "compiler/plan/plan.h"
#include "runtime/cluster/submission.h"
#include "runtime/process/stop.h"
#include "runtime/schedule/progress_bar.h"

namespace cdb::cluster {

/// Runs that have a shard.
class ShardCount {
 public:
  /// `plan`: lists its runs, or has a `whole`.
  ShardCount(const plan::Plan& plan, std::filesystem::path folder);
  /// Looks into the folder. A shard that cannot be read yet counts the next time; one that is gone,
  /// because it was merged, still counts.
  void Update();

  std::size_t ended() const { return ended_; }
  std::size_t total() const { return total_; }
  std::size_t bad() const { return bad_; }  ///< of those that came while this looked

 private:
  const std::filesystem::path folder_;
  std::size_t total_ = 0, ended_ = 0, bad_ = 0;
  bool is_first_ = true;
  std::set<std::string, std::less<>> seen_;  ///< ids
};

/// Returns when Slurm has no task of the jobs any more, or when `stop` asks for it. `output`: the
/// bar, or lines; not used where `is_quiet`. Where Slurm does not answer, waits and says so. Throws
/// SlurmError where there is no squeue, StoreError.
void Follow(const plan::Plan& plan, const std::filesystem::path& shards,
            const Submission& submission, const process::StopFlag& stop,
            const schedule::ProgressOutput& output, bool is_quiet);

}  // namespace cdb::cluster
