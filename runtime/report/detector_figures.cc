#include "runtime/report/detector_figures.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "compiler/schema/catalogue.h"
#include "runtime/report/cells.h"
#include "runtime/report/numbers.h"

namespace cdb::report {
namespace {

using Cell = store::ResultFile::Cell;

constexpr std::size_t kLeastPoints = 3;

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

Point Project(const Cell& cell, const std::vector<std::size_t>& axes) {
  Point point;
  for (const std::size_t axis : axes) point.push_back(cell.at[axis]);
  return point;
}

bool CanFit(const plan::Axis& axis) { return !axis.IsText() && axis.values.size() >= kLeastPoints; }

/// The number of objects at each point. Empty where that is of no use, or the plan cannot be read.
std::map<Point, double> ObjectCounts(const store::ResultFile& file) {
  std::map<Point, double> objects;
  if (std::ranges::none_of(file.axes(), CanFit)) return objects;
  const auto plan = ReadPlan(file);
  if (!plan) return objects;
  for (const plan::Run& run : plan->runs)
    objects[run.at] = static_cast<double>(run.scene.ObjectCount());
  return objects;
}

/// The one axis to fit over, along which the number of objects changes; nullopt where there is
/// none, or several.
std::optional<std::size_t> CountAxis(const store::ResultFile& file,
                                     const std::map<Point, double>& objects) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < file.axes().size(); ++i) {
    if (!CanFit(file.axes()[i])) continue;
    std::map<Point, double> of_others;
    const bool changes = std::ranges::any_of(objects, [&](const auto& point) {
      Point others = point.first;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
      return of_others.emplace(std::move(others), point.second).first->second != point.second;
    });
    if (!changes) continue;
    if (found) return std::nullopt;
    found = i;
  }
  return found;
}

/// Detect of the cells that share a point on all axes beside that of the number of objects.
struct TimesAtPoint {
  Point row;
  std::map<double, std::vector<double>> by_count;
};

std::map<Point, TimesAtPoint> TimesByCount(const store::ResultFile& file,
                                           const std::vector<Cell>& cells,
                                           const std::map<Point, double>& objects,
                                           const DetectorGrowth& growth) {
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < file.axes().size(); ++i)
    if (i != growth.axis) others.push_back(i);
  std::map<Point, TimesAtPoint> times;
  for (const Cell& cell : cells) {
    const auto count = objects.find(cell.at);
    if (count == objects.end()) continue;
    TimesAtPoint& at = times[Project(cell, others)];
    at.row = Project(cell, growth.rows);
    Append(at.by_count[count->second], file.ReadDuration(measure::Phase::kDetect, cell));
  }
  return times;
}

}  // namespace

std::map<Point, DetectorCosts> DetectorCostsByRow(const store::ResultFile& file,
                                                  const std::vector<Cell>& cells,
                                                  const std::vector<std::size_t>& rows) {
  struct Row {
    std::vector<double> detect, pairs;
    double missed = kNone, phantom = kNone, peak_rss = 0, heap = 0;
  };
  std::map<Point, Row> pooled;
  const bool has_pairs = file.Has("pairs"), has_faults = file.Has("exact_pairs"),
             has_heap = file.Has("heap");
  for (const Cell& cell : cells) {
    Row& row = pooled[Project(cell, rows)];
    Append(row.detect, file.ReadDuration(measure::Phase::kDetect, cell));
    if (has_pairs) Append(row.pairs, file.ReadSeries("pairs", cell));
    if (has_faults) {
      row.missed = AddCounts(row.missed, file.ReadSeries("missed_pairs", cell));
      row.phantom = AddCounts(row.phantom, file.ReadSeries("phantom_pairs", cell));
    }
    row.peak_rss = std::fmax(row.peak_rss, file.ReadReal("peak_rss", cell));
    if (has_heap)
      for (const double bytes : file.ReadSeries("heap", cell))
        row.heap = std::fmax(row.heap, bytes);
  }
  std::map<Point, DetectorCosts> costs;
  for (const auto& [point, row] : pooled) {
    const auto worst = std::ranges::max_element(row.detect);
    costs[point] = {Median(row.detect),
                    worst == row.detect.end() ? kNone : *worst,
                    Median(row.pairs),
                    row.missed,
                    row.phantom,
                    row.peak_rss,
                    row.heap};
  }
  return costs;
}

std::optional<DetectorGrowth> GrowthByRow(const store::ResultFile& file,
                                          const std::vector<Cell>& cells,
                                          const std::vector<std::size_t>& rows) {
  const std::map<Point, double> objects = ObjectCounts(file);
  const auto axis = CountAxis(file, objects);
  if (!axis) return std::nullopt;
  DetectorGrowth growth = {*axis, rows, {}, false};
  std::erase(growth.rows, *axis);
  const auto times = TimesByCount(file, cells, objects, growth);
  std::map<Point, std::vector<double>> exponents;
  for (const auto& [point, at] : times) {
    std::vector<std::pair<double, double>> fitted;
    for (const auto& [count, values] : at.by_count) fitted.emplace_back(count, Median(values));
    auto& of_row = exponents[at.row];
    if (const double p = GrowthExponent(fitted); !std::isnan(p)) of_row.push_back(p);
  }
  for (const auto& [row, of_row] : exponents) growth.exponents[row] = Mean(of_row);
  growth.is_mean = times.size() > exponents.size();
  return growth;
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

std::optional<HarnessCost> HarnessCostOf(const store::ResultFile& file,
                                         const std::vector<Cell>& cells) {
  if (!file.Has("duration") || !file.Has("harness")) return std::nullopt;
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
  if (harness.empty()) return std::nullopt;
  HarnessCost cost = {Median(harness), std::nullopt};
  std::vector<std::pair<double, std::string>> timed;
  for (auto& [detector, medians] : detect)
    if (const double median = Median(medians); std::isfinite(median))
      timed.emplace_back(median, detector);
  if (!timed.empty()) {
    const auto& [median, detector] = *std::ranges::min_element(timed);
    cost.fastest = {median, detector, timed.size() == 1};
  }
  return cost;
}

}  // namespace cdb::report
