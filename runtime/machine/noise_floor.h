// How steadily this machine runs a fixed piece of work: what no run can be measured better than.
#pragma once

#include <cstddef>

namespace cdb::machine {

/// Of the same loop, run again and again. Times of one loop are ns.
struct NoiseFloor {
  std::size_t loops = 0;
  double median = 0;
  double half_low = 0, half_high = 0;  ///< between them is half of the loops
  double p99 = 0, worst = 0;
  double off_processor = 0;  ///< part of the time in which this thread waited for a processor
  double stolen = 0;         ///< part of the time taken by other virtual machines; NaN: not said
  double others = 0;         ///< processors that other programs used; NaN: not said
  double clock_ns = 0;       ///< one reading of the clock

  /// Fit for timings: half of the loops within 1 % of the median, 99 in 100 within 10 %, at most
  /// 2 % off the processor, 1 % stolen and 0.1 processors of other programs, as `noise` judges a
  /// run (noise.h).
  bool IsQuiet() const;
};

/// Loops of about half a millisecond of arithmetic in registers, for `seconds`. Errors: none.
/// Threads: uses the calling one.
NoiseFloor MeasureNoiseFloor(double seconds);

}  // namespace cdb::machine
