// Judges from the worker's measurements whether other programs disturbed a run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "compiler/schema/series.h"

namespace cdb::machine {

/// `flag_values` of the array `noise`.
enum class Noise : std::int8_t {
  kUnknown,  ///< the run did not finish, or was not timed
  kQuiet,
  kNoisy,  ///< its times are those of a disturbed machine
};

/// `unknown`, `quiet`, `noisy`.
std::span<const std::string_view> NoiseNames();

struct NoiseJudgement {
  Noise noise = Noise::kUnknown;
  std::string why;  ///< reason for a noisy run, for the output: `12 % of the time not on a
                    ///< processor`
  /// The largest fraction of its time that was disturbed by other programs or virtual machines, 0
  /// to 1.
  double disturbed = 0;

  /// True if its times are to be preferred: it was measured, and was quiet or less disturbed.
  bool IsQuieterThan(const NoiseJudgement& other) const;
};

/// Limits for a quiet run, as fractions of its wall-clock time: off the processor (with one
/// thread), and taken by other virtual machines.
inline constexpr double kMostOffProcessor = 0.02, kMostStolen = 0.01;
/// The most processors that other programs may use: they share caches, memory and frequency.
inline constexpr double kMostOthers = 0.1;

struct MachineLoad {
  double load = 0;        ///< one-minute load average when the run began
  double processors = 0;  ///< online on the machine, whether or not the runner may use them
};

/// `steps`: the time of each cycle, ns. `threads`: the number that the detector may use. With
/// several, the measured thread waits for the others, so that time off the processor has no
/// meaning. A run is noisy if
///   1 - CPU time / wall-clock time > kMostOffProcessor (one thread),
///   stolen time / wall-clock time > kMostStolen,
///   other programs used more than kMostOthers of a processor, by more than 30 ms,
///   load > processors, or
///   the mean of the steps > twice their median, and nine in ten are within 1.5 medians: a few long
///   pauses, rather than a scene whose work changes.
NoiseJudgement JudgeNoise(const schema::RunScalars& scalars, MachineLoad machine,
                          std::uint64_t threads, std::span<const double> steps);

// How steadily this machine runs a fixed loop: the noise floor of all measurements on it.

/// Statistics of the same loop, run repeatedly. Times are for one loop, ns.
struct NoiseFloor {
  std::size_t loops = 0;
  double median = 0;
  double half_low = 0, half_high = 0;  ///< the middle half of the loops lies between them
  double p99 = 0, worst = 0;
  double off_processor = 0;  ///< fraction of the time in which this thread waited for a processor
  double stolen = 0;         ///< fraction of the time taken by other virtual machines; NaN: unknown
  double others = 0;         ///< processors that other programs used; NaN: unknown
  double clock_ns = 0;       ///< time to read the clock once

  /// True if the machine is fit for timings: half of the loops within 1 % of the median, 99 in 100
  /// within 10 %, at most 2 % off the processor, 1 % stolen and 0.1 processors used by other
  /// programs, the limits for a quiet run (noise.h).
  bool IsQuiet() const;
};

/// Runs loops of about half a millisecond of arithmetic in registers for `seconds`. Errors: none.
/// Threads: uses the calling one.
NoiseFloor MeasureNoiseFloor(double seconds);

}  // namespace cdb::machine
