// The figures of the ratios between detectors (`cdb show`), before formatting.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::statistics {

/// A point on the axes other than that of detectors, at which detectors are compared.
struct ComparedPoint {
  Point at;
  std::vector<const MeasuredPoint*> detectors;  ///< in the order of their axis; null for gaps
  /// All detectors of the comparison are present, all of them sound (or all void if no detector has
  /// a sound point), and with the same omissions.
  bool is_matched = false;
  std::vector<std::string> unlike;  ///< components that some omitted and others kept
};

struct Comparison {
  std::size_t baseline;
  std::vector<ComparedPoint> points;  ///< in grid order
  bool is_void;                       ///< no point is sound
  std::size_t MatchedCount() const;
};
/// `baseline`: nullopt for the first detector with the most sound points.
Comparison CompareDetectors(const store::ResultFile& file, const std::vector<MeasuredPoint>& points,
                            std::size_t detector_axis, std::optional<std::size_t> baseline);

/// The time of a detector over that of the baseline; nullopt for gaps.
std::optional<Estimate> RatioAt(const Comparison& comparison, const ComparedPoint& point,
                                std::size_t detector, measure::Phase phase, CycleTimes& times);

/// The ratios of a detector at the matched points.
std::vector<Estimate> MatchedRatios(const Comparison& comparison, std::size_t detector,
                                    measure::Phase phase, CycleTimes& times);

}  // namespace cdb::statistics
