// Conclusions about the time of a step along the axes (conclusions.h).
#include <fmt/format.h>

#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "runtime/conclusions/conclusions.h"
#include "runtime/conclusions/ranking.h"
#include "runtime/report/conclusion_words.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/detector_figures.h"
#include "runtime/statistics/numbers.h"
#include "runtime/terminal/table.h"

namespace cdb::conclusions {
namespace {

using measure::Phase;

std::string CellsNote(std::size_t cells, std::size_t of) {
  if (of < 2) return {};
  return cells < of ? fmt::format(", the geometric mean over {} of {} cells", cells, of)
                    : fmt::format(", the geometric mean over {} cells", cells);
}

/// Compares the first and the last value of an axis of numbers.
void AddScaling(const ConclusionParts& parts, std::size_t axis, std::vector<Conclusion>& all) {
  const plan::Axis& along = parts.file.axes()[axis];
  const statistics::Comparison comparison =
      statistics::CompareDetectors(parts.file, parts.points, axis, 0);
  if (comparison.is_void) return;
  std::vector<statistics::Estimate> ratios;
  const std::size_t last = along.values.size() - 1;
  for (const statistics::ComparedPoint& point : comparison.points) {
    const statistics::MeasuredPoint *from = point.detectors[0], *to = point.detectors[last];
    if (from == nullptr || to == nullptr || !from->IsSound() || !to->IsSound()) continue;
    if (auto ratio = statistics::RatioAt(comparison, point, last, Phase::kStep, parts.times))
      ratios.push_back(*std::move(ratio));
  }
  if (ratios.empty()) return;
  const statistics::Estimate ratio = statistics::GeometricMeanOf(ratios);
  const Certainty certainty =
      CertaintyOf(parts.times.IntervalOf(ratio), parts.times.bootstrap().kind());
  const auto at = [&](std::size_t value) {
    return fmt::format("{} {}{}", along.name, terminal::CoordinateText(along, value),
                       along.unit.empty() ? "" : " " + along.unit);
  };
  std::string answer = fmt::format("A step takes {} times as long with {} as with {}{}{}.",
                                   terminal::ShortNumber(ratio.value), at(last), at(0),
                                   report::IntervalNote(parts.times, ratio),
                                   CellsNote(ratios.size(), comparison.points.size()));
  if (certainty == Certainty::kTie)
    answer += " The interval includes 1: this may be no difference.";
  all.push_back(
      {fmt::format("How does the time of a step change with {}?", report::AxisWords(along)),
       std::move(answer), "scaling", certainty});
}

/// Finds the fastest value of an axis of words.
void AddFastestValue(const ConclusionParts& parts, std::size_t axis, std::vector<Conclusion>& all) {
  const plan::Axis& along = parts.file.axes()[axis];
  const statistics::Comparison comparison =
      statistics::CompareDetectors(parts.file, parts.points, axis, std::nullopt);
  if (comparison.is_void) return;
  const auto ranking = RankValues(
      comparison,
      [&](const statistics::MeasuredPoint& point) {
        return parts.times.Of(point, Phase::kStep).mean;
      },
      {}, parts.times.bootstrap());
  if (!ranking) return;
  const Ranking::Other &next = ranking->others[0], &last = ranking->others.back();
  const auto against = [&](const Ranking::Other& other) {
    return fmt::format("{} takes {} times as long{}", terminal::CoordinateText(along, other.value),
                       terminal::ShortNumber(other.ratio.value),
                       report::IntervalNote(parts.times, other.ratio));
  };
  std::string answer =
      fmt::format("{}: {}", terminal::CoordinateText(along, ranking->best), against(next));
  if (ranking->others.size() > 1) answer += fmt::format(", and {}", against(last));
  answer += CellsNote(ranking->cells, ranking->of) + ".";
  if (next.certainty == Certainty::kTie) answer += " The first two cannot be told apart.";
  all.push_back({fmt::format("Which {} has the shortest step?", report::AxisWords(along)),
                 std::move(answer), "scaling", ranking->certainty()});
}

/// The growth over all runs, if no detectors are compared.
void AddGrowthOfAll(const ConclusionParts& parts, std::vector<Conclusion>& all) {
  const auto growth = statistics::GrowthByRow(parts.file, parts.points, {}, parts.times);
  if (!growth || !growth->is_matched || growth->exponents.empty()) return;
  const statistics::DetectorGrowth::Exponent& exponent = growth->exponents.begin()->second;
  if (std::isnan(exponent.p)) return;
  all.push_back({"How does collision detection grow with the number of objects?",
                 fmt::format("As n^{:.2f} from {:.0f} to {:.0f} objects{}. The exponent is fitted, "
                             "without an interval.",
                             exponent.p, exponent.least, exponent.most,
                             growth->is_mean ? ", the mean over all other axes" : ""),
                 "growth", Certainty::kUnknown});
}

}  // namespace

void ConcludeAxes(const ConclusionParts& parts, std::vector<Conclusion>& all) {
  if (!parts.file.Has("duration") || parts.points.empty()) return;
  const auto detectors = statistics::DetectorAxis(parts.file);
  for (std::size_t i = 0; i < parts.file.axes().size(); ++i) {
    const plan::Axis& axis = parts.file.axes()[i];
    // Times over seeds only scatter.
    if (i == detectors || axis.values.size() < 2 || axis.name == "seed") continue;
    if (axis.IsText()) {
      AddFastestValue(parts, i, all);
    } else {
      AddScaling(parts, i, all);
    }
  }
  if (!detectors || parts.file.axes()[*detectors].values.size() < 2) AddGrowthOfAll(parts, all);
}

void ConcludeStep(const ConclusionParts& parts, std::vector<Conclusion>& all) {
  if (!parts.file.axes().empty() || !parts.file.Has("duration") || parts.points.empty()) return;
  const statistics::MeasuredPoint& point = parts.points[0];
  if (!point.IsSound()) return;
  const statistics::Estimate& step = parts.times.Of(point, Phase::kStep).mean;
  Phase largest = Phase::kBroad;
  const auto time_of = [&](Phase phase) { return parts.times.Of(point, phase).mean.value; };
  for (const Phase phase : {Phase::kNarrow, Phase::kSolve, Phase::kIntegrate})
    if (time_of(phase) > time_of(largest)) largest = phase;
  const terminal::TimeUnit unit = terminal::TimeUnit::For(step.value);
  all.push_back(
      {"What does a step take?",
       fmt::format("{}{}. Its largest phase is {}: {}, {:.0f} % of the step.",
                   report::TimeText(step.value),
                   report::IntervalNote(parts.times, step, 1 / unit.ns),
                   measure::PhaseNames()[measure::IndexOf(largest)],
                   report::TimeText(time_of(largest)), 100 * time_of(largest) / step.value),
       "fastest",
       parts.times.bootstrap().kind() == statistics::IntervalKind::kInterval
           ? Certainty::kClear
           : Certainty::kUnknown});
}

}  // namespace cdb::conclusions
