#include "compiler/plan/coordinates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

namespace cdb::plan {
namespace {

constexpr int kWrittenDigits = 6;
constexpr int kLeastDigits = 4;
constexpr int kAllDigits = 17;
constexpr double kNoNeighbour = std::numeric_limits<double>::infinity();

int SignificantDigits(std::string_view text) {
  int digits = 0;
  for (const char c : text.substr(0, text.find('e')))
    digits += c >= '0' && c <= '9' && (digits > 0 || c != '0') ? 1 : 0;
  return digits;
}

/// The nearest values below and above `value` on the axis; infinite if there are none.
struct Neighbours {
  double below = -kNoNeighbour, above = kNoNeighbour;
};

Neighbours NeighboursOf(const Axis& axis, double value) {
  Neighbours neighbours;
  for (const Coordinate& coordinate : axis.values) {
    const auto* number = std::get_if<double>(&coordinate);
    if (number == nullptr) continue;
    const double other = *number;
    if (other < value && other > neighbours.below) neighbours.below = other;
    if (other > value && other < neighbours.above) neighbours.above = other;
  }
  return neighbours;
}

std::string Rounded(double value, int digits) { return fmt::format("{:.{}g}", value, digits); }

// Rounding is monotonic, so a label that differs from those of both neighbours differs from all
// others. A value with a shorter label than `value` would share it at its own number of digits.
std::string Label(double value, const Neighbours& neighbours) {
  const std::string exact = schema::FormatReal(value);
  if (value == std::floor(value) || SignificantDigits(exact) <= kWrittenDigits) return exact;
  // 12345.678 becomes 12346, not 1.235e+04.
  const double size = std::fabs(value);
  const int before_point = size >= 1 && size < 1e12 ? static_cast<int>(std::log10(size)) + 1 : 0;
  for (int digits = std::max(kLeastDigits, before_point); digits < kAllDigits; ++digits) {
    const std::string text = Rounded(value, digits);
    if (text != Rounded(neighbours.below, digits) && text != Rounded(neighbours.above, digits))
      return text;
  }
  return exact;
}

}  // namespace

std::string CoordinateLabel(const Axis& axis, std::size_t index) {
  const auto* number = std::get_if<double>(&axis.values[index]);
  if (number == nullptr) return std::get<std::string>(axis.values[index]);
  return Label(*number, NeighboursOf(axis, *number));
}

std::vector<std::string> CoordinateLabels(const Axis& axis) {
  std::vector<double> sorted;
  for (const Coordinate& coordinate : axis.values)
    if (const auto* number = std::get_if<double>(&coordinate)) sorted.push_back(*number);
  std::ranges::sort(sorted);
  std::vector<std::string> labels;
  for (const Coordinate& coordinate : axis.values) {
    const auto* number = std::get_if<double>(&coordinate);
    if (number == nullptr) {
      labels.push_back(std::get<std::string>(coordinate));
      continue;
    }
    Neighbours neighbours;
    const auto low = std::lower_bound(sorted.begin(), sorted.end(), *number);
    const auto high = std::upper_bound(low, sorted.end(), *number);
    if (low != sorted.begin()) neighbours.below = *(low - 1);
    if (high != sorted.end()) neighbours.above = *high;
    labels.push_back(Label(*number, neighbours));
  }
  return labels;
}

std::string ShortReal(double value) { return Label(value, {}); }

}  // namespace cdb::plan
