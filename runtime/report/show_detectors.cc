#include "runtime/report/show_detectors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/report/cells.h"
#include "runtime/report/detector_figures.h"
#include "runtime/report/show.h"
#include "runtime/report/table.h"

namespace cdb::report {
namespace {

using Cell = store::ResultFile::Cell;

/// The axes that make rows, detectors last so that they stand side by side.
std::vector<std::size_t> RowsOf(const store::ResultFile& file, std::size_t detector_axis,
                                std::vector<std::size_t> by) {
  std::size_t rows = 1;
  if (by.empty()) {
    for (std::size_t i = 0; i < file.axes().size(); ++i) {
      by.push_back(i);
      rows *= file.axes()[i].values.size();
    }
  }
  if (rows > kMaxRows) by.clear();
  std::erase(by, detector_axis);
  by.push_back(detector_axis);
  return by;
}

Table TableOf(const store::ResultFile& file, const std::vector<std::size_t>& rows) {
  Table table;
  for (const std::size_t axis : rows)
    table.AddColumn(file.axes()[axis].name, !file.axes()[axis].IsText());
  return table;
}

/// The first columns of a row.
std::vector<std::string> Coordinates(const store::ResultFile& file,
                                     const std::vector<std::size_t>& rows, const Point& point) {
  std::vector<std::string> cells;
  for (std::size_t i = 0; i < point.size(); ++i)
    cells.push_back(CoordinateText(file.axes()[rows[i]], point[i]));
  return cells;
}

std::string CountText(double count) {
  return std::isnan(count) ? "-" : fmt::format("{:.0f}", count);
}

std::string ExponentText(double p) {
  // Without "-0.00".
  return std::isnan(p) ? "-" : fmt::format("{:.2f}", std::round(100 * p) / 100 + 0.0);
}

/// The unit in which most medians are read easily.
TimeUnit UnitOf(const std::map<Point, DetectorCosts>& costs) {
  std::vector<double> medians;
  for (const auto& [point, row] : costs) medians.push_back(row.median);
  std::ranges::sort(medians);
  return TimeUnit::For(Percentile(medians, 0.5));
}

std::string CostsText(const store::ResultFile& file, const std::vector<Cell>& cells,
                      const std::vector<std::size_t>& rows) {
  const auto costs = DetectorCostsByRow(file, cells, rows);
  const TimeUnit unit = UnitOf(costs);
  const bool has_pairs = file.Has("pairs"), has_faults = file.Has("exact_pairs"),
             has_heap = file.Has("heap");
  Table table = TableOf(file, rows);
  for (const char* head : {"median", "worst"}) table.AddColumn(head, true);
  if (has_pairs) table.AddColumn("pairs", true);
  if (has_faults)
    for (const char* head : {"missed", "phantom"}) table.AddColumn(head, true);
  table.AddColumn("peak rss, MB", true);
  if (has_heap) table.AddColumn("heap, MB", true);
  for (const auto& [point, row] : costs) {
    std::vector<std::string> texts = Coordinates(file, rows, point);
    texts.push_back(ShortNumber(row.median / unit.ns));
    texts.push_back(ShortNumber(row.worst / unit.ns));
    if (has_pairs) texts.push_back(ShortNumber(row.pairs));
    if (has_faults)
      for (const double count : {row.missed, row.phantom}) texts.push_back(CountText(count));
    texts.push_back(ShortNumber(row.peak_rss / 1e6));
    if (has_heap) texts.push_back(ShortNumber(row.heap / 1e6));
    table.AddRow(std::move(texts));
  }
  return fmt::format("\nDetectors: a cycle's detect, {}\n{}", unit.name, table.Text());
}

std::string GrowthText(const store::ResultFile& file, const std::vector<Cell>& cells,
                       const std::vector<std::size_t>& rows) {
  const auto growth = GrowthByRow(file, cells, rows);
  if (!growth) return {};
  Table table = TableOf(file, growth->rows);
  table.AddColumn("p", true);
  for (const auto& [point, exponent] : growth->exponents) {
    std::vector<std::string> texts = Coordinates(file, growth->rows, point);
    texts.push_back(ExponentText(exponent));
    table.AddRow(std::move(texts));
  }
  return fmt::format("\nGrowth over {}: p of detect ~ objects^p{}\n{}",
                     file.axes()[growth->axis].name,
                     growth->is_mean ? ", the mean over all else" : "", table.Text());
}

}  // namespace

std::string ShowDetectors(const store::ResultFile& file, const std::vector<Cell>& cells,
                          const std::vector<std::size_t>& by) {
  const auto axis = DetectorAxis(file);
  if (!axis || file.axes()[*axis].values.size() < 2 || !file.Has("duration") || cells.empty())
    return {};
  const std::vector<std::size_t> rows = RowsOf(file, *axis, by);
  return CostsText(file, cells, rows) + GrowthText(file, cells, rows);
}

std::string HarnessText(const store::ResultFile& file, const std::vector<Cell>& cells) {
  const auto cost = HarnessCostOf(file, cells);
  if (!cost) return {};
  std::string text = fmt::format("  Harness: {} ns a cycle", ShortNumber(cost->median));
  if (const auto& fastest = cost->fastest)
    text += fmt::format(", {} % of the detect of {}{}",
                        ShortNumber(100 * cost->median / fastest->median),
                        fastest->detector.empty() ? "the detector" : fastest->detector,
                        fastest->is_only ? "" : ", the fastest");
  return text + "; nothing is subtracted.\n";
}

}  // namespace cdb::report
