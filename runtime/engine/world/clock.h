// The clock of all times that a run records, and the counters of `record counters`; timed_world.cc
// has them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "runtime/protocol/machine/event_counters.h"
#include "runtime/protocol/recording.h"
#include "runtime/protocol/series.h"

namespace cdb::world {

/// Monotonic time in ns, or, after CountInstructions, the number of instructions that this process
/// has executed. Those of this function do not count.
std::int64_t Now();

/// From now on, the clock counts instructions. The process runs under Valgrind's callgrind, which
/// writes its log to the file `log`; this process reads it, and empties it. Throws
/// std::runtime_error if it does not. Threads: one in the whole process.
void CountInstructions(int log);

/// Throws std::runtime_error if the clock counts instructions and one of its readings failed, so
/// that Now() returned the count before it. Nothing that was recorded since CountInstructions can
/// be used then.
void RequireCounts();

/// The clock and the counters at a moment, or their differences between two.
struct Stamp {
  std::int64_t time = 0;  ///< as Now() has it
  machine::Counts counts = {};
};
Stamp operator-(const Stamp& later, const Stamp& earlier);
Stamp operator+(const Stamp& a, const Stamp& b);

/// The counts are 0 unless CountEvents was called; NaN where the machine does not count the event.
/// Reading them is a call of the system, about half a microsecond.
Stamp TakeStamp();

/// From now on, stamps count the events of the calling thread, for the rest of the process.
void CountEvents();

/// What each phase of a cycle took, in the order of schema::kPhases; nothing for phases that are
/// not measured.
using PhaseStamps = std::array<std::optional<Stamp>, protocol::kPhaseCount>;
/// Records the times and counts of a cycle, as far as the run records them.
void RecordPhases(const PhaseStamps& phases, std::uint64_t cycle, protocol::Recording& recording);

}  // namespace cdb::world
