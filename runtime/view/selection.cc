#include "runtime/view/selection.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "runtime/report/table.h"

namespace cdb::view {
namespace {

using store::StoreError;

/// Nullopt where the text is no number from its first to its last character.
std::optional<double> NumberOf(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string ValuesText(const plan::Axis& axis) {
  std::vector<std::string> values;
  for (std::size_t i = 0; i < axis.values.size(); ++i)
    values.push_back(report::CoordinateText(axis, i));
  return fmt::format("{}", fmt::join(values, ", "));
}

std::uint64_t RepeatOf(const std::string& value, std::uint64_t repeats) {
  const auto number = NumberOf(value);
  if (!number || !(*number >= 0) || *number != std::floor(*number) ||
      *number >= static_cast<double>(repeats))
    throw StoreError(fmt::format("rep={}: the repeats are 0 to {}", value, repeats - 1));
  return static_cast<std::uint64_t>(*number);
}

}  // namespace

Selection ParseSelection(const std::string& word) {
  const std::size_t equals = word.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == word.size())
    throw StoreError(
        fmt::format("'{}' selects nothing; write AXIS=VALUE, such as detector=dbvt", word));
  return {word.substr(0, equals), word.substr(equals + 1)};
}

std::size_t FindCoordinate(const plan::Axis& axis, const std::string& value) {
  std::optional<std::size_t> best;
  double least = std::numeric_limits<double>::infinity();
  const auto number = NumberOf(value);
  for (std::size_t i = 0; i < axis.values.size(); ++i) {
    const auto* coordinate = std::get_if<double>(&axis.values[i]);
    if (coordinate == nullptr) {
      if (std::get<std::string>(axis.values[i]) == value) return i;
    } else if (number) {
      const double difference = std::abs(*coordinate - *number);
      if (difference > 1e-4 * std::abs(*coordinate) || difference >= least) continue;
      least = difference;
      best = i;
    }
  }
  if (best) return *best;
  throw StoreError(
      fmt::format("{}={}: the axis has the values {}", axis.name, value, ValuesText(axis)));
}

void Select(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
            const std::vector<Selection>& selections, store::ResultFile::Cell& cell) {
  for (const auto& [name, value] : selections) {
    if (name == "rep") {
      cell.rep = RepeatOf(value, repeats);
      continue;
    }
    std::vector<std::string> names;
    bool is_found = false;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      names.push_back(axes[i].name);
      if (axes[i].name != name) continue;
      cell.at[i] = FindCoordinate(axes[i], value);
      is_found = true;
    }
    if (is_found) continue;
    names.emplace_back("rep");
    throw StoreError(
        fmt::format("there is no axis '{}'; there are {}", name, fmt::join(names, ", ")));
  }
}

std::string CellName(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
                     const store::ResultFile::Cell& cell) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < axes.size(); ++i)
    words.push_back(
        fmt::format("{} {}", axes[i].name, report::CoordinateText(axes[i], cell.at[i])));
  if (repeats > 1) words.push_back(fmt::format("rep {}", cell.rep));
  return fmt::format("{}", fmt::join(words, ", "));
}

}  // namespace cdb::view
