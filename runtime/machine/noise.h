// Whether a run had the machine to itself, judged from what the worker measured about it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "runtime/measure/run_scalars.h"

namespace cdb::machine {

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
  /// The largest part of its time that other programs and virtual machines disturbed, 0 to 1.
  double disturbed = 0;

  /// Its times are to be preferred: it was measured, and quiet or less disturbed.
  bool IsQuieterThan(const NoiseJudgement& other) const;
};

/// The most parts of the wall-clock time of a quiet run: off the processor, with one thread, and
/// taken by other virtual machines.
inline constexpr double kMostOffProcessor = 0.02, kMostStolen = 0.01;
/// The most processors that other programs may use beside it: caches, memory and frequency are
/// shared.
inline constexpr double kMostOthers = 0.1;

struct MachineLoad {
  double load = 0;        ///< one-minute load average when the run began
  double processors = 0;  ///< that the runner may use
};

/// `steps`: the time of each cycle, ns. `threads`: those that the detector may use; with several,
/// the thread that is measured waits for the others, and time off the processor says nothing. A run
/// is noisy if
///   1 - CPU time / wall-clock time > kMostOffProcessor (one thread),
///   stolen time / wall-clock time > kMostStolen,
///   other programs used more than kMostOthers of a processor, by more than 30 ms,
///   load > processors, or
///   the mean of the steps > twice their median, and nine in ten are within 1.5 medians: a few long
///   pauses, rather than a scene whose work changes.
NoiseJudgement JudgeNoise(const measure::RunScalars& scalars, MachineLoad machine,
                          std::uint64_t threads, std::span<const double> steps);

}  // namespace cdb::machine
