// How steadily this machine runs a fixed loop: the noise floor of all measurements on it.
#pragma once

#include <cstddef>

namespace cdb::machine {

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
