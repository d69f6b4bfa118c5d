#include "runtime/report/show_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "runtime/report/conclusion_words.h"
#include "runtime/report/row_table.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/numbers.h"
#include "runtime/terminal/log_plot.h"
#include "runtime/terminal/table.h"

namespace cdb::report {
namespace {

constexpr std::size_t kMaxSparklines = 24, kSparkWidth = 50;
/// An axis with fewer numbers gets no curve.
constexpr std::size_t kLeastOnAxis = 3;
constexpr std::string_view kBars[] = {"\u2581", "\u2582", "\u2583", "\u2584",
                                      "\u2585", "\u2586", "\u2587", "\u2588"};
constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyz";

std::vector<double> Bins(const std::vector<double>& values, std::size_t width) {
  const std::size_t count = std::min(values.size(), width);
  std::vector<double> bins;
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0, n = 0;
    for (std::size_t j = i * values.size() / count; j < (i + 1) * values.size() / count; ++j) {
      if (std::isnan(values[j])) continue;
      sum += values[j];
      ++n;
    }
    bins.push_back(sum / n);
  }
  return bins;
}

std::string OverCycles(const store::ResultFile& file,
                       const std::vector<statistics::MeasuredPoint>& points, measure::Phase phase,
                       statistics::CycleTimes& times) {
  terminal::Table table(file.axes().size());
  for (const plan::Axis& axis : file.axes()) table.AddColumn(axis.name, !axis.IsText());
  table.AddColumn("over the cycles", false);
  table.AddColumn("least", true);
  table.AddColumn("most", true);
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < file.axes().size(); ++i) all.push_back(i);
  for (std::size_t i = 0; i < std::min(points.size(), kMaxSparklines); ++i) {
    const std::vector<double>& cycles = times.Of(points[i], phase).cycles;
    double least = statistics::kNone, most = statistics::kNone;
    for (const double ns : cycles) {
      least = std::fmin(least, ns);
      most = std::fmax(most, ns);
    }
    std::vector<std::string> row = Coordinates(file, all, points[i].at);
    row.insert(row.end(), {Sparkline(cycles, kSparkWidth), TimeText(least), TimeText(most)});
    table.AddRow(std::move(row));
  }
  std::string text =
      fmt::format("\nTime of {} over the cycles{}; each line has its own scale\n{}",
                  measure::PhaseNames()[measure::IndexOf(phase)],
                  times.bootstrap().size() > 1 ? ", medians over the repeats" : "", table.Text());
  if (points.size() > kMaxSparklines)
    text += fmt::format("  The first {} of {} points; --select chooses others.\n", kMaxSparklines,
                        points.size());
  return text;
}

/// The geometric mean over all other axes except that of detectors, with a letter for each
/// detector.
std::string OverAxis(const store::ResultFile& file,
                     const std::vector<statistics::MeasuredPoint>& points, std::size_t axis,
                     measure::Phase phase, statistics::CycleTimes& times) {
  const auto detectors = statistics::DetectorAxis(file);
  std::map<std::pair<std::size_t, std::size_t>, std::vector<double>> found;
  for (const statistics::MeasuredPoint& point : points)
    if (point.IsSound())
      found[{detectors ? point.at[*detectors] : 0, point.at[axis]}].push_back(
          times.FigureOf(point, phase).value);
  std::vector<terminal::PlotPoint> plotted;
  std::string legend;
  std::size_t last = kLetters.size();
  for (const auto& [key, values] : found) {
    const auto& [detector, value] = key;
    const double x = std::get<double>(file.axes()[axis].values[value]),
                 y = statistics::GeometricMean(values);
    if (!(x > 0) || !(y > 0)) continue;
    const char letter = detectors ? kLetters[detector % kLetters.size()] : 'o';
    if (detectors && detector != last)
      legend += fmt::format("{}{} {}", legend.empty() ? ": " : ", ", letter,
                            terminal::CoordinateText(file.axes()[*detectors], detector));
    last = detector;
    plotted.push_back({x, y, terminal::PlotMark::kOff, letter});
  }
  const std::string plot = terminal::LogPlot(
      plotted, file.axes()[axis].name,
      fmt::format("{} {} over {}, ns{}", times.StatisticHead(),
                  measure::PhaseNames()[measure::IndexOf(phase)], file.axes()[axis].name, legend));
  return plot.empty() ? plot : "\n" + plot + "  Logarithmic; geometric mean over all other axes.\n";
}

}  // namespace

std::string Sparkline(const std::vector<double>& values, std::size_t width) {
  const std::vector<double> bins = Bins(values, width);
  double least = statistics::kNone, most = statistics::kNone;
  for (const double value : bins) {
    least = std::fmin(least, value);
    most = std::fmax(most, value);
  }
  std::string text;
  for (const double value : bins) {
    const double share = most > least ? (value - least) / (most - least) : 0;
    text += std::isnan(value) ? std::string(" ")
                              : std::string(kBars[static_cast<std::size_t>(std::lround(
                                    share * static_cast<double>(std::size(kBars) - 1)))]);
  }
  return text;
}

std::string ShowPlots(const store::ResultFile& file,
                      const std::vector<statistics::MeasuredPoint>& points,
                      const std::vector<measure::Phase>& phases, statistics::CycleTimes& times) {
  if (!file.Has("duration") || points.empty()) return {};
  std::string text;
  for (const measure::Phase phase : phases.empty() ? std::vector{measure::Phase::kStep} : phases) {
    text += OverCycles(file, points, phase, times);
    for (std::size_t i = 0; i < file.axes().size(); ++i)
      if (!file.axes()[i].IsText() && file.axes()[i].values.size() >= kLeastOnAxis)
        text += OverAxis(file, points, i, phase, times);
  }
  return text;
}

}  // namespace cdb::report
