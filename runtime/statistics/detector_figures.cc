#include "runtime/statistics/detector_figures.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "compiler/schema/catalogue.h"
#include "compiler/yaml/brief_runs.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/figures.h"
#include "runtime/statistics/numbers.h"

namespace cdb::statistics {
namespace {

using Cell = store::ResultFile::Cell;

constexpr std::size_t kLeastPoints = 3;

double Median(std::vector<double> values) {
  std::ranges::sort(values);
  return Percentile(values, 0.5);
}

/// Adds the counts of the cycles that have a value.
double AddCounts(double sum, const std::vector<double>& counts) {
  for (const double count : counts)
    if (count >= 0) sum = (std::isnan(sum) ? 0 : sum) + count;
  return sum;
}

bool CanFit(const plan::Axis& axis) { return !axis.IsText() && axis.values.size() >= kLeastPoints; }

/// The number of objects at each point. Empty if it is not useful, or the plan cannot be read.
std::map<Point, double> ObjectCounts(const store::ResultFile& file) {
  std::map<Point, double> objects;
  if (std::ranges::none_of(file.axes(), CanFit)) return objects;
  const auto runs = yaml::FindBriefRuns(file.ReadProvenance("plan_text"));
  if (!runs) return objects;
  for (const yaml::BriefRun& run : *runs)
    if (const auto at = file.SelectedPoint(run.at)) objects[*at] = static_cast<double>(run.objects);
  return objects;
}

/// The axis to fit over: the only one that changes the number of objects. Nullopt if there is none,
/// or several.
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

/// Times of detect at points that differ only in the number of objects.
struct TimesAtPoint {
  Point row;
  std::map<double, std::vector<double>> by_count;
};

std::map<Point, TimesAtPoint> TimesByCount(const std::vector<MeasuredPoint>& points,
                                           const std::map<Point, double>& objects,
                                           const DetectorGrowth& growth, CycleTimes& times) {
  std::map<Point, TimesAtPoint> found;
  for (const MeasuredPoint& point : points) {
    const auto count = objects.find(point.at);
    if (count == objects.end() || !point.IsSound()) continue;
    TimesAtPoint& at = found[Without(point.at, growth.axis)];
    at.row = Project(point.at, growth.rows);
    at.by_count[count->second].push_back(times.Of(point, measure::Phase::kDetect).mean.value);
  }
  return found;
}

/// Drops the numbers of objects that some point lacks, if enough remain to fit over.
void MatchCounts(std::map<Point, TimesAtPoint>& found, DetectorGrowth& growth) {
  std::map<double, std::size_t> having;
  for (const auto& [point, at] : found)
    for (const auto& [count, times] : at.by_count) ++having[count];
  const std::size_t all = having.size();
  std::erase_if(having, [&](const auto& count) { return count.second < found.size(); });
  growth.is_matched = having.size() == all || having.size() >= kLeastPoints;
  if (!growth.is_matched) return;
  growth.dropped = all - having.size();
  for (auto& [point, at] : found)
    std::erase_if(at.by_count, [&](const auto& count) { return !having.contains(count.first); });
}

}  // namespace

DetectorCosts CostsOf(const store::ResultFile& file, const Row& row, CycleTimes& times) {
  DetectorCosts costs = {{}, kNone, 0, kNone, kNone, kNone, kNone};
  std::vector<Estimate> means;
  std::vector<double> pairs;
  for (const MeasuredPoint* point : row.points) {
    const PhaseTimes& detect = times.Of(*point, measure::Phase::kDetect);
    means.push_back(times.FigureOf(*point, measure::Phase::kDetect));
    for (const double ns : detect.cycles) costs.worst = std::fmax(costs.worst, ns);
    if (file.Has("pairs")) pairs.push_back(Mean(file.ReadSeries("pairs", point->cells[0])));
    for (const Cell& cell : point->cells) {
      if (file.Has("exact_pairs")) {
        costs.missed = AddCounts(costs.missed, file.ReadSeries("missed_pairs", cell));
        costs.phantom = AddCounts(costs.phantom, file.ReadSeries("phantom_pairs", cell));
      }
      costs.peak_rss = std::fmax(costs.peak_rss, file.ReadReal("peak_rss", cell));
      if (file.Has("heap"))
        for (const double bytes : file.ReadSeries("heap", cell))
          costs.heap = std::fmax(costs.heap, bytes);
    }
  }
  costs.mean = MeanOf(means);
  costs.pairs = Mean(pairs);
  return costs;
}

std::optional<DetectorGrowth> GrowthByRow(const store::ResultFile& file,
                                          const std::vector<MeasuredPoint>& points,
                                          const std::vector<std::size_t>& rows, CycleTimes& times) {
  const std::map<Point, double> objects = ObjectCounts(file);
  const auto axis = CountAxis(file, objects);
  if (!axis) return std::nullopt;
  DetectorGrowth growth = {*axis, rows, {}};
  std::erase(growth.rows, *axis);
  auto found = TimesByCount(points, objects, growth, times);
  MatchCounts(found, growth);
  std::map<Point, std::vector<double>> exponents;
  for (const auto& [point, at] : found) {
    std::vector<std::pair<double, double>> fitted;
    for (const auto& [count, values] : at.by_count) fitted.emplace_back(count, Median(values));
    auto& of_row = exponents[at.row];
    if (const double p = GrowthExponent(fitted); !std::isnan(p)) of_row.push_back(p);
    auto& row = growth.exponents.try_emplace(at.row, kNone, kNone, kNone).first->second;
    row.least = std::fmin(row.least, fitted.front().first);
    row.most = std::fmax(row.most, fitted.back().first);
  }
  for (const auto& [row, of_row] : exponents) growth.exponents[row].p = Mean(of_row);
  growth.is_mean = found.size() > exponents.size();
  for (const MeasuredPoint& point : points)
    for (const std::string& name : point.unlike)
      if (point.IsSound() && std::ranges::find(growth.unlike, name) == growth.unlike.end())
        growth.unlike.push_back(name);
  return growth;
}

double GrowthExponent(const std::vector<std::pair<double, double>>& points) {
  std::vector<double> xs;
  std::vector<double> ys;
  for (const auto& [x, y] : points) {
    if (!(x > 0) || !(y > 0)) return kNone;
    xs.push_back(std::log(x));
    ys.push_back(std::log(y));
  }
  if (std::set<double>(xs.begin(), xs.end()).size() < kLeastPoints) return kNone;
  const double middle_x = Mean(xs);
  const double middle_y = Mean(ys);
  double across = 0;
  double along = 0;
  for (std::size_t i = 0; i < xs.size(); ++i) {
    across += (xs[i] - middle_x) * (ys[i] - middle_y);
    along += (xs[i] - middle_x) * (xs[i] - middle_x);
  }
  return across / along;
}

std::optional<HarnessCost> HarnessCostOf(const store::ResultFile& file,
                                         const std::vector<MeasuredPoint>& points,
                                         CycleTimes& times) {
  if (!file.Has("duration") || !file.Has("harness")) return std::nullopt;
  std::vector<double> harness;
  std::map<std::string, std::vector<double>> detect;
  const CellDetectors detectors(file);
  for (const MeasuredPoint& point : points) {
    if (!point.IsSound()) continue;
    for (const Cell& cell : point.cells)
      if (const double ns = file.ReadReal("harness", cell); std::isfinite(ns))
        harness.push_back(ns);
    const std::string detector = detectors.Of(point.cells[0]);
    const schema::DetectorInfo* info = schema::FindDetector(detector);
    // For a detector that finds nothing, the whole time is harness.
    if (info == nullptr || info->family != "none")
      detect[detector].push_back(times.Of(point, measure::Phase::kDetect).mean.value);
  }
  if (harness.empty()) return std::nullopt;
  HarnessCost cost = {Median(harness), std::nullopt};
  std::vector<std::pair<double, std::string>> timed;
  for (auto& [detector, of_points] : detect)
    if (const double time = Median(of_points); std::isfinite(time))
      timed.emplace_back(time, detector);
  if (!timed.empty()) {
    const auto& [time, detector] = *std::ranges::min_element(timed);
    cost.fastest = {time, detector, timed.size() == 1};
  }
  return cost;
}

}  // namespace cdb::statistics
