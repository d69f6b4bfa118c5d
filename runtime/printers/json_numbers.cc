#include "runtime/printers/json_numbers.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <utility>

namespace cdb::printers {
namespace {

/// Above this, not every whole number is representable as a double.
constexpr double kMaxWhole = 9007199254740992.0;

double Rounded(double value, int digits) {
  char text[64];
  const auto end =
      std::to_chars(text, text + sizeof(text), value, std::chars_format::scientific, digits - 1)
          .ptr;
  double rounded = value;
  std::from_chars(text, end, rounded);
  return rounded;
}

}  // namespace

Json JsonNumber(double value, int digits) {
  if (!std::isfinite(value)) return nullptr;
  const double rounded = Rounded(value, digits);
  if (rounded == std::trunc(rounded) && std::fabs(rounded) < kMaxWhole)
    return static_cast<std::int64_t>(rounded);
  return rounded;
}

Json JsonNumbers(const std::vector<double>& values, int digits) {
  return JsonColumn(values.size(), [&](std::size_t i) { return JsonNumber(values[i], digits); });
}

Json FoldColumns(Json columns) {
  if (columns.is_array()) {
    for (const Json& value : columns)
      if (value != columns[0]) return columns;
    return columns.empty() ? columns : Json{{"constant", columns[0]}};
  }
  if (columns.is_object())
    for (auto& [key, column] : columns.items()) column = FoldColumns(std::move(column));
  return columns;
}

}  // namespace cdb::printers
