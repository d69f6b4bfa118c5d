// Starts worker processes: file descriptors, signals, and messages about how a process ended.
#pragma once

#include <spawn.h>
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/plan/descriptor.h"

namespace cdb::process {

/// What a worker gets are copies.
using plan::Descriptor;

/// A file without a name. Throws ScheduleError.
Descriptor MemoryFile(const char* name);

/// Becomes readable when the process has ended. Throws ScheduleError.
Descriptor WatchProcess(pid_t pid);

/// What a worker is started with: standard input empty, standard output dropped unless it is given,
/// no signal ignored or blocked, a process group of its own. Throws ScheduleError.
class SpawnPlan {
 public:
  SpawnPlan();
  ~SpawnPlan();
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;

  /// A copy of `from`, as `to` over there.
  void Give(int from, int to);
  /// A variable of its environment beside ours: `NAME=value`.
  void SetVariable(std::string variable) { variables_.push_back(std::move(variable)); }
  /// What was given.
  std::vector<std::pair<int, int>> Given() const;
  /// Nothing beside what was given is open over there.
  pid_t Start(const std::filesystem::path& program, std::vector<std::string> arguments = {});

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
  std::vector<Descriptor> sources_;
  std::vector<int> targets_;  ///< of each source
  std::vector<std::string> variables_;
  int last_ = 2;  ///< the highest that is given, or standard error
};

/// Kills and reaps the children of this thread that run `program`, except those in `known`. Where
/// the system lists no children, nothing happens.
void EndOrphans(const std::filesystem::path& program, const std::vector<pid_t>& known);

/// `was ended by signal 11 (SIGSEGV, Segmentation fault)`, `ended with exit status 3`.
std::string EndText(int wait_status);

/// The world refused. Throws ScheduleError: what, and the system's words for `error`.
[[noreturn]] void FailToStart(std::string_view what, int error);

}  // namespace cdb::process
