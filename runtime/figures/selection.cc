#include "runtime/figures/selection.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string_view>

#include "compiler/plan/coordinates.h"
#include "runtime/figures/points.h"

namespace cdb::figures {
namespace {

/// Relative tolerances: of two spellings of one value, and of a value with the digits of a table.
constexpr double kSame = 1e-9, kShown = 1e-4;

/// Nullopt if the whole text is not a number.
std::optional<double> NumberIn(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::set<std::size_t> FindNumbers(const plan::Axis& axis, const std::string& text) {
  std::set<std::size_t> found;
  const auto dots = text.find("..");
  const auto from = NumberIn(std::string_view(text).substr(0, dots));
  const auto to = dots == text.npos ? from : NumberIn(std::string_view(text).substr(dots + 2));
  if (!from || !to) return found;
  std::optional<std::size_t> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < axis.values.size(); ++i) {
    const double value = std::get<double>(axis.values[i]), slack = kSame * std::fabs(value);
    if (value >= *from - slack && value <= *to + slack) found.insert(i);
    const double distance = std::fabs(value - *from);
    if (distance > kShown * std::fabs(value) || distance >= least) continue;
    least = distance;
    nearest = i;
  }
  if (found.empty() && dots == text.npos && nearest) found.insert(*nearest);
  return found;
}

std::set<std::size_t> FindValue(const plan::Axis& axis, const std::vector<std::string>& labels,
                                const std::string& text) {
  const auto found = std::ranges::find(labels, text);
  if (found != labels.end()) return {static_cast<std::size_t>(found - labels.begin())};
  return axis.IsText() ? std::set<std::size_t>() : FindNumbers(axis, text);
}

}  // namespace

AxisSelection ParseSelection(const std::string& word) {
  const std::size_t equals = word.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == word.size())
    throw files::StoreError(
        fmt::format("'{}' selects nothing; write AXIS=VALUE, such as detector=dbvt", word));
  return {word.substr(0, equals), word.substr(equals + 1)};
}

NamedValues FindValues(const plan::Axis& axis, const std::string& text) {
  const std::vector<std::string> labels = plan::CoordinateLabels(axis);
  // A label may contain a comma.
  std::set<std::size_t> found = FindValue(axis, labels, text);
  NamedValues values;
  for (std::size_t begin = 0; found.empty() && begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::set<std::size_t> here = FindValue(axis, labels, part);
    values.indices.insert(values.indices.end(), here.begin(), here.end());
    if (here.empty()) values.unknown.push_back(part);
    begin = end + 1;
  }
  found.insert(values.indices.begin(), values.indices.end());
  values.indices.assign(found.begin(), found.end());
  return values;
}

std::string ValuesText(const plan::Axis& axis, const std::vector<std::size_t>& indices) {
  const std::vector<std::string> labels = plan::CoordinateLabels(axis);
  std::vector<std::string> values;
  for (const std::size_t i : indices) values.push_back(labels[i]);
  return fmt::format("{}", fmt::join(values, ", "));
}

std::string ValuesText(const plan::Axis& axis) {
  return fmt::format("{}", fmt::join(plan::CoordinateLabels(axis), ", "));
}

void SelectPart(results::ResultFile& file, const std::vector<std::string>& selections) {
  std::set<std::string> seen;
  for (const std::string& word : selections) {
    const auto [name, text] = ParseSelection(word);
    const std::size_t at = FindAxis(file, name);
    if (!seen.insert(name).second)
      throw files::StoreError(fmt::format(
          "--select names the axis '{}' twice: list its values in one, as {}=A,B", name, name));
    const plan::Axis& axis = file.axes()[at];
    const NamedValues values = FindValues(axis, text);
    if (!values.unknown.empty())
      throw files::StoreError(fmt::format("the axis '{}' has no value {}; it has {}", name,
                                          values.unknown[0].empty() ? "''" : values.unknown[0],
                                          ValuesText(axis)));
    file.Select(at, values.indices);
  }
}

}  // namespace cdb::figures
