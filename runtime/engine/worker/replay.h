// Runs a detector on recorded boxes without a world, so that all detectors are timed on the same
// motion, without physics.
#pragma once

#include "compiler/plan/plan.h"
#include "runtime/protocol/recording.h"

namespace cdb::worker {

/// Runs the scene's detector on the trace behind `trace_fd`, first the warm-up cycles and then the
/// recorded ones, and fills `recording`. A cycle's boxes are laid out before its clock starts; the
/// time in which the detector takes them in is included in `broad`, `detect` and `step` alike. A
/// detector that reports invalid pairs fails the run. The state hash is that of the sorted pairs of
/// the last cycle, so that detectors with the same pairs have the same hash. Ends with the outcome
/// kDone, or kFailed and a message; throws nothing. Threads: one.
void ReplayTrace(const plan::Run& run, protocol::Recording& recording, int trace_fd);

}  // namespace cdb::worker
