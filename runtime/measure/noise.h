// Whether a run had the machine to itself, judged from what the worker measured about it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "runtime/measure/run_scalars.h"

namespace cdb::measure {

/// `flag_values` of the array `noise`.
enum class Noise : std::int8_t {
  kUnknown,  ///< the run did not get to its end, or was not timed
  kQuiet,
  kNoisy,  ///< its times are those of a disturbed machine
};

/// `unknown`, `quiet`, `noisy`.
std::span<const std::string_view> NoiseNames();

struct NoiseJudgement {
  Noise noise = Noise::kUnknown;
  std::string why;  ///< of a noisy one, for people: `12 % of the time not on a processor`
};

/// `load`: the machine's one-minute load average when the run began. `steps`: the time of each
/// cycle, ns. `threads`: those that the detector may use; with several, the thread that is measured
/// waits for the others, and time off the processor says nothing. A run is noisy if
///   1 - CPU time / wall-clock time > 0.02 (one thread),
///   stolen time / wall-clock time > 0.01,
///   load > processors, or
///   the mean of the steps > twice their median, and nine in ten are within 1.5 medians: a few long
///   pauses, rather than a scene whose work changes.
NoiseJudgement JudgeNoise(const RunScalars& scalars, double load, std::uint64_t threads,
                          std::span<const double> steps);

}  // namespace cdb::measure
