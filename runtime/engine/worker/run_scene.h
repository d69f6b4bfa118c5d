// Executes one run, from its plan to its recording: the work of the worker process as a function.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "compiler/plan/plan.h"
#include "runtime/engine/world/engine.h"
#include "runtime/engine/world/omission_guard.h"
#include "runtime/engine/world/timed_world.h"
#include "runtime/protocol/recording.h"

namespace cdb::worker {

/// Components that a run keeps although it could omit them.
struct Kept {
  std::string names;  ///< separated by spaces
  std::string why;
};

/// Files to which a run appends values whose number varies; -1: none.
struct Streams {
  int contacts_fd = -1;      ///< of ContactRecords, if the scene records them
  int narrow_input_fd = -1;  ///< probes::NarrowInput; the scene must not record timing or counters
};

/// Draws and places the objects, decides the omissions, builds the world, runs the warm-up and
/// every cycle, and fills `recording`. If the scene requests errors, or both timing and pairs, it
/// is then run a second time from the start, without a clock, to record them. A reference is run
/// only for its samples. `peak_rss_bytes` covers the process from the building of the world to the
/// end of the first run.
/// `cycles_done` is incremented after each recorded cycle is stored. The outcome is kDone with the
/// state hash, or kFailed with a message. The only exception that a scene can cause is
/// OmissionGuardTripped: the run must then be restarted in a new process that keeps the walls, with
/// the recording cleared. Returns the final world, or null if it was never built; destroying it can
/// take longer than many cycles, so a worker that exits leaves it to the system. If the run has
/// plug-ins, the process is confined before their code runs (confinement.h).
std::unique_ptr<world::Engine> RunScene(const plan::Run& run, protocol::Recording& recording,
                                        Streams streams, const Kept& kept = {});

/// Throws std::runtime_error if a pass without a clock did not end in the state of the timed one.
void RequireSameState(const std::string& hash, protocol::Recording& recording);
/// Sets kFailed and the message, truncated to the size of the field.
void ReportFailure(protocol::Recording& recording, const std::string& message);

// Measurement overhead.

/// Measurement overhead of a cycle in nanoseconds: the time stamps of a TimedWorld, and the calls
/// of a detector that does nothing. The median of 101 measurements; does not change the engine's
/// world.
double HarnessNs(const plan::Scene& scene, const world::Engine& engine);

/// The median time of 101 calls, ns: an overhead is too short to be measured once.
template <typename Call>
double MedianNs(const Call& call) {
  std::array<double, 101> times;
  for (double& time : times) {
    const std::int64_t begin = world::Now();
    call();
    time = static_cast<double>(world::Now() - begin);
  }
  std::ranges::nth_element(times, times.begin() + times.size() / 2);
  return times[times.size() / 2];
}

}  // namespace cdb::worker
