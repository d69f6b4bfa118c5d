#include "runtime/conclusions/ranking.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cdb::conclusions {
namespace {

class Ranker {
 public:
  Ranker(const statistics::Comparison& comparison, const FigureOfPoint& figure_of,
         const std::set<std::size_t>& left_out)
      : comparison_(comparison), figure_of_(figure_of) {
    for (const statistics::ComparedPoint& point : comparison.points) {
      if (!point.is_matched) continue;
      for (std::size_t value = 0; value < point.detectors.size(); ++value)
        if (point.detectors[value] != nullptr && !left_out.contains(value)) values_.insert(value);
    }
  }

  std::optional<Ranking> Rank(const statistics::Bootstrap& bootstrap) const {
    if (values_.size() < 2) return std::nullopt;
    const std::optional<std::size_t> best = Best();
    if (!best) return std::nullopt;
    Ranking ranking = {*best, {}, 0, comparison_.points.size(), {}};
    for (const std::size_t value : values_) {
      const std::vector<statistics::Estimate> ratios = Ratios(value, *best);
      if (value == *best || ratios.empty()) continue;
      statistics::Estimate ratio = statistics::GeometricMeanOf(ratios);
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
  std::vector<statistics::Estimate> Ratios(std::size_t value, std::size_t to) const {
    std::vector<statistics::Estimate> ratios;
    for (const statistics::ComparedPoint& point : comparison_.points) {
      if (!point.is_matched || point.detectors[value] == nullptr || point.detectors[to] == nullptr)
        continue;
      statistics::Estimate ratio = statistics::RatioOf(figure_of_(*point.detectors[value]),
                                                       figure_of_(*point.detectors[to]));
      if (std::isfinite(ratio.value) && ratio.value > 0) ratios.push_back(std::move(ratio));
    }
    return ratios;
  }

  std::optional<std::size_t> Best() const {
    std::optional<std::size_t> best;
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t value : values_) {
      const std::vector<statistics::Estimate> ratios = Ratios(value, *values_.begin());
      if (ratios.empty()) continue;
      const double mean = statistics::GeometricMeanOf(ratios).value;
      if (!(mean < least)) continue;
      least = mean;
      best = value;
    }
    return best;
  }

  void AddExceptions(Ranking& ranking, const statistics::Bootstrap& bootstrap) const {
    for (const statistics::ComparedPoint& point : comparison_.points) {
      const statistics::MeasuredPoint* best = point.detectors[ranking.best];
      if (!point.is_matched || best == nullptr) continue;
      std::optional<std::size_t> winner;
      double least = 1;
      for (const std::size_t value : values_) {
        if (point.detectors[value] == nullptr) continue;
        const statistics::Estimate ratio =
            statistics::RatioOf(figure_of_(*point.detectors[value]), figure_of_(*best));
        if (!(ratio.value < least) ||
            CertaintyOf(bootstrap.IntervalOf(ratio), bootstrap.kind()) == Certainty::kTie)
          continue;
        least = ratio.value;
        winner = value;
      }
      if (winner) ranking.exceptions.push_back({*winner, point.at});
    }
  }

  const statistics::Comparison& comparison_;
  const FigureOfPoint& figure_of_;
  std::set<std::size_t> values_;
};

}  // namespace

Certainty Ranking::certainty() const {
  Certainty worst = Certainty::kClear;
  for (const Other& other : others) worst = std::max(worst, other.certainty);
  return worst;
}

Certainty CertaintyOf(const statistics::Interval& interval, statistics::IntervalKind kind) {
  if (kind == statistics::IntervalKind::kAbsent || std::isnan(interval.low) ||
      std::isnan(interval.high))
    return Certainty::kUnknown;
  if (interval.low <= 1 && interval.high >= 1) return Certainty::kTie;
  return kind == statistics::IntervalKind::kInterval ? Certainty::kClear : Certainty::kUnknown;
}

std::optional<Ranking> RankValues(const statistics::Comparison& comparison,
                                  const FigureOfPoint& figure_of,
                                  const std::set<std::size_t>& left_out,
                                  const statistics::Bootstrap& bootstrap) {
  return Ranker(comparison, figure_of, left_out).Rank(bootstrap);
}

}  // namespace cdb::conclusions
