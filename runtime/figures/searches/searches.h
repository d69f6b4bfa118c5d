// The searches of a scenario (`find( )`): which runs they need next, and the boundaries they found,
// for each point of the other axes, and together over the seeds. Throws StoreError. Not
// thread-safe.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/figures/model.h"
#include "runtime/figures/searches/bisection.h"
#include "runtime/results/store.h"

namespace cdb::searches {

using figures::Point;

/// The points of one search: those that differ only on its axis.
struct Line {
  Point place;                      ///< on the other axes
  std::vector<std::size_t> values;  ///< on the axis, those with runs, in order
};
/// In grid order. `points`: those that have runs, on all axes.
std::vector<Line> LinesOf(std::size_t axis, const std::vector<Point>& points);

/// What one search has found, in the values of its axis.
struct Boundary {
  Line line;
  Bracket bracket;  ///< by positions in the line
  /// The middle of the two neighbouring values; NaN unless the outcome is kBetween or kUncertain.
  double value = figures::kNone;
  /// Between which it surely is; NaN for an end beyond which nothing was run, or is sure.
  double low = figures::kNone, high = figures::kNone;

  bool IsFound() const {
    return bracket.outcome == Outcome::kBetween ||
           (bracket.outcome == Outcome::kUncertain && bracket.HasNeighbours());
  }
};

/// All of the file; empty if its scenario has no search. Throws StoreError.
std::vector<Boundary> FindBoundaries(const figures::Model& model);

/// The points to be run next, on all axes, in grid order; empty once all searches have ended.
std::vector<Point> NextPoints(std::size_t axis, const std::vector<Boundary>& boundaries);
/// The same before anything was run.
std::vector<Point> FirstPoints(const plan::Plan& plan);
/// The number of runs of a plan that are executed: all of `runs`, which a race may need, or what
/// its searches take if every run tells. `head`: the plan without its runs.
std::uint64_t ExpectedRuns(const plan::Plan& head, std::uint64_t runs);
/// `514 runs`, `a search: about 22 of 514 runs`, `a race: 48 to 300 runs`.
std::string RunsText(const plan::Plan& head, std::uint64_t runs);

/// Searches that differ only in the seed, if the scenario sweeps it; else a single one.
struct PooledBoundary {
  Point place;  ///< on the other axes but the seed
  std::vector<const Boundary*> searches;
  std::size_t found = 0;  ///< searches with a boundary
  /// The mean, geometric on a logarithmic axis; NaN unless all found one.
  double value = figures::kNone;
  /// Of one search, where it is; of several, over the seeds; NaN where nothing is known.
  figures::Interval interval = {figures::kNone, figures::kNone};
  figures::IntervalKind kind = figures::IntervalKind::kAbsent;
  std::size_t probes = 0;
  std::size_t not_monotone = 0;  ///< searches whose condition changes more than once
};
/// The axes that tell pooled boundaries apart.
std::vector<std::size_t> PooledAxes(const results::ResultFile& file);
/// `boundaries` must outlive them.
std::vector<PooledBoundary> Pool(const results::ResultFile& file,
                                 const std::vector<Boundary>& boundaries);

/// `56.0 (54.7 .. 57.3)`, `nowhere up to 100000`: a pooled boundary in words.
std::string BoundaryText(const plan::Axis& axis, const PooledBoundary& of);

/// What a merged file stores of its requirements, searches and races.
results::StoredAnswers AnswersToStore(const std::filesystem::path& file);

}  // namespace cdb::searches
