#include "runtime/report/conclusion_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "runtime/terminal/table.h"

namespace cdb::report {

std::string JoinWords(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
  return text;
}

std::string IntervalNote(const statistics::CycleTimes& times, const statistics::Estimate& estimate,
                         double scale) {
  const statistics::Interval interval = times.IntervalOf(estimate);
  if (std::isnan(interval.low) || std::isnan(interval.high)) return {};
  return fmt::format(" ({} {})", times.IntervalName(),
                     statistics::IntervalText({interval.low * scale, interval.high * scale}));
}

std::string TimeText(double ns) {
  const terminal::TimeUnit unit = terminal::TimeUnit::For(ns);
  return fmt::format("{} {}", terminal::ShortNumber(ns / unit.ns), unit.name);
}

std::string SettingText(const store::ResultFile& file, const std::vector<std::size_t>& axes,
                        const statistics::Point& at) {
  std::string text;
  for (std::size_t i = 0; i < axes.size(); ++i)
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", file.axes()[axes[i]].name,
                        terminal::CoordinateText(file.axes()[axes[i]], at[i]));
  return text;
}

std::vector<std::size_t> OtherAxes(const store::ResultFile& file, std::size_t axis) {
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < file.axes().size(); ++i)
    if (i != axis) others.push_back(i);
  return others;
}

std::string AxisWords(const plan::Axis& axis) {
  if (axis.parameter == "objects.quantity" && axis.name == "quantity")
    return "the number of objects";
  std::string words = axis.name;
  std::ranges::replace(words, '_', ' ');
  return words;
}

}  // namespace cdb::report
