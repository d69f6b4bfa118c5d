#include "runtime/terminal/log_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

#include "runtime/terminal/table.h"

namespace cdb::terminal {
namespace {

constexpr std::size_t kPlotWidth = 60, kPlotHeight = 14;

struct MarkInfo {
  PlotMark mark;
  char character;
  std::string_view name;  ///< in the legend; empty for the rest
};
constexpr MarkInfo kMarks[] = {{PlotMark::kVoid, 'x', "void"},
                               {PlotMark::kOff, 'o', ""},
                               {PlotMark::kTie, '=', "tie"},
                               {PlotMark::kFront, '*', "front"}};

}  // namespace

std::string LogPlot(const std::vector<PlotPoint>& points, const std::string& x_name,
                    const std::string& y_name) {
  if (points.size() < 2) return {};
  const auto range = [&points](auto of) {
    double low = of(points[0]), high = low;
    for (const PlotPoint& point : points) {
      low = std::min(low, of(point));
      high = std::max(high, of(point));
    }
    return std::pair(low, high);
  };
  const auto [left, right] = range([](const PlotPoint& point) { return point.x; });
  const auto [bottom, top] = range([](const PlotPoint& point) { return point.y; });
  const auto place = [](double value, double low, double high, std::size_t extent) {
    // The ratio of the ends may overflow a double.
    const double share =
        low == high ? 0.5 : (std::log(value) - std::log(low)) / (std::log(high) - std::log(low));
    const double shown = std::isfinite(share) ? std::clamp(share, 0.0, 1.0) : 0.0;
    return static_cast<std::size_t>(std::lround(shown * static_cast<double>(extent - 1)));
  };
  std::vector<std::string> lines(kPlotHeight, std::string(kPlotWidth, ' '));
  std::string used;
  for (const auto& [mark, character, name] : kMarks) {
    bool is_used = false;
    for (const PlotPoint& point : points) {
      if (point.mark != mark) continue;
      is_used = true;
      lines[kPlotHeight - 1 - place(point.y, bottom, top, kPlotHeight)]
           [place(point.x, left, right, kPlotWidth)] = point.letter != 0 ? point.letter : character;
    }
    if (is_used && !name.empty()) used = fmt::format(", {} {}", character, name) + used;
  }
  std::string text = y_name + used + '\n';
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::string label;
    if (i == 0) label = ShortNumber(top);
    if (i + 1 == lines.size()) label = ShortNumber(bottom);
    const std::size_t end = lines[i].find_last_not_of(' ') + 1;
    text += fmt::format("{:>9} |{}\n", label, lines[i].substr(0, end));
  }
  const std::string from = ShortNumber(left), to = ShortNumber(right);
  text += fmt::format("{:>9} +{}\n", "", std::string(kPlotWidth, '-'));
  const std::size_t room = kPlotWidth - std::min(kPlotWidth, from.size() + to.size());
  text += fmt::format("{:>11}{}{:^{}}{}\n", "", from, x_name, room, to);
  return text;
}

}  // namespace cdb::terminal
