// Ratios between the values of an axis, mostly detectors, at points that are alike in all else; and
// the ranking of these values.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "runtime/figures/bootstrap.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/model.h"

namespace cdb::figures {

/// A point on the other axes, at which the values of an axis are compared.
struct ComparedPoint {
  Point at;
  std::vector<const MeasuredPoint*> values;  ///< in the order of the axis; null for gaps
  /// All values of the comparison are present, all of them sound (or all void if none has a sound
  /// point), and with the same omissions.
  bool is_matched = false;
  std::vector<std::string> unlike;  ///< components that some omitted and others kept
};

struct Comparison {
  const Model* model;
  std::size_t axis, baseline;
  std::vector<ComparedPoint> points;  ///< in grid order
  bool is_void;                       ///< no point is sound
  std::size_t MatchedCount() const;
  /// The time of a value over that of the baseline; nullopt for gaps.
  std::optional<Estimate> RatioAt(const ComparedPoint& point, std::size_t value,
                                  protocol::Phase phase) const;
};
/// `baseline`: nullopt for the first value with the most sound points.
Comparison CompareValues(const Model& model, std::size_t axis, std::optional<std::size_t> baseline);
/// Compares the detectors; `name` is the baseline if it is not empty. Nullopt if there are no
/// detectors to compare. Throws StoreError for a detector that the file does not have.
std::optional<Comparison> CompareDetectors(const Model& model, const std::string& name);

/// The geometric mean of ratios over some of the compared points.
struct MeanRatio {
  Estimate mean;
  Interval interval;
  double least, most;
  std::size_t cells, of;  ///< number of points in the mean, and of all
  /// Over the matched points. If there is none: over those where the value is sound, or else over
  /// all, and not to be compared with others.
  bool is_matched, is_void;
};
/// Nullopt if no point has a ratio.
std::optional<MeanRatio> MeanRatioOf(const Comparison& comparison,
                                     const std::vector<const ComparedPoint*>& points,
                                     std::size_t value, protocol::Phase phase);
/// Over all points.
std::optional<MeanRatio> MeanRatioOf(const Comparison& comparison, std::size_t value,
                                     protocol::Phase phase);

/// A figure of a point; less is better.
using FigureOfPoint = std::function<Estimate(const MeasuredPoint&)>;

struct Ranking {
  struct Other {
    std::size_t value;  ///< index on the axis
    Estimate ratio;     ///< geometric mean, over the points, of its figure relative
                        ///< to the best
    Certainty certainty;
  };
  std::size_t best;           ///< index on the axis
  std::vector<Other> others;  ///< in order of increasing ratio
  std::size_t cells, of;      ///< number of points compared, and of all points
  /// A point where another value is better than the best, and the 95 % interval of their ratio
  /// excludes 1: the value, and the point without the axis.
  struct Exception {
    std::size_t value;
    Point at;
  };
  std::vector<Exception> exceptions;

  /// Clear if every other value is clearly worse; unknown if that is unknown for one of them.
  Certainty certainty() const;
};

/// Whether a ratio differs from 1.
Certainty CertaintyOf(const Interval& interval, IntervalKind kind);

/// `left_out`: values that must not win. Nullopt if fewer than two values, or no points, can be
/// compared.
std::optional<Ranking> RankValues(const Comparison& comparison, const FigureOfPoint& figure_of,
                                  const std::set<std::size_t>& left_out);

}  // namespace cdb::figures
