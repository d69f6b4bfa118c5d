// `cdb run --until P%`: as few repeats of all points as bring the interval of each within P %.
//
// A round gives each point the same number of repeats, so that detectors stay comparable and
// intervals paired. The next round is as large as the widest interval asks for, which shrinks with
// the square root of the repeats, and at most twice as large. A sweep that ends because intervals
// are narrow has them a little too narrow (Anscombe 1952, Large-sample theory of sequential
// estimation): by less the more repeats there are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "compiler/plan/plan.h"
#include "runtime/store/store.h"

namespace cdb::cli {

/// How well a results file knows its points.
struct Precision {
  std::uint64_t repeats = 0;  ///< of each point
  std::size_t missing = 0;    ///< runs among them that nobody has started
  std::size_t points = 0;     ///< that have an interval: all repeats are there, and are sound
  std::size_t within = 0;     ///< of these, with all of it within the wanted part of the figure
  double widest = 0;          ///< the farthest end of an interval from its figure, as part of it
  bool IsReached() const { return within == points; }
  /// So many repeats that there are intervals, and all of them.
  bool IsWholeRound() const;
};

/// Of the mean of `step`. `wanted`: a part, above 0. Throws StoreError.
Precision PrecisionOf(const store::ResultFile& file, double wanted);

/// For the next round, at most `most`; those of `reached`, a whole round, where no more are needed.
std::uint64_t NextRepeats(const Precision& reached, double wanted, std::uint64_t most);

/// `5 repeats: 11 of 12 points are known within 1 %, and the last within 1.8 %`.
std::string Describe(const Precision& reached, double wanted);

/// Throws CommandError for a plan that has no times, or too few repeats to end them early.
void CheckUntil(const plan::Plan& plan);

}  // namespace cdb::cli
