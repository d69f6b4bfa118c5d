// The launcher used outside of tests: one process for each run, by the worker program of the run's
// precision.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/analysis/trace.h"
#include "compiler/plan/plan.h"
#include "compiler/yaml/plan_yaml.h"
#include "runtime/protocol/fork_server.h"
#include "runtime/protocol/trace_memory.h"
#include "runtime/sweep/process/launcher.h"
#include "runtime/sweep/process/process.h"
#include "runtime/sweep/process/stop.h"

namespace cdb::process {

// Starts workers by forking them from a worker program that is already loaded.

/// A process of a worker program that answers protocol::ForkRequest. Ended on destruction; workers
/// that it started continue. Not thread-safe.
class ForkServer {
 public:
  /// Throws ScheduleError if the program cannot be started.
  explicit ForkServer(const std::filesystem::path& program);
  ~ForkServer();
  ForkServer(const ForkServer&) = delete;
  ForkServer& operator=(const ForkServer&) = delete;

  /// Returns no worker if the program or the system does not support it.
  protocol::ForkAnswer Start(const protocol::ForkRequest& request);
  pid_t pid() const { return pid_; }

 private:
  Descriptor socket_;
  pid_t pid_ = -1;
};

// Caches traces: each file is read once for all runs that need it.

/// Keeps the most recent traces. A worker has a copy of the descriptor, which keeps its trace
/// alive. Not thread-safe.
class TraceCache {
 public:
  explicit TraceCache(std::size_t places) : places_(places) {}

  /// The descriptor of the trace, valid until it has been displaced by others. Throws StoreError,
  /// std::system_error.
  int Get(const analysis::TraceName& name);

 private:
  std::size_t places_;
  std::list<std::pair<analysis::TraceName, protocol::TraceMemory>>
      traces_;  ///< the most recently requested first
};

/// The worker programs, and Valgrind; a path is empty if no run of the plan needs it.
struct WorkerPrograms {
  std::filesystem::path single;   ///< cdb-worker-f32
  std::filesystem::path double_;  ///< cdb-worker-f64
  std::filesystem::path valgrind = {};
};

/// Finds the programs that the plan needs: beside this program, then in ../libexec/cdb of its
/// folder. Throws ScheduleError, which names the places searched and the remedy.
WorkerPrograms FindWorkers(const plan::Plan& plan);
/// The same for a program in `folder`.
WorkerPrograms FindWorkers(const plan::Plan& plan, const std::filesystem::path& folder);

/// The end of a worker's standard error, for the message of a crash: at most kMaxBytes, however
/// long the text.
class TextTail {
 public:
  static constexpr std::size_t kMaxBytes = 8192;
  void Append(std::string_view text);
  /// The last lines, at most five, printable: other bytes become `?` (text::Printable).
  std::string LastLines() const;

 private:
  std::string text_;
};

/// Runs workers as processes, forked from a loaded worker program, or started directly if that
/// fails. Standard input is empty, standard output is dropped, standard error is kept for the
/// message. Each worker has its own process group, so that Ctrl-C reaches only this process. A
/// run's timeout ends its worker with SIGKILL, and its memory limit is set before its own code
/// runs. The worker of each slot stays on one processor (ClaimedProcessors), unless its detector
/// may use several threads.
class ProcessLauncher : public Launcher {
 public:
  /// `stop` may be null. `claim`: of ClaimedProcessors.
  ProcessLauncher(WorkerPrograms programs, std::size_t slots, const StopFlag* stop,
                  std::string_view claim = kProcessorClaim);
  ~ProcessLauncher() override;

  void Start(std::size_t slot, const plan::Run& run, const std::string& kept) override;
  std::optional<Ending> Wait(double seconds) override;
  Pulse PulseOf(std::size_t slot) const override;
  void StopAll() override;

  /// Runs that start from now on record the input of their narrow phase (Ending::narrow_input).
  void RecordNarrowInput() { records_narrow_input_ = true; }

 private:
  struct Worker;
  /// Starts a worker that no server forks.
  static pid_t StartDirectly(const std::filesystem::path& program, SpawnPlan& spawn,
                             protocol::ForkRequest how);
  /// -1 if the recording must be made anew, because a process that has ended may have used it.
  pid_t StartProcess(const std::filesystem::path& program, bool has_fixed_addresses,
                     SpawnPlan& spawn, protocol::ForkRequest how);
  /// Starts a worker whose clock is Valgrind's count of its instructions.
  pid_t StartCounted(const std::filesystem::path& program, SpawnPlan& spawn,
                     protocol::ForkRequest how) const;
  std::vector<pid_t> Processes() const;
  void DrainErrors(Worker& worker);
  /// Creates new descriptors and starts the process. Throws ScheduleError.
  void Launch(Worker& worker, const std::vector<std::string>& arguments);
  bool TryToLaunch(Worker& worker, std::vector<std::string> arguments);
  /// Starts a worker again whose process has ended with that request; at most once.
  bool StartAgain(Worker& worker);
  /// None if it was started again.
  std::optional<Ending> Reap(Worker& worker);

  WorkerPrograms programs_;
  yaml::RunText text_{""};
  const StopFlag* stop_;
  bool records_narrow_input_ = false;
  TraceCache traces_;
  const ClaimedProcessors processors_;
  /// For each program that was started, and whether its addresses are fixed; null if it cannot fork
  /// workers.
  std::map<std::pair<std::filesystem::path, bool>, std::unique_ptr<ForkServer>> servers_;
  std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace cdb::process
