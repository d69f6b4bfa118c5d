// Runs a detector on recorded boxes without a world, so that all detectors are timed on the same
// motion, without physics.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/detectors/detector.h"
#include "runtime/protocol/recording.h"
#include "runtime/protocol/trace_memory.h"

namespace cdb::worker {

/// Runs the scene's narrow phase on the pairs of the trace, as ReplayPairs, if it names one.
/// Otherwise runs its detector on the boxes of the trace behind `trace_fd`, first the warm-up
/// cycles and then the recorded ones, and fills `recording`. A cycle's boxes are laid out before
/// its clock starts; the time in which the detector takes them in is included in `broad`, `detect`
/// and `step` alike. A detector that reports invalid pairs fails the run. The state hash is that of
/// the sorted pairs of the last cycle, so that detectors with the same pairs have the same hash.
/// Ends with the outcome kDone, or kFailed and a message; throws nothing. Threads: one.
void ReplayTrace(const plan::Run& run, protocol::Recording& recording, int trace_fd);

/// A count as the value of a series, at most the greatest that one holds.
std::int32_t SeriesCount(std::size_t count);
/// `pairs`, sorted and each once, as 16 hex digits.
std::string HashOf(std::vector<Pair> pairs);
/// Throws library::SceneError if the trace is shorter.
void CheckCycles(const protocol::TraceShape& trace, std::uint64_t cycles);

}  // namespace cdb::worker
