// Starts worker processes: file descriptors, signals, and messages about the ending of a process.
#pragma once

#include <spawn.h>
#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/plan/input_file.h"

namespace cdb::process {

/// A worker gets copies of descriptors.
using plan::Descriptor;

/// An anonymous file. Throws ScheduleError.
Descriptor MemoryFile(const char* name);

/// An anonymous file with this content, which nobody can change. Throws ScheduleError.
Descriptor SealedFile(const char* name, std::string_view content);

/// A descriptor that becomes readable when the process has ended. Throws ScheduleError.
Descriptor WatchProcess(pid_t pid);

/// The setup of a worker: standard input is empty, standard output is dropped unless it is given,
/// no signal is ignored or blocked, and the worker has its own process group. Throws ScheduleError.
class SpawnPlan {
 public:
  SpawnPlan();
  ~SpawnPlan();
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;

  /// Gives the worker a copy of `from`, with the number `to`.
  void Give(int from, int to);
  /// Adds a variable to the environment that the worker inherits: `NAME=value`.
  void SetVariable(std::string variable) { variables_.push_back(std::move(variable)); }
  /// The descriptors given so far, and their numbers in the worker.
  std::vector<std::pair<int, int>> Given() const;
  /// The worker has no open descriptors other than those that were given.
  pid_t Start(const std::filesystem::path& program, std::vector<std::string> arguments = {});

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
  std::vector<Descriptor> sources_;
  std::vector<int> targets_;  ///< number in the worker, for each source
  std::vector<std::string> variables_;
  int last_ = 2;  ///< the highest number given, or that of standard error
};

/// Kills and reaps the children of this thread that run `program`, except those in `known`. Has no
/// effect if the system does not list children.
void EndOrphans(const std::filesystem::path& program, const std::vector<pid_t>& known);

/// `was ended by signal 11 (SIGSEGV, Segmentation fault)`, `ended with exit status 3`.
std::string EndText(int wait_status);

/// An environment error. Throws ScheduleError with `what` and the system's message for `error`.
[[noreturn]] void FailToStart(std::string_view what, int error);

// Assigns a processor to each slot of a runner.

inline constexpr std::string_view kProcessorClaim = "cdb-processor";

/// Processors on which no other runner of this machine measures: several `cdb run` side by side, as
/// started by GNU parallel, must not share one. A claim is an address in the abstract namespace of
/// Unix sockets, which the system releases when a process is killed. Not thread-safe.
class ClaimedProcessors {
 public:
  /// Claims one processor for each of `slots`, out of those that this thread may run on, from the
  /// last one down: the first ones serve most interrupts. Claims none if too few are free. `name`:
  /// of the claims; tests use different ones.
  explicit ClaimedProcessors(std::size_t slots, std::string_view name = kProcessorClaim);

  /// The processor of a slot; -1 if there is none, and the slot may run anywhere.
  int Of(std::size_t slot) const { return cpus_.empty() ? -1 : cpus_[slot]; }

 private:
  std::vector<int> cpus_;
  std::vector<Descriptor> claims_;
};

}  // namespace cdb::process
