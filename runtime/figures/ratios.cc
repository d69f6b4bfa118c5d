#include "runtime/figures/ratios.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "compiler/plan/plan.h"

namespace cdb::figures {
namespace {

/// The number of sound points of each value, or of all points if none is sound.
std::vector<std::size_t> CountPoints(const Comparison& comparison, std::size_t values) {
  std::vector<std::size_t> counts(values);
  for (const ComparedPoint& point : comparison.points)
    for (std::size_t i = 0; i < values; ++i)
      if (point.values[i] != nullptr && point.values[i]->IsSound() != comparison.is_void)
        ++counts[i];
  return counts;
}

void FindUnlike(ComparedPoint& point) {
  for (const MeasuredPoint* one : point.values)
    for (const MeasuredPoint* other : point.values)
      if (one != nullptr && other != nullptr)
        for (const std::string& name : one->UnlikeComponents(*other))
          if (std::ranges::find(point.unlike, name) == point.unlike.end())
            point.unlike.push_back(name);
}

/// The index of `name` on the axis of detectors; nullopt if it is empty.
std::optional<std::size_t> FindBaseline(const Model& model, const std::string& name) {
  if (name.empty()) return std::nullopt;
  if (!model.detector_axis())
    throw files::StoreError(
        fmt::format("there is no baseline '{}': this file sweeps no detectors", name));
  const std::vector<std::string> detectors =
      plan::CoordinateLabels(model.axis(*model.detector_axis()));
  const auto found = std::ranges::find(detectors, name);
  if (found == detectors.end())
    throw files::StoreError(fmt::format("there is no detector '{}' in this file; there are {}",
                                        name, fmt::join(detectors, ", ")));
  return static_cast<std::size_t>(found - detectors.begin());
}

class Ranker {
 public:
  Ranker(const Comparison& comparison, const FigureOfPoint& figure_of,
         const std::set<std::size_t>& left_out)
      : comparison_(comparison), figure_of_(figure_of) {
    for (const ComparedPoint& point : comparison.points) {
      if (!point.is_matched) continue;
      for (std::size_t value = 0; value < point.values.size(); ++value)
        if (point.values[value] != nullptr && !left_out.contains(value)) values_.insert(value);
    }
  }

  std::optional<Ranking> Rank() const {
    const Bootstrap& bootstrap = comparison_.model->times().bootstrap();
    if (values_.size() < 2) return std::nullopt;
    const std::optional<std::size_t> best = Best();
    if (!best) return std::nullopt;
    Ranking ranking = {*best, {}, 0, comparison_.points.size(), {}};
    for (const std::size_t value : values_) {
      const std::vector<Estimate> ratios = Ratios(value, *best);
      if (value == *best || ratios.empty()) continue;
      Estimate ratio = GeometricMeanOf(ratios);
      const Certainty certainty = CertaintyOf(bootstrap.IntervalOf(ratio), bootstrap.kind());
      ranking.others.push_back({value, std::move(ratio), certainty});
      ranking.cells = std::max(ranking.cells, ratios.size());
    }
    if (ranking.others.empty()) return std::nullopt;
    std::ranges::sort(ranking.others, {},
                      [](const Ranking::Other& other) { return other.ratio.value; });
    AddExceptions(ranking, bootstrap);
    return ranking;
  }

 private:
  /// The ratios at the matched points that have both.
  std::vector<Estimate> Ratios(std::size_t value, std::size_t to) const {
    std::vector<Estimate> ratios;
    for (const ComparedPoint& point : comparison_.points) {
      if (!point.is_matched || point.values[value] == nullptr || point.values[to] == nullptr)
        continue;
      Estimate ratio = RatioOf(figure_of_(*point.values[value]), figure_of_(*point.values[to]));
      if (std::isfinite(ratio.value) && ratio.value > 0) ratios.push_back(std::move(ratio));
    }
    return ratios;
  }

  std::optional<std::size_t> Best() const {
    std::optional<std::size_t> best;
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t value : values_) {
      const std::vector<Estimate> ratios = Ratios(value, *values_.begin());
      if (ratios.empty()) continue;
      const double mean = GeometricMeanOf(ratios).value;
      if (!(mean < least)) continue;
      least = mean;
      best = value;
    }
    return best;
  }

  void AddExceptions(Ranking& ranking, const Bootstrap& bootstrap) const {
    for (const ComparedPoint& point : comparison_.points) {
      const MeasuredPoint* best = point.values[ranking.best];
      if (!point.is_matched || best == nullptr) continue;
      std::optional<std::size_t> winner;
      double least = 1;
      for (const std::size_t value : values_) {
        if (point.values[value] == nullptr) continue;
        const Estimate ratio = RatioOf(figure_of_(*point.values[value]), figure_of_(*best));
        if (!(ratio.value < least) ||
            CertaintyOf(bootstrap.IntervalOf(ratio), bootstrap.kind()) != Certainty::kClear)
          continue;
        least = ratio.value;
        winner = value;
      }
      if (winner) ranking.exceptions.push_back({*winner, point.at});
    }
  }

  const Comparison& comparison_;
  const FigureOfPoint& figure_of_;
  std::set<std::size_t> values_;
};

}  // namespace

std::size_t Comparison::MatchedCount() const {
  return static_cast<std::size_t>(std::ranges::count_if(points, &ComparedPoint::is_matched));
}

Comparison CompareValues(const Model& model, std::size_t axis,
                         std::optional<std::size_t> baseline) {
  const std::size_t values = model.axis(axis).values.size();
  std::map<Point, ComparedPoint> compared;
  for (const MeasuredPoint& point : model.points()) {
    ComparedPoint& at = compared[Without(point.at, axis)];
    at.at = Without(point.at, axis);
    at.values.resize(values, nullptr);
    at.values[point.at[axis]] = &point;
  }
  Comparison comparison = {
      &model, axis, 0, {}, std::ranges::none_of(model.points(), &MeasuredPoint::IsSound)};
  for (auto& [at, point] : compared) {
    FindUnlike(point);
    comparison.points.push_back(std::move(point));
  }
  const std::vector<std::size_t> counts = CountPoints(comparison, values);
  comparison.baseline = baseline.value_or(
      static_cast<std::size_t>(std::ranges::max_element(counts) - counts.begin()));
  for (ComparedPoint& point : comparison.points) {
    point.is_matched = point.unlike.empty();
    for (std::size_t i = 0; i < values; ++i)
      if (counts[i] > 0 &&
          (point.values[i] == nullptr || point.values[i]->IsSound() == comparison.is_void))
        point.is_matched = false;
  }
  return comparison;
}

std::optional<Comparison> CompareDetectors(const Model& model, const std::string& name) {
  const auto baseline = FindBaseline(model, name);
  const auto axis = model.ComparedDetectors();
  if (!axis) return std::nullopt;
  return CompareValues(model, *axis, baseline);
}

std::optional<Estimate> Comparison::RatioAt(const ComparedPoint& point, std::size_t value,
                                            protocol::Phase phase) const {
  const MeasuredPoint *above = point.values[value], *below = point.values[baseline];
  if (above == nullptr || below == nullptr) return std::nullopt;
  const Estimate ratio = RatioOf(model->TimeOf(*above, phase), model->TimeOf(*below, phase));
  return std::isfinite(ratio.value) ? std::optional(ratio) : std::nullopt;
}

std::optional<MeanRatio> MeanRatioOf(const Comparison& comparison,
                                     const std::vector<const ComparedPoint*>& points,
                                     std::size_t value, protocol::Phase phase) {
  // The best kind of points that there is: matched, sound, any.
  std::vector<Estimate> matched, sound, any;
  for (const ComparedPoint* point : points) {
    auto ratio = comparison.RatioAt(*point, value, phase);
    if (!ratio) continue;
    (point->is_matched                 ? matched
     : point->values[value]->IsSound() ? sound
                                       : any)
        .push_back(*std::move(ratio));
  }
  const bool is_matched = !matched.empty();
  const std::vector<Estimate>& used = is_matched ? matched : !sound.empty() ? sound : any;
  if (used.empty()) return std::nullopt;
  MeanRatio made = {GeometricMeanOf(used),
                    {},
                    0,
                    0,
                    used.size(),
                    points.size(),
                    is_matched,
                    is_matched ? comparison.is_void : sound.empty()};
  made.interval = comparison.model->times().IntervalOf(made.mean);
  const auto [least, most] = std::ranges::minmax(used, {}, &Estimate::value);
  made.least = least.value;
  made.most = most.value;
  return made;
}

std::optional<MeanRatio> MeanRatioOf(const Comparison& comparison, std::size_t value,
                                     protocol::Phase phase) {
  std::vector<const ComparedPoint*> points;
  for (const ComparedPoint& point : comparison.points) points.push_back(&point);
  return MeanRatioOf(comparison, points, value, phase);
}

Certainty Ranking::certainty() const {
  Certainty worst = Certainty::kClear;
  for (const Other& other : others) worst = std::max(worst, other.certainty);
  return worst;
}

Certainty CertaintyOf(const Interval& interval, IntervalKind kind) {
  if (kind == IntervalKind::kAbsent || std::isnan(interval.low) || std::isnan(interval.high))
    return Certainty::kUnknown;
  if (interval.low <= 1 && interval.high >= 1) return Certainty::kTie;
  return kind == IntervalKind::kInterval ? Certainty::kClear : Certainty::kUnknown;
}

std::optional<Ranking> RankValues(const Comparison& comparison, const FigureOfPoint& figure_of,
                                  const std::set<std::size_t>& left_out) {
  return Ranker(comparison, figure_of, left_out).Rank();
}

}  // namespace cdb::figures
