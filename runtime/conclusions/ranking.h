// The values of an axis ranked by a figure, over the points where they can be compared.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "runtime/conclusions/conclusions.h"
#include "runtime/statistics/bootstrap.h"
#include "runtime/statistics/detector_ratios.h"
#include "runtime/statistics/points.h"

namespace cdb::conclusions {

/// A figure of a point, of which less is better.
using FigureOfPoint = std::function<statistics::Estimate(const statistics::MeasuredPoint&)>;

struct Ranking {
  struct Other {
    std::size_t value;  ///< on the axis
    statistics::Estimate
        ratio;  ///< of its figure to that of the best: the geometric mean over the points
    Certainty certainty;
  };
  std::size_t best;           ///< on the axis
  std::vector<Other> others;  ///< the least ratio first
  std::size_t cells, of;      ///< points that were compared, of all
  /// Where another value is better than the best, and no tie: the value, and the point beside the
  /// axis.
  struct Exception {
    std::size_t value;
    statistics::Point at;
  };
  std::vector<Exception> exceptions;

  /// Clear if every other is clearly worse; unknown if that of one is.
  Certainty certainty() const;
};

/// Whether a ratio is another than 1.
Certainty CertaintyOf(const statistics::Interval& interval, statistics::IntervalKind kind);

/// `left_out`: values that must not win. Nullopt where fewer than two values, or no points, can be
/// compared.
std::optional<Ranking> RankValues(const statistics::Comparison& comparison,
                                  const FigureOfPoint& figure_of,
                                  const std::set<std::size_t>& left_out,
                                  const statistics::Bootstrap& bootstrap);

}  // namespace cdb::conclusions
