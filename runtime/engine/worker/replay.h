// Runs a detector on recorded boxes, without a world: all detectors are timed on the same motion,
// without physics.
#pragma once

#include "compiler/plan/plan.h"
#include "runtime/measure/recording.h"

namespace cdb::worker {

/// Runs the scene's detector on the trace behind `trace_fd`, its warm-up cycles and then the
/// recorded ones, and fills `recording`. A cycle's boxes are laid out before its clock starts; what
/// the detector does to take them in is timed, as `broad`, `detect` and `step` alike. Detectors
/// that list nonsense fail the run. The state hash is of the pairs of the last cycle, in order, so
/// that all who list the same pairs have the same. Ends with the outcome kDone, or kFailed and a
/// message; throws nothing. Threads: one.
void ReplayTrace(const plan::Run& run, measure::Recording& recording, int trace_fd);

}  // namespace cdb::worker
