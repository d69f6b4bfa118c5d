#include "runtime/report/selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include "runtime/report/cells.h"
#include "runtime/report/table.h"

namespace cdb::report {
namespace {

/// Of two numbers that are the same value, written with fewer digits.
constexpr double kSame = 1e-9;

std::optional<double> NumberIn(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string ValuesOf(const plan::Axis& axis) {
  std::string values;
  for (std::size_t i = 0; i < axis.values.size(); ++i)
    values += (i == 0 ? "" : ", ") + CoordinateText(axis, i);
  return values;
}

class ValueSelection {
 public:
  explicit ValueSelection(const plan::Axis& axis) : axis_(axis) {}

  /// Throws StoreError for text that is no value of the axis.
  void Add(const std::string& text) {
    bool is_found = false;
    for (std::size_t i = 0; i < axis_.values.size(); ++i) {
      if (!Matches(text, i)) continue;
      kept_.insert(i);
      is_found = true;
    }
    if (!is_found)
      throw store::StoreError(fmt::format("the axis '{}' has no value {}; it has {}", axis_.name,
                                          text.empty() ? "''" : text, ValuesOf(axis_)));
  }

  std::vector<std::size_t> kept() const { return {kept_.begin(), kept_.end()}; }

 private:
  bool Matches(const std::string& text, std::size_t i) const {
    if (CoordinateText(axis_, i) == text) return true;
    if (axis_.IsText()) return false;
    const double value = std::get<double>(axis_.values[i]);
    const auto dots = text.find("..");
    if (dots != std::string::npos) {
      const auto from = NumberIn(text.substr(0, dots)), to = NumberIn(text.substr(dots + 2));
      return from && to && value >= *from - Slack(*from) && value <= *to + Slack(*to);
    }
    const auto number = NumberIn(text);
    return number && std::fabs(value - *number) <= Slack(value);
  }
  static double Slack(double value) { return kSame * std::fabs(value); }

  const plan::Axis& axis_;
  std::set<std::size_t> kept_;
};

}  // namespace

void SelectPart(store::ResultFile& file, const std::vector<std::string>& selections) {
  std::set<std::string> seen;
  for (const std::string& selection : selections) {
    const auto equals = selection.find('=');
    if (equals == std::string::npos)
      throw store::StoreError(
          fmt::format("--select takes AXIS=VALUE, AXIS=A,B or AXIS=A..B, not '{}'", selection));
    const std::string name = selection.substr(0, equals);
    const std::size_t axis = FindAxis(file, name);
    if (!seen.insert(name).second)
      throw store::StoreError(fmt::format(
          "--select names the axis '{}' twice: list its values in one, as {}=A,B", name, name));
    ValueSelection values(file.axes()[axis]);
    std::string rest = selection.substr(equals + 1);
    for (std::size_t comma = 0; comma != std::string::npos;) {
      comma = rest.find(',');
      values.Add(rest.substr(0, comma));
      if (comma != std::string::npos) rest.erase(0, comma + 1);
    }
    file.Select(axis, values.kept());
  }
}

}  // namespace cdb::report
