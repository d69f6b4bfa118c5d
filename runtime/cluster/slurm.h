// Slurm, by its own programs: sbatch, squeue, sinfo, scontrol, sacct. Source of options and
// formats: their manual pages of Slurm 22.05.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

#include "runtime/cluster/job_script.h"

namespace cdb::cluster {

/// A program of Slurm is missing or refused: the message names it, its words and the remedy. Exit
/// status 2.
class SlurmError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws SlurmError where there is no sbatch.
void RequireSlurm();

/// Returns the id of the job. Throws SlurmError.
std::string Submit(const Job& job);
/// Takes back what is not wanted any more; errors are ignored.
void Cancel(const std::string& id);

/// Tasks of jobs that have not ended.
struct ActiveTasks {
  std::uint64_t running = 0;  ///< with those that are starting or ending
  std::uint64_t waiting = 0;
  std::string reason;  ///< why one waits, in the words of Slurm; may be empty
  std::uint64_t count() const { return running + waiting; }
};
/// Nullopt where Slurm does not answer now, and `why` says why. Throws SlurmError where there is
/// no squeue.
std::optional<ActiveTasks> FindActive(const std::string& array, const std::string& merge,
                                      std::string& why);

/// How tasks of an array ended that did not end well (`FAILED`, `TIMEOUT`, `NODE_FAIL`), as far as
/// Slurm still knows: by sacct, which needs accounting, else by squeue.
std::map<std::uint64_t, std::string> FindFailures(const std::string& array);

struct Capacity {
  std::uint64_t cores = 0;          ///< of a partition; 0: not known
  std::uint64_t most_tasks = 1000;  ///< of an array
};
/// `partition`: empty for the default one. What Slurm does not say is as above.
Capacity FindCapacity(const std::string& partition);

}  // namespace cdb::cluster
