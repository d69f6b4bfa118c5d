// The scheduler's interface to the system: starts a run, and waits for its end. Tests replace it by
// a fake.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "compiler/plan/input_file.h"
#include "compiler/plan/plan.h"
#include "runtime/protocol/recording.h"
#include "runtime/results/store.h"

namespace cdb::process {

/// An environment error (no worker program, cannot fork, a folder of another plan). The message
/// names the cause, what was kept and the remedy. Exit status 2.
class ScheduleError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The ending of a run. `result.series` point into `recording`, so both are kept until the run is
/// written.
struct Ending {
  std::size_t slot = 0;
  double wall_s = 0;  ///< from start to end of the worker
  results::RunResult result;
  std::unique_ptr<protocol::Recording> recording;
  plan::Descriptor narrow_input{};  ///< if the launcher records it (TraceOfPairs)
};

/// Progress of a running worker.
struct Pulse {
  std::uint64_t cycles = 0;   ///< recorded so far
  std::string plugin_call;    ///< the current call into a plug-in; empty
                              ///< for none
  std::string settling = {};  ///< progress of settling piles; empty if none
                              ///< settles
};

/// Executes runs, one per slot. Not thread-safe.
class Launcher {
 public:
  /// Ends the runs that are still executing.
  virtual ~Launcher() = default;

  /// Starts `run` in a free slot; `run` must outlive it. `kept`: names of components, separated by
  /// spaces, that it must not omit. Throws ScheduleError.
  virtual void Start(std::size_t slot, const plan::Run& run, const std::string& kept) = 0;

  /// The next run that ended. None if `seconds` pass first or the user requests a stop; a run that
  /// has already ended is returned even then.
  virtual std::optional<Ending> Wait(double seconds) = 0;

  /// The progress of the run in an occupied slot.
  virtual Pulse PulseOf(std::size_t /*slot*/) const { return {}; }

  /// Ends all running runs and forgets them.
  virtual void StopAll() = 0;
};

// Collects the result of a worker from its recording and the ending of its process.

/// The ending of a process.
struct ProcessEnd {
  int wait_status = 0;        ///< as returned by waitpid
  bool is_timed_out = false;  ///< killed by the runner
  std::string last_lines;     ///< of its standard error; may be empty
};

/// Collects status, message, omissions, number of cycles, series (which point into `recording`) and
/// contacts. If a worker failed, the values of the cycle that it did not finish are reset to "no
/// value". `contacts_fd` is the file of ContactRecords. Throws std::system_error if it cannot be
/// read. The caller sets the fields for time and machine.
results::RunResult Collect(const plan::Run& run, const ProcessEnd& end,
                           protocol::Recording& recording, int contacts_fd);

}  // namespace cdb::process
