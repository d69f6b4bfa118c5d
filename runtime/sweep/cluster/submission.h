// The record of jobs submitted for a sweep: a request in its journal, by which the same command
// follows the jobs or continues after them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/input_file.h"

namespace cdb::cluster {

struct Submission {
  std::string plan_sha256;
  std::uint64_t tasks = 1;   ///< parts of the plan
  std::string array, merge;  ///< ids of the jobs; `merge` equals `array` until there is a merge job
};

/// Nullopt if there is none, or if it is damaged.
std::optional<Submission> ReadSubmission(const std::filesystem::path& folder);
/// Throws StoreError.
void WriteSubmission(const Submission& submission, const std::filesystem::path& folder);
/// Keeps other cdb processes from submitting to the same folder. Starting tasks ignore it.
class SubmissionLock {
 public:
  explicit SubmissionLock(const std::filesystem::path& folder);
  /// False while another cdb submits. True if the file system does not support locks.
  bool is_held() const { return is_held_; }

 private:
  plan::Descriptor file_;
  bool is_held_ = true;
};

/// Removes the lock and the logs of the jobs; the submission is removed with its journal.
void RemoveSubmission(const std::filesystem::path& folder);

// The two jobs of a sweep on a Slurm cluster: an array whose tasks each execute a part of the
// plan, and a merge job after it. Source of the options: sbatch(1), Slurm 22.05.

/// Options for Slurm from the command line.
struct JobOptions {
  std::string partition, time, account;  ///< in the syntax of sbatch; empty: the cluster's default
  bool is_exclusive = false;             ///< each task has a node to itself
  std::vector<std::string> more;         ///< further options of sbatch, passed on unchanged
};

/// Absolute paths on a file system that every node sees.
struct SweepFiles {
  std::filesystem::path program;  ///< cdb
  std::filesystem::path folder;   ///< current folder, to which paths in a plan are relative
  std::filesystem::path runs;     ///< folder of the journals
  std::filesystem::path plan;     ///< plan file in that folder
  std::filesystem::path out;
};

struct Sweep {
  std::string name;  ///< name of the benchmark
  SweepFiles files;
  std::uint64_t tasks = 1;             ///< parts of the plan
  std::uint64_t threads = 1;           ///< most threads of any run
  std::vector<std::uint64_t> missing;  ///< parts to execute, ascending, from 1
};

/// A job: the arguments of `sbatch`, and the script that it reads from standard input.
struct Job {
  std::vector<std::string> words;
  std::string script;
};

/// Throws std::invalid_argument for a path that a script cannot contain (a line break).
Job ArrayJob(const Sweep& sweep, const JobOptions& options);
/// `array`: the id of the array. The merge begins when all tasks of the array have ended, even if
/// some failed.
Job MergeJob(const Sweep& sweep, const JobOptions& options, const std::string& array);

/// `1-3,7`: the format of `--array`.
std::string IndexList(const std::vector<std::uint64_t>& indices);

/// A shell script that submits both. `make_plan`: the command that writes the plan into the folder
/// of journals.
std::string DryRunText(const Sweep& sweep, const JobOptions& options, const std::string& make_plan);

/// The name of the log of a task of an array, in the folder of journals.
std::string LogName(const std::string& array, std::uint64_t task);
/// True if `name` is the log of a task or of a merge.
bool IsLogName(const std::string& name);

}  // namespace cdb::cluster
