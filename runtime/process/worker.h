// The launcher used outside of tests: one process for each run, with the worker program of its
// precision.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "compiler/yaml/plan_yaml_writer.h"
#include "runtime/process/fork_server.h"
#include "runtime/process/launcher.h"
#include "runtime/process/processors.h"
#include "runtime/process/stop.h"
#include "runtime/process/trace_cache.h"

namespace cdb::process {

/// The worker programs; empty where no run of the plan needs it.
struct WorkerPrograms {
  std::filesystem::path single;   ///< cdb-worker-f32
  std::filesystem::path double_;  ///< cdb-worker-f64
};

/// Looks beside this program, then in ../libexec/cdb of its folder, for what the plan needs. Throws
/// ScheduleError, which says where it looked and what to do.
WorkerPrograms FindWorkers(const plan::Plan& plan);
/// The same for a program in `folder`.
WorkerPrograms FindWorkers(const plan::Plan& plan, const std::filesystem::path& folder);

/// The end of what a worker wrote to standard error, for the message of a crash: at most
/// kMaxBytes, however much was written.
class TextTail {
 public:
  static constexpr std::size_t kMaxBytes = 8192;
  void Append(std::string_view text);
  /// The last lines, at most five, printable: other bytes become `?` (dsl::Printable).
  std::string LastLines() const;

 private:
  std::string text_;
};

/// Runs workers as processes, forked from one of their program that is loaded already, or started
/// if that cannot be: standard input empty, standard output dropped, standard error kept for the
/// message, each in a process group of its own so that Ctrl-C reaches only us. A run's timeout ends
/// its worker with SIGKILL, and its memory limit is set before its own code runs. Each
/// slot's worker stays on a processor of its own (ClaimedProcessors), unless its detector may use
/// several threads.
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

 private:
  struct Worker;
  /// -1 if what was given must be made anew: a process that is no more may have used it.
  pid_t StartProcess(const std::filesystem::path& program, SpawnPlan& spawn,
                     measure::ForkRequest how);
  std::vector<pid_t> Processes() const;
  void DrainErrors(Worker& worker);
  /// Gives it new descriptors and starts its process. Throws ScheduleError.
  void Launch(Worker& worker, const std::vector<std::string>& arguments);
  bool TryToLaunch(Worker& worker, const std::vector<std::string>& arguments);
  /// A worker whose process has ended, if that asked for it; once.
  bool StartAgain(Worker& worker);
  /// None if it was started again.
  std::optional<Ending> Reap(Worker& worker);

  WorkerPrograms programs_;
  yaml::RunText text_{""};
  const StopFlag* stop_;
  TraceCache traces_;
  const ClaimedProcessors processors_;
  /// Of each program that was started; null if it cannot serve.
  std::map<std::filesystem::path, std::unique_ptr<ForkServer>> servers_;
  std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace cdb::process
