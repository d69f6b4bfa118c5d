// `cdb run --until P%`: repeats in rounds, until the 95 % interval of every mean step is within P
// %.
//
// After a round every point has the same number of repeats, so that detectors stay comparable and
// intervals paired. An interval shrinks with the square root of the repeats: the widest one decides
// the size of the next round, which at most doubles them. Stopping when intervals are narrow makes
// them a little too narrow, by less the more repeats there are (Anscombe 1952, Large-sample theory
// of sequential estimation).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "compiler/plan/plan.h"
#include "runtime/results/store.h"

namespace cdb::plans {

/// The precision of the mean steps of a results file.
struct Precision {
  std::uint64_t repeats = 0;  ///< of each point
  std::size_t missing = 0;    ///< number of runs in them that nobody has started
  std::size_t points = 0;     ///< number with an interval: all repeats are there and sound
  std::size_t within = 0;     ///< number of these whose interval is within the wanted fraction of
                              ///< the mean
  double widest = 0;  ///< largest distance from a mean to an end of its interval, as a fraction
  bool IsReached() const { return within == points; }
  /// True if there are enough repeats for intervals, and none is missing.
  bool IsWholeRound() const;
};

/// `wanted`: a fraction of the mean, above 0. Throws StoreError.
Precision PrecisionOf(const results::ResultFile& file, double wanted);

/// The repeats of the next round, at most `most`; the present number, of whole rounds, if no more
/// are needed.
std::uint64_t NextRepeats(const Precision& reached, double wanted, std::uint64_t most);

/// `5 repeats: 11 of 12 mean steps are known within 1 %, the worst within 1.8 %`.
std::string Describe(const Precision& reached, double wanted);

/// Throws CommandError for a plan without times, or with too few repeats to end them early.
void CheckUntil(const plan::Plan& plan);

}  // namespace cdb::plans
