// Interface to Slurm through its programs sbatch, squeue, sinfo, scontrol and sacct. Source of
// options and formats: their manual pages of Slurm 22.05.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "runtime/sweep/cluster/submission.h"

namespace cdb::cluster {

// If a program of Slurm is missing or fails, std::runtime_error names it, quotes its output and
// gives the remedy.

/// Throws if there is no sbatch.
void RequireSlurm();

/// Returns the id of the job. Throws if sbatch refuses it.
std::string Submit(const Job& job);
/// Cancels a job; errors are ignored.
void Cancel(const std::string& id);

/// Tasks of jobs that have not ended.
struct ActiveTasks {
  std::uint64_t running = 0;  ///< including those that are starting or ending
  std::uint64_t waiting = 0;
  std::string reason;  ///< why one waits, in the words of Slurm; may be empty
  std::uint64_t count() const { return running + waiting; }
};
/// Nullopt if Slurm does not answer now, with the reason in `why`. Throws if there is no squeue.
std::optional<ActiveTasks> FindActive(const std::string& array, const std::string& merge,
                                      std::string& why);

/// The tasks of an array that failed, with their state (`FAILED`, `TIMEOUT`, `NODE_FAIL`), as far
/// as Slurm still knows: from sacct, which needs accounting, else from squeue.
std::map<std::uint64_t, std::string> FindFailures(const std::string& array);

struct Capacity {
  std::uint64_t cores = 0;          ///< of a partition; 0: unknown
  std::uint64_t most_tasks = 1000;  ///< largest number of tasks of an array
};
/// `partition`: empty for the default one. Values that Slurm does not report keep the defaults
/// above.
Capacity FindCapacity(const std::string& partition);

}  // namespace cdb::cluster
