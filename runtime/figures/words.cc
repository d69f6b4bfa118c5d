#include "runtime/figures/words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "runtime/terminal/table.h"

namespace cdb::figures {

std::string JoinWords(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
  return text;
}

std::string IntervalNote(const CycleTimes& times, const Estimate& estimate, double scale) {
  const Interval interval = times.IntervalOf(estimate);
  if (std::isnan(interval.low) || std::isnan(interval.high)) return {};
  return fmt::format(" ({} {})", times.IntervalName(),
                     IntervalText({interval.low * scale, interval.high * scale}));
}

std::string TimeText(double ns) {
  const terminal::TimeUnit unit = terminal::TimeUnit::For(ns);
  return fmt::format("{} {}", terminal::ShortNumber(ns / unit.ns), unit.name);
}

std::vector<std::size_t> OtherAxes(const store::ResultFile& file, std::size_t axis) {
  std::vector<std::size_t> others = AllAxes(file);
  std::erase(others, axis);
  return others;
}

std::string AxisWords(const plan::Axis& axis) {
  if (axis.parameter == "objects.quantity" && axis.name == "quantity")
    return "the number of objects";
  std::string words = axis.name;
  std::ranges::replace(words, '_', ' ');
  return words;
}

}  // namespace cdb::figures
