// Follows a sweep on a cluster until its jobs have ended, by the shards in its folder and by Slurm.
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

/// Counts the runs that have a shard.
class ShardCount {
 public:
  /// `plan`: lists its runs, or has a `whole`.
  ShardCount(const plan::Plan& plan, std::filesystem::path folder);
  /// Reads the folder. A shard that cannot be read yet is counted by a later call; one that has
  /// been merged and removed stays counted.
  void Update();

  std::size_t ended() const { return ended_; }
  std::size_t total() const { return total_; }
  std::size_t bad() const {
    return bad_;
  }  ///< failed runs among the shards that appeared after
     ///< the first Update()

 private:
  const std::filesystem::path folder_;
  std::size_t total_ = 0, ended_ = 0, bad_ = 0;
  bool is_first_ = true;
  std::set<std::string, std::less<>> seen_;  ///< ids of the runs
};

/// Returns when Slurm has no more tasks of the jobs, or when `stop` requests it. `output`: a
/// progress bar or lines; not used if `is_quiet`. If Slurm does not answer, waits and prints a
/// message. Throws SlurmError if there is no squeue, StoreError.
void Follow(const plan::Plan& plan, const std::filesystem::path& shards,
            const Submission& submission, const process::StopFlag& stop,
            const schedule::ProgressOutput& output, bool is_quiet);

}  // namespace cdb::cluster
