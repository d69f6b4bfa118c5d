// The clock of all times that a run records; timed_world.cc has it.
#pragma once

#include <cstdint>

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

}  // namespace cdb::world
