#include "runtime/report/show_detectors.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "compiler/schema/catalogue.h"
#include "runtime/report/cells.h"
#include "runtime/report/figures.h"
#include "runtime/report/numbers.h"
#include "runtime/report/show.h"
#include "runtime/report/table.h"

namespace cdb::report {
namespace {

using Cell = store::ResultFile::Cell;
using Key = std::vector<std::size_t>;

constexpr std::size_t kLeastPoints = 3;

/// What makes a row: all of one detector that is pooled there.
struct Row {
  std::vector<double> detect, pairs;
  double missed = kNone, phantom = kNone;  ///< sums; NaN where nobody looked
  double peak_rss = 0, heap = 0;           ///< bytes, the most
};

double Median(std::vector<double> values) {
  std::ranges::sort(values);
  return Percentile(values, 0.5);
}

/// Of the cycles that have a value.
double AddCounts(double sum, const std::vector<double>& counts) {
  for (const double count : counts)
    if (count >= 0) sum = (std::isnan(sum) ? 0 : sum) + count;
  return sum;
}

std::string ExponentText(double p) {
  // Without "-0.00".
  return std::isnan(p) ? "-" : fmt::format("{:.2f}", std::round(100 * p) / 100 + 0.0);
}

class Comparison {
 public:
  Comparison(const store::ResultFile& file, const std::vector<Cell>& cells,
             const std::vector<std::size_t>& by)
      : file_(file), cells_(cells), detector_(*DetectorAxis(file)), rows_(RowsOf(by)) {}

  std::string Text() const { return Costs() + Growth(); }

 private:
  /// The axes that make rows, detectors last so that rivals stand side by side.
  std::vector<std::size_t> RowsOf(std::vector<std::size_t> by) const {
    std::size_t rows = 1;
    if (by.empty()) {
      for (std::size_t i = 0; i < file_.axes().size(); ++i) {
        by.push_back(i);
        rows *= file_.axes()[i].values.size();
      }
    }
    if (rows > kMaxRows) by.clear();
    std::erase(by, detector_);
    by.push_back(detector_);
    return by;
  }

  static Key Project(const Cell& cell, const std::vector<std::size_t>& axes) {
    Key key;
    for (const std::size_t axis : axes) key.push_back(cell.at[axis]);
    return key;
  }

  std::map<Key, Row> Collect() const {
    std::map<Key, Row> rows;
    const bool has_heap = file_.Has("heap");
    for (const Cell& cell : cells_) {
      Row& row = rows[Project(cell, rows_)];
      Append(row.detect, file_.ReadDuration(measure::Phase::kDetect, cell));
      if (file_.Has("pairs")) Append(row.pairs, file_.ReadSeries("pairs", cell));
      if (file_.Has("exact_pairs")) {
        row.missed = AddCounts(row.missed, file_.ReadSeries("missed_pairs", cell));
        row.phantom = AddCounts(row.phantom, file_.ReadSeries("phantom_pairs", cell));
      }
      row.peak_rss = std::fmax(row.peak_rss, file_.ReadReal("peak_rss", cell));
      if (has_heap)
        for (const double bytes : file_.ReadSeries("heap", cell))
          row.heap = std::fmax(row.heap, bytes);
    }
    return rows;
  }

  std::string Costs() const {
    const auto rows = Collect();
    std::vector<double> medians;
    for (const auto& [key, row] : rows) medians.push_back(Median(row.detect));
    const TimeUnit unit = TimeUnit::For(Median(medians));
    Table table;
    for (const std::size_t axis : rows_)
      table.AddColumn(file_.axes()[axis].name, !file_.axes()[axis].IsText());
    const bool has_pairs = file_.Has("pairs"), has_faults = file_.Has("exact_pairs");
    for (const char* head : {"median", "worst"}) table.AddColumn(head, true);
    if (has_pairs) table.AddColumn("pairs", true);
    if (has_faults)
      for (const char* head : {"missed", "phantom"}) table.AddColumn(head, true);
    table.AddColumn("peak rss, MB", true);
    if (file_.Has("heap")) table.AddColumn("heap, MB", true);
    for (const auto& [key, row] : rows) {
      std::vector<std::string> cells;
      for (std::size_t i = 0; i < key.size(); ++i)
        cells.push_back(CoordinateText(file_.axes()[rows_[i]], key[i]));
      cells.push_back(ShortNumber(Median(row.detect) / unit.ns));
      const auto worst = std::ranges::max_element(row.detect);
      cells.push_back(ShortNumber(worst == row.detect.end() ? kNone : *worst / unit.ns));
      if (has_pairs) cells.push_back(ShortNumber(Median(row.pairs)));
      if (has_faults)
        for (const double count : {row.missed, row.phantom})
          cells.push_back(std::isnan(count) ? "-" : fmt::format("{:.0f}", count));
      cells.push_back(ShortNumber(row.peak_rss / 1e6));
      if (file_.Has("heap")) cells.push_back(ShortNumber(row.heap / 1e6));
      table.AddRow(std::move(cells));
    }
    return fmt::format("\nDetectors: a cycle's detect, {}\n{}", unit.name, table.Text());
  }

  static bool CanFit(const plan::Axis& axis) {
    return !axis.IsText() && axis.values.size() >= kLeastPoints;
  }

  /// How many objects each point has. Empty where that is of no use, or the plan cannot be asked.
  std::map<Key, double> Objects() const {
    std::map<Key, double> objects;
    if (std::ranges::none_of(file_.axes(), CanFit)) return objects;
    const auto plan = ReadPlan(file_);
    if (!plan) return objects;
    for (const plan::Run& run : plan->runs)
      objects[run.at] = static_cast<double>(run.scene.ObjectCount());
    return objects;
  }

  /// The one axis to fit over, along which the number of objects changes; nullopt where there is
  /// none, or several.
  std::optional<std::size_t> CountAxis(const std::map<Key, double>& objects) const {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < file_.axes().size(); ++i) {
      if (!CanFit(file_.axes()[i])) continue;
      std::map<Key, double> of_others;
      const bool changes = std::ranges::any_of(objects, [&](const auto& point) {
        Key others = point.first;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
        return of_others.emplace(std::move(others), point.second).first->second != point.second;
      });
      if (!changes) continue;
      if (found) return std::nullopt;
      found = i;
    }
    return found;
  }

  /// Fitted at each point of the axes beside the one that changes the number of objects; rows as
  /// those of the costs, and the mean of what is pooled there.
  std::string Growth() const {
    const std::map<Key, double> objects = Objects();
    const auto count = CountAxis(objects);
    if (!count) return {};
    std::vector<std::size_t> others, rows = rows_;
    for (std::size_t i = 0; i < file_.axes().size(); ++i)
      if (i != *count) others.push_back(i);
    std::erase(rows, *count);
    std::map<Key, std::map<double, std::vector<double>>> times;
    std::map<Key, Key> row_of;
    for (const Cell& cell : cells_) {
      const Key point = Project(cell, others);
      row_of[point] = Project(cell, rows);
      const auto size = objects.find(cell.at);
      if (size != objects.end())
        Append(times[point][size->second], file_.ReadDuration(measure::Phase::kDetect, cell));
    }
    std::map<Key, std::vector<double>> exponents;
    for (const auto& [point, by_count] : times) {
      std::vector<std::pair<double, double>> fitted;
      for (const auto& [size, values] : by_count) fitted.emplace_back(size, Median(values));
      auto& of_row = exponents[row_of[point]];
      if (const double p = GrowthExponent(fitted); !std::isnan(p)) of_row.push_back(p);
    }
    Table table;
    for (const std::size_t axis : rows)
      table.AddColumn(file_.axes()[axis].name, !file_.axes()[axis].IsText());
    table.AddColumn("p", true);
    for (const auto& [key, of_row] : exponents) {
      std::vector<std::string> cells;
      for (std::size_t i = 0; i < key.size(); ++i)
        cells.push_back(CoordinateText(file_.axes()[rows[i]], key[i]));
      cells.push_back(ExponentText(std::accumulate(of_row.begin(), of_row.end(), 0.0) /
                                   static_cast<double>(of_row.size())));
      table.AddRow(std::move(cells));
    }
    return fmt::format("\nGrowth over {}: p of detect ~ objects^p{}\n{}", file_.axes()[*count].name,
                       times.size() > exponents.size() ? ", the mean over all else" : "",
                       table.Text());
  }

  const store::ResultFile& file_;
  const std::vector<Cell>& cells_;
  const std::size_t detector_;
  const std::vector<std::size_t> rows_;
};

}  // namespace

std::string ShowDetectors(const store::ResultFile& file, const std::vector<Cell>& cells,
                          const std::vector<std::size_t>& by) {
  const auto axis = DetectorAxis(file);
  if (!axis || file.axes()[*axis].values.size() < 2 || !file.Has("duration") || cells.empty())
    return {};
  return Comparison(file, cells, by).Text();
}

std::string HarnessText(const store::ResultFile& file, const std::vector<Cell>& cells) {
  if (!file.Has("duration") || !file.Has("harness")) return {};
  std::vector<double> harness;
  std::map<std::string, std::vector<double>> detect;
  const CellDetectors detectors(file);
  for (const Cell& cell : cells) {
    const double ns = file.ReadReal("harness", cell);
    if (std::isfinite(ns)) harness.push_back(ns);
    const std::string detector = detectors.Of(cell);
    const schema::DetectorInfo* info = schema::FindDetector(detector);
    // What finds nothing is all harness.
    if (info == nullptr || info->family != "none")
      detect[detector].push_back(Median(file.ReadDuration(measure::Phase::kDetect, cell)));
  }
  if (harness.empty()) return {};
  const double ns = Median(harness);
  std::string text = fmt::format("  Harness: {} ns a cycle", ShortNumber(ns));
  std::vector<std::pair<double, std::string>> fastest;
  for (auto& [detector, medians] : detect)
    if (const double median = Median(medians); std::isfinite(median))
      fastest.emplace_back(median, detector);
  if (!fastest.empty()) {
    const auto& [median, detector] = *std::ranges::min_element(fastest);
    text += fmt::format(", {} % of the detect of {}{}", ShortNumber(100 * ns / median),
                        detector.empty() ? "the detector" : detector,
                        fastest.size() > 1 ? ", the fastest" : "");
  }
  return text + "; nothing is subtracted.\n";
}

double GrowthExponent(const std::vector<std::pair<double, double>>& points) {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixX2d terms(n, 2);
  Eigen::VectorXd logs(n);
  std::vector<double> xs;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& [x, y] = points[static_cast<std::size_t>(i)];
    if (!(x > 0) || !(y > 0)) return kNone;
    terms.row(i) << std::log(x), 1;
    logs[i] = std::log(y);
    if (std::ranges::find(xs, x) == xs.end()) xs.push_back(x);
  }
  if (xs.size() < kLeastPoints) return kNone;
  return terms.colPivHouseholderQr().solve(logs)[0];
}

}  // namespace cdb::report
