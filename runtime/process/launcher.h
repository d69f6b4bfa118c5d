// The scheduler's interface to the system: start a run, and wait for its end. Tests replace it by a
// fake.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "compiler/plan/plan.h"
#include "runtime/measure/recording.h"
#include "runtime/store/store.h"

namespace cdb::process {

/// Environment error (no worker program, cannot fork, a folder of another plan). The message names
/// the cause, what was kept and the remedy. Exit status 2.
class ScheduleError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// How a run ended. `result.series` point into `recording`, so both are kept until the shard is
/// written.
struct Ending {
  std::size_t slot = 0;
  double wall_s = 0;  ///< from start to end of the worker
  store::RunResult result;
  std::unique_ptr<measure::Recording> recording;
};

/// How far a running worker has got.
struct Pulse {
  std::uint64_t cycles = 0;   ///< recorded
  std::string plugin_call;    ///< in which it is (measure/plugin_call.h); empty for none
  std::string settling = {};  ///< how its piles settle (measure/settling.h); empty if they do not
};

/// Carries out runs, one a slot. Not for several threads.
class Launcher {
 public:
  /// Ends what is still running.
  virtual ~Launcher() = default;

  /// Starts `run` in a slot that is free; `run` outlives it. `kept`: names of components, separated
  /// by spaces, that it must not leave out. Throws ScheduleError.
  virtual void Start(std::size_t slot, const plan::Run& run, const std::string& kept) = 0;

  /// The next run that ended. None where `seconds` passed first or the user asked to stop; a run
  /// that has ended by then is handed out before a stop is heeded.
  virtual std::optional<Ending> Wait(double seconds) = 0;

  /// Of the run in a slot that is taken.
  virtual Pulse PulseOf(std::size_t /*slot*/) const { return {}; }

  /// Ends all that is running and forgets it.
  virtual void StopAll() = 0;
};

}  // namespace cdb::process
