// The two jobs of a sweep on a Slurm cluster: an array whose tasks each execute a shard of the
// plan, and the merge after it. Source of the options: sbatch(1), Slurm 22.05.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace cdb::cluster {

/// What the user asks of Slurm beside the sweep.
struct JobOptions {
  std::string partition, time, account;  ///< as sbatch takes them; empty: the cluster's default
  bool is_exclusive = false;             ///< a task has its node to itself
  std::vector<std::string> more;         ///< options of sbatch, as they are
};

/// Files, all on a file system that every node sees. Absolute.
struct SweepFiles {
  std::filesystem::path program;  ///< cdb
  std::filesystem::path folder;   ///< the current one, which paths in a plan are relative to
  std::filesystem::path shards;   ///< folder of the shards
  std::filesystem::path plan;     ///< in it
  std::filesystem::path out;
};

struct Sweep {
  std::string name;  ///< the benchmark
  SweepFiles files;
  std::uint64_t tasks = 1;             ///< parts of the plan
  std::uint64_t threads = 1;           ///< of the run with the most
  std::vector<std::uint64_t> missing;  ///< parts to be executed, ascending, from 1
};

/// A job: the words of `sbatch` and the script that it reads from standard input.
struct Job {
  std::vector<std::string> words;
  std::string script;
};

/// Throws std::invalid_argument for a path that a script cannot hold (a line break).
Job ArrayJob(const Sweep& sweep, const JobOptions& options);
/// `array`: the id of the array; the merge begins when all its tasks have ended, well or not.
Job MergeJob(const Sweep& sweep, const JobOptions& options, const std::string& array);

/// `1-3,7`: as `--array` takes it.
std::string IndexList(const std::vector<std::uint64_t>& indices);

/// A shell script that submits both. `make_plan`: the command that writes the plan into the folder
/// of shards.
std::string DryRunText(const Sweep& sweep, const JobOptions& options, const std::string& make_plan);

/// The log of an array's task, in the folder of shards.
std::string LogName(const std::string& array, std::uint64_t task);
/// `name` is the log of a task or of a merge.
bool IsLogName(const std::string& name);

}  // namespace cdb::cluster
