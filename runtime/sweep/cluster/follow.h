// Follows a sweep on a cluster until its jobs have ended, by the journals in its folder and by
// Slurm.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <unordered_set>

#include "compiler/plan/plan.h"
#include "runtime/sweep/cluster/submission.h"
#include "runtime/sweep/process/stop.h"
#include "runtime/sweep/schedule/progress.h"

namespace cdb::cluster {

/// Counts the runs that have finished.
class RunCount {
 public:
  /// `plan`: lists its runs, or has a `whole`.
  RunCount(const plan::Plan& plan, std::filesystem::path folder);
  /// Reads the journals. One that cannot be read now is read by a later call; runs that have been
  /// merged and removed stay counted.
  void Update();

  std::size_t ended() const { return ended_; }
  std::size_t total() const { return total_; }
  /// Failed runs among those that appeared after the first Update().
  std::size_t bad() const { return bad_; }

 private:
  const std::filesystem::path folder_;
  std::size_t total_ = 0, ended_ = 0, bad_ = 0;
  bool is_first_ = true;
  std::unordered_set<std::string> seen_;                    ///< ids of the runs
  std::map<std::filesystem::path, std::int64_t> last_row_;  ///< that was read, of each journal
};

/// Returns when Slurm has no more tasks of the jobs, or when `stop` requests it. `output`: a
/// progress bar or lines; not used if `is_quiet`. If Slurm does not answer, waits and prints a
/// message. Throws std::runtime_error if there is no squeue, StoreError.
void Follow(const plan::Plan& plan, const std::filesystem::path& folder,
            const Submission& submission, const process::StopFlag& stop,
            const schedule::ProgressOutput& output, bool is_quiet);

}  // namespace cdb::cluster
