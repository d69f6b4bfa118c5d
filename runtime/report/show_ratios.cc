#include "runtime/report/show_ratios.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <string_view>
#include <utility>

#include "runtime/report/row_table.h"
#include "runtime/report/show.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/detector_ratios.h"
#include "runtime/terminal/table.h"

namespace cdb::report {
namespace {

/// A line if detectors that are compared at one point had different omissions.
std::string UnlikeText(const statistics::Comparison& comparison) {
  std::set<std::string> components;
  std::size_t unlike = 0;
  for (const statistics::ComparedPoint& point : comparison.points) {
    components.insert(point.unlike.begin(), point.unlike.end());
    unlike += point.unlike.empty() ? 0 : 1;
  }
  if (unlike == 0) return {};
  return fmt::format(
      "\nAt {} of {} points, some detectors ran without {} and others with it: these ratios are "
      "not due to the detectors alone. omit none makes them alike.\n",
      unlike, comparison.points.size(), fmt::join(components, ", "));
}

class RatioTable {
 public:
  RatioTable(const store::ResultFile& file, std::size_t detector_axis,
             const statistics::Comparison& comparison, statistics::CycleTimes& times)
      : file_(file),
        detector_(file.axes()[detector_axis]),
        comparison_(comparison),
        times_(times),
        others_(file.axes().size()) {
    std::iota(others_.begin(), others_.end(), std::size_t{0});
    std::erase(others_, detector_axis);
  }

  std::string Text(measure::Phase phase) {
    terminal::Table table(HeadSize());
    for (const std::size_t axis : others_)
      table.AddColumn(file_.axes()[axis].name, !file_.axes()[axis].IsText());
    if (others_.empty()) table.AddColumn("", false);
    for (std::size_t i = 0; i < detector_.values.size(); ++i)
      table.AddColumn(terminal::CoordinateText(detector_, i), true);
    if (comparison_.points.size() <= kMaxRows)
      for (const statistics::ComparedPoint& point : comparison_.points)
        AddPoint(table, point, phase);
    if (comparison_.points.size() > 1) AddMeans(table, phase);
    return fmt::format("\n{} {} over that of {}{}\n{}{}", times_.StatisticHead(),
                       measure::PhaseNames()[measure::IndexOf(phase)],
                       terminal::CoordinateText(detector_, comparison_.baseline),
                       comparison_.points.size() > 1 ? " (geometric mean below)" : "", table.Text(),
                       Legend());
  }

 private:
  bool HasIntervals() const {
    return times_.bootstrap().kind() != statistics::IntervalKind::kAbsent;
  }
  std::size_t HeadSize() const { return std::max<std::size_t>(1, others_.size()); }

  void AddPoint(terminal::Table& table, const statistics::ComparedPoint& point,
                measure::Phase phase) {
    std::vector<std::string> row = Coordinates(file_, others_, point.at), below;
    row.resize(HeadSize());
    below.resize(HeadSize());
    for (std::size_t i = 0; i < detector_.values.size(); ++i) {
      const auto ratio = statistics::RatioAt(comparison_, point, i, phase, times_);
      const std::string text = ratio ? terminal::ShortNumber(ratio->value) : "-";
      const bool counts = point.is_matched && !comparison_.is_void;
      row.push_back(counts || !ratio ? text : "(" + text + ")");
      has_parentheses_ = has_parentheses_ || (ratio && !counts);
      below.push_back(ratio && i != comparison_.baseline
                          ? statistics::IntervalText(times_.IntervalOf(*ratio))
                          : "");
    }
    table.AddRow(std::move(row));
    const bool is_empty = std::ranges::all_of(below, &std::string::empty);
    if (HasIntervals() && !is_empty) table.AddRow(std::move(below));
  }

  void AddMeans(terminal::Table& table, measure::Phase phase) {
    std::vector<std::string> mean(HeadSize()), interval(HeadSize()), range(HeadSize());
    mean[0] = "mean";
    range[0] = "range";
    for (std::size_t i = 0; i < detector_.values.size(); ++i) {
      const std::vector<statistics::Estimate> ratios =
          statistics::MatchedRatios(comparison_, i, phase, times_);
      if (ratios.empty()) {
        for (auto* row : {&mean, &interval, &range}) row->push_back("-");
        continue;
      }
      const statistics::Estimate all = statistics::GeometricMeanOf(ratios);
      const auto [least, most] = std::ranges::minmax(ratios, {}, &statistics::Estimate::value);
      mean.push_back(comparison_.is_void ? "(" + terminal::ShortNumber(all.value) + ")"
                                         : terminal::ShortNumber(all.value));
      interval.push_back(
          i == comparison_.baseline ? "" : statistics::IntervalText(times_.IntervalOf(all)));
      range.push_back(statistics::IntervalText({least.value, most.value}));
    }
    table.AddRow(std::move(mean));
    if (HasIntervals()) table.AddRow(std::move(interval));
    table.AddRow(std::move(range));
  }

  /// Explains the numbers below each ratio, and the means.
  std::string Legend() const {
    std::string text = "  No interval: one repeat.\n";
    if (times_.bootstrap().kind() == statistics::IntervalKind::kRange)
      text =
          "  Below each ratio its range over all draws of repeats, the same for both detectors.\n";
    if (times_.bootstrap().kind() == statistics::IntervalKind::kInterval)
      text =
          "  Below each ratio its 95 % interval: bootstrap over repeats, the same for both "
          "detectors.\n";
    const std::size_t all = comparison_.points.size(), matched = comparison_.MatchedCount();
    if (all > 1)
      text += fmt::format("  Mean and range over {} of {} cells{}.\n", matched, all,
                          matched < all ? ": those that all detectors have" : "");
    if (comparison_.is_void) return text + "  In parentheses: every run is void.\n";
    if (has_parentheses_)
      text += "  In parentheses: a detector is void, missing, or has other omissions.\n";
    return text;
  }

  const store::ResultFile& file_;
  const plan::Axis& detector_;
  const statistics::Comparison& comparison_;
  statistics::CycleTimes& times_;
  std::vector<std::size_t> others_;  ///< indices of axes
  bool has_parentheses_ = false;     ///< some ratio is not included in the means
};

}  // namespace

std::optional<std::size_t> FindBaseline(const store::ResultFile& file, const std::string& name) {
  if (name.empty()) return std::nullopt;
  const auto axis = statistics::DetectorAxis(file);
  if (!axis)
    throw files::StoreError(
        fmt::format("there is no baseline '{}': this file sweeps no detectors", name));
  const plan::Axis& detectors = file.axes()[*axis];
  std::string names;
  for (std::size_t i = 0; i < detectors.values.size(); ++i) {
    const std::string detector = terminal::CoordinateText(detectors, i);
    if (detector == name) return i;
    names += (i == 0 ? "" : ", ") + detector;
  }
  throw files::StoreError(
      fmt::format("there is no detector '{}' in this file; there are {}", name, names));
}

std::string ShowRatios(const store::ResultFile& file,
                       const std::vector<statistics::MeasuredPoint>& points,
                       std::optional<std::size_t> baseline,
                       const std::vector<measure::Phase>& phases, statistics::CycleTimes& times) {
  const auto axis = statistics::DetectorAxis(file);
  if (!axis || file.axes()[*axis].values.size() < 2 || !file.Has("duration") || points.empty())
    return {};
  const statistics::Comparison comparison =
      statistics::CompareDetectors(file, points, *axis, baseline);
  RatioTable table(file, *axis, comparison, times);
  std::string text = UnlikeText(comparison);
  if (phases.empty())
    return text + table.Text(measure::Phase::kDetect) + table.Text(measure::Phase::kStep);
  for (const measure::Phase phase : phases) text += table.Text(phase);
  return text;
}

}  // namespace cdb::report
