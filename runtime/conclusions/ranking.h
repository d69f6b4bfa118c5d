// Ranks the values of an axis by a figure, over the points where they can be compared.
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

/// A figure of a point; less is better.
using FigureOfPoint = std::function<statistics::Estimate(const statistics::MeasuredPoint&)>;

struct Ranking {
  struct Other {
    std::size_t value;  ///< index on the axis
    statistics::Estimate
        ratio;  ///< geometric mean, over the points, of its figure relative to the best
    Certainty certainty;
  };
  std::size_t best;           ///< index on the axis
  std::vector<Other> others;  ///< in order of increasing ratio
  std::size_t cells, of;      ///< number of points compared, and of all points
  /// A point where another value is clearly better than the best: the value, and the point without
  /// the axis.
  struct Exception {
    std::size_t value;
    statistics::Point at;
  };
  std::vector<Exception> exceptions;

  /// Clear if every other value is clearly worse; unknown if that is unknown for one of them.
  Certainty certainty() const;
};

/// Whether a ratio differs from 1.
Certainty CertaintyOf(const statistics::Interval& interval, statistics::IntervalKind kind);

/// `left_out`: values that must not win. Nullopt if fewer than two values, or no points, can be
/// compared.
std::optional<Ranking> RankValues(const statistics::Comparison& comparison,
                                  const FigureOfPoint& figure_of,
                                  const std::set<std::size_t>& left_out,
                                  const statistics::Bootstrap& bootstrap);

}  // namespace cdb::conclusions
