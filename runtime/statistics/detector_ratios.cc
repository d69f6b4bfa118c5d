#include "runtime/statistics/detector_ratios.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace cdb::statistics {
namespace {

/// The number of sound points of each detector, or of all points if none is sound.
std::vector<std::size_t> CountPoints(const Comparison& comparison, std::size_t detectors) {
  std::vector<std::size_t> counts(detectors);
  for (const ComparedPoint& point : comparison.points)
    for (std::size_t i = 0; i < detectors; ++i)
      if (point.detectors[i] != nullptr && point.detectors[i]->IsSound() != comparison.is_void)
        ++counts[i];
  return counts;
}

void FindUnlike(ComparedPoint& point) {
  for (const MeasuredPoint* one : point.detectors)
    for (const MeasuredPoint* other : point.detectors)
      if (one != nullptr && other != nullptr)
        for (const std::string& name : one->UnlikeComponents(*other))
          if (std::ranges::find(point.unlike, name) == point.unlike.end())
            point.unlike.push_back(name);
}

}  // namespace

std::size_t Comparison::MatchedCount() const {
  return static_cast<std::size_t>(std::ranges::count_if(points, &ComparedPoint::is_matched));
}

Comparison CompareDetectors(const store::ResultFile& file, const std::vector<MeasuredPoint>& points,
                            std::size_t detector_axis, std::optional<std::size_t> baseline) {
  const std::size_t detectors = file.axes()[detector_axis].values.size();
  std::map<Point, ComparedPoint> compared;
  for (const MeasuredPoint& point : points) {
    ComparedPoint& at = compared[Without(point.at, detector_axis)];
    at.at = Without(point.at, detector_axis);
    at.detectors.resize(detectors, nullptr);
    at.detectors[point.at[detector_axis]] = &point;
  }
  Comparison comparison = {0, {}, std::ranges::none_of(points, &MeasuredPoint::IsSound)};
  for (auto& [at, point] : compared) {
    FindUnlike(point);
    comparison.points.push_back(std::move(point));
  }
  const std::vector<std::size_t> counts = CountPoints(comparison, detectors);
  comparison.baseline = baseline.value_or(
      static_cast<std::size_t>(std::ranges::max_element(counts) - counts.begin()));
  for (ComparedPoint& point : comparison.points) {
    point.is_matched = point.unlike.empty();
    for (std::size_t i = 0; i < detectors; ++i)
      if (counts[i] > 0 &&
          (point.detectors[i] == nullptr || point.detectors[i]->IsSound() == comparison.is_void))
        point.is_matched = false;
  }
  return comparison;
}

std::optional<Estimate> RatioAt(const Comparison& comparison, const ComparedPoint& point,
                                std::size_t detector, measure::Phase phase, CycleTimes& times) {
  const MeasuredPoint *above = point.detectors[detector],
                      *below = point.detectors[comparison.baseline];
  if (above == nullptr || below == nullptr) return std::nullopt;
  const Estimate ratio = RatioOf(times.FigureOf(*above, phase), times.FigureOf(*below, phase));
  return std::isfinite(ratio.value) ? std::optional(ratio) : std::nullopt;
}

std::vector<Estimate> MatchedRatios(const Comparison& comparison, std::size_t detector,
                                    measure::Phase phase, CycleTimes& times) {
  std::vector<Estimate> ratios;
  for (const ComparedPoint& point : comparison.points)
    if (point.is_matched)
      if (auto ratio = RatioAt(comparison, point, detector, phase, times))
        ratios.push_back(*std::move(ratio));
  return ratios;
}

}  // namespace cdb::statistics
