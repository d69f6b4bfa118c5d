#include "runtime/report/show_detectors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "runtime/report/row_table.h"
#include "runtime/report/show.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/detector_figures.h"
#include "runtime/statistics/figures.h"
#include "runtime/terminal/table.h"

namespace cdb::report {
namespace {

/// The axes that make rows, detectors last so that their rows are adjacent.
std::vector<std::size_t> RowsOf(const store::ResultFile& file, std::size_t point_count,
                                std::size_t detector_axis, std::vector<std::size_t> by) {
  if (by.empty() && point_count <= kMaxRows) {
    by.resize(file.axes().size());
    std::iota(by.begin(), by.end(), std::size_t{0});
  }
  std::erase(by, detector_axis);
  by.push_back(detector_axis);
  return by;
}

std::string CountText(double count) {
  return std::isnan(count) ? "-" : fmt::format("{:.0f}", count);
}

std::string ExponentText(double p) {
  // Avoids "-0.00".
  return std::isnan(p) ? "-" : fmt::format("{:.2f}", std::round(100 * p) / 100 + 0.0);
}

/// The unit in which most means are easy to read.
terminal::TimeUnit UnitOf(const std::vector<statistics::DetectorCosts>& costs) {
  std::vector<double> means;
  for (const statistics::DetectorCosts& row : costs) means.push_back(row.mean.value);
  std::ranges::sort(means);
  return terminal::TimeUnit::For(statistics::Percentile(means, 0.5));
}

std::string CostsText(const store::ResultFile& file,
                      const std::vector<statistics::MeasuredPoint>& points,
                      const std::vector<std::size_t>& by, statistics::CycleTimes& times) {
  const statistics::Rows rows = statistics::MatchRows(points, by);
  std::vector<statistics::DetectorCosts> costs;
  for (const statistics::Row& row : rows.rows)
    costs.push_back(statistics::CostsOf(file, row, times));
  const terminal::TimeUnit unit = UnitOf(costs);
  const bool has_intervals = times.bootstrap().kind() != statistics::IntervalKind::kAbsent;
  RowTable table(file, by, rows.pools);
  table.AddColumn(times.statistic() == statistics::CycleStatistic::kWorst ? "worst of any repeat"
                                                                          : times.StatisticName());
  if (has_intervals) table.AddColumn(times.IntervalName());
  table.AddColumn("worst");
  if (file.Has("pairs")) table.AddColumn("pairs");
  if (file.Has("exact_pairs"))
    for (const char* head : {"missed", "phantom"}) table.AddColumn(head);
  table.AddColumn("peak rss, MB");
  if (file.Has("heap")) table.AddColumn("heap, MB");
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const statistics::DetectorCosts& row = costs[i];
    std::vector<std::string> texts = {terminal::ShortNumber(row.mean.value / unit.ns)};
    if (has_intervals)
      texts.push_back(
          statistics::IntervalText(times.IntervalOf(statistics::Scaled(row.mean, 1 / unit.ns))));
    texts.push_back(terminal::ShortNumber(row.worst / unit.ns));
    if (file.Has("pairs")) texts.push_back(terminal::ShortNumber(row.pairs));
    if (file.Has("exact_pairs"))
      for (const double count : {row.missed, row.phantom}) texts.push_back(CountText(count));
    texts.push_back(terminal::ShortNumber(row.peak_rss / 1e6));
    if (file.Has("heap")) texts.push_back(terminal::ShortNumber(row.heap / 1e6));
    table.AddRow(rows.rows[i], std::move(texts));
  }
  return fmt::format("\nDetectors: a cycle's detect, {}\n{}{}{}", unit.name, table.Text(),
                     times.StatisticAndIntervalLine(rows.pools), rows.MatchLines());
}

/// The range of the number of objects over which an exponent is fitted: `10 .. 40`.
std::string ObjectsText(const statistics::DetectorGrowth::Exponent& exponent) {
  return CountText(exponent.least) + " .. " + CountText(exponent.most);
}

/// Notes to read before the exponents of two rows are compared.
std::string GrowthNotes(const statistics::DetectorGrowth& growth) {
  std::string text;
  if (!growth.is_matched)
    text += "  The rows have different numbers of objects: do not compare them.\n";
  if (growth.dropped > 0)
    text += fmt::format("  Over the numbers of objects that all rows have, {}.\n",
                        ObjectsText(growth.exponents.begin()->second));
  if (!growth.unlike.empty())
    text += fmt::format(
        "  Some points ran without {} and others with it: the growth is not due to the number of "
        "objects alone.\n",
        fmt::join(growth.unlike, ", "));
  return text;
}

std::string GrowthText(const store::ResultFile& file,
                       const std::vector<statistics::MeasuredPoint>& points,
                       const std::vector<std::size_t>& rows, statistics::CycleTimes& times) {
  const auto growth = statistics::GrowthByRow(file, points, rows, times);
  if (!growth || growth->exponents.empty()) return {};
  terminal::Table table;
  for (const std::size_t axis : growth->rows)
    table.AddColumn(file.axes()[axis].name, !file.axes()[axis].IsText());
  table.AddColumn("p", true);
  if (!growth->is_matched) table.AddColumn("objects", true);
  for (const auto& [point, exponent] : growth->exponents) {
    std::vector<std::string> texts = Coordinates(file, growth->rows, point);
    texts.push_back(ExponentText(exponent.p));
    if (!growth->is_matched) texts.push_back(ObjectsText(exponent));
    table.AddRow(std::move(texts));
  }
  return fmt::format(
      "\nGrowth over {}: p of detect ~ objects^p{}\n{}{}", file.axes()[growth->axis].name,
      growth->is_mean ? ", the mean over all else" : "", table.Text(), GrowthNotes(*growth));
}

}  // namespace

std::string ShowDetectors(const store::ResultFile& file,
                          const std::vector<statistics::MeasuredPoint>& points,
                          const std::vector<std::size_t>& by, statistics::CycleTimes& times) {
  const auto axis = statistics::DetectorAxis(file);
  if (!axis || file.axes()[*axis].values.size() < 2 || !file.Has("duration") || points.empty())
    return {};
  const std::vector<std::size_t> rows = RowsOf(file, points.size(), *axis, by);
  return CostsText(file, points, rows, times) + GrowthText(file, points, rows, times);
}

std::string HarnessText(const store::ResultFile& file,
                        const std::vector<statistics::MeasuredPoint>& points,
                        statistics::CycleTimes& times) {
  const auto cost = statistics::HarnessCostOf(file, points, times);
  if (!cost) return {};
  std::string text =
      fmt::format("  Measurement overhead: {} ns per cycle", terminal::ShortNumber(cost->median));
  if (const auto& fastest = cost->fastest)
    text += fmt::format(", {} % of the detection of {}{}",
                        terminal::ShortNumber(100 * cost->median / fastest->time),
                        fastest->detector.empty() ? "the detector" : fastest->detector,
                        fastest->is_only ? "" : ", the fastest");
  return text + "; not subtracted.\n";
}

}  // namespace cdb::report
