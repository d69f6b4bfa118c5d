// One run from the plan to its recording: what the worker does, as a function.
#pragma once

#include <memory>

#include "compiler/plan/plan.h"
#include "runtime/engine/world/engine.h"
#include "runtime/engine/world/omission_guard.h"
#include "runtime/measure/recording.h"

namespace cdb::worker {

/// Draws, places, settles what is left out, builds, runs the warm-up and every cycle, and fills
/// `recording`. A scene that asks for errors, or for times and for what is wrong with its pairs, is
/// then run once more from the start, without a clock, for those; a reference is run for its
/// samples alone. `peak_rss_bytes` is of before that, and of
/// the whole process. `cycles_done` goes up after each recorded cycle is stored.
/// Ends with the outcome kDone and the state's hash, or kFailed and a message; throws nothing that
/// a scene can cause but Tripped: then the run has to start again, in a process of its own, with
/// the reason as `keep_walls` and the recording cleared. Returns the world as it is at the end,
/// null where it was never built: taking it down can cost more than many cycles, and a worker that
/// ends anyway leaves it to the system.
std::unique_ptr<world::Engine> RunScene(const plan::Run& run, measure::Recording& recording,
                                        int contacts_fd, const std::string& keep_walls = {});

/// Sets kFailed and the message, cut to what the recording holds.
void ReportFailure(measure::Recording& recording, const std::string& message);

}  // namespace cdb::worker
