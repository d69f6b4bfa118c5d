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
#include "runtime/store/store.h"

namespace cdb::plans {

/// How precise the mean steps of a results file are.
struct Precision {
  std::uint64_t repeats = 0;  ///< of each point
  std::size_t missing = 0;    ///< runs among them that nobody has started
  std::size_t points = 0;     ///< with an interval: all repeats are there and sound
  std::size_t within = 0;     ///< of these, with an interval within the wanted fraction of the mean
  double widest = 0;  ///< largest distance from a mean to an end of its interval, as a fraction
  bool IsReached() const { return within == points; }
  /// So many repeats that there are intervals, and all of them.
  bool IsWholeRound() const;
};

/// `wanted`: a fraction of the mean, above 0. Throws StoreError.
Precision PrecisionOf(const store::ResultFile& file, double wanted);

/// For the next round, at most `most`; those of `reached`, a whole round, where no more are needed.
std::uint64_t NextRepeats(const Precision& reached, double wanted, std::uint64_t most);

/// `5 repeats: 11 of 12 mean steps are known within 1 %, the worst within 1.8 %`.
std::string Describe(const Precision& reached, double wanted);

/// Throws CommandError for a plan that has no times, or too few repeats to end them early.
void CheckUntil(const plan::Plan& plan);

}  // namespace cdb::plans
