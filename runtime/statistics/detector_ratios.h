// The numbers of the ratios between detectors (`cdb show`), before they are formatted.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::statistics {

/// A point of the axes beside that of detectors: where detectors are compared.
struct ComparedPoint {
  Point at;
  std::vector<const MeasuredPoint*> detectors;  ///< in the order of their axis; null for holes
  /// All detectors of the comparison are there, all of them sound (or all void where no detector
  /// has a sound point), and with the same omissions.
  bool is_matched = false;
  std::vector<std::string> unlike;  ///< components that some ran without and others with
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

/// The time of a detector over that of the baseline; nullopt for holes.
std::optional<Estimate> RatioAt(const Comparison& comparison, const ComparedPoint& point,
                                std::size_t detector, measure::Phase phase, CycleTimes& times);

/// The ratios of a detector at the matched points.
std::vector<Estimate> MatchedRatios(const Comparison& comparison, std::size_t detector,
                                    measure::Phase phase, CycleTimes& times);

}  // namespace cdb::statistics
