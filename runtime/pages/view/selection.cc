#include "runtime/pages/view/selection.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <optional>

#include "runtime/terminal/table.h"

namespace cdb::view {
namespace {

using files::StoreError;

/// Nullopt if the whole text is not a number.
std::optional<double> NumberOf(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::size_t OneOf(const plan::Axis& axis, const std::string& text) {
  const figures::NamedValues values = figures::FindValues(axis, text);
  if (values.indices.size() == 1 && values.unknown.empty()) return values.indices[0];
  throw StoreError(fmt::format("{}={}: {}the axis has the values {}", axis.name, text,
                               values.indices.empty() ? "" : "there are several; ",
                               figures::ValuesText(axis)));
}

std::uint64_t RepeatOf(const std::string& value, std::uint64_t repeats) {
  const auto number = NumberOf(value);
  if (!number || !(*number >= 0) || *number != std::floor(*number) ||
      *number >= static_cast<double>(repeats))
    throw StoreError(fmt::format("rep={}: the repeats are 0 to {}", value, repeats - 1));
  return static_cast<std::uint64_t>(*number);
}

}  // namespace

void Select(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
            const std::vector<figures::AxisSelection>& selections,
            results::ResultFile::Cell& cell) {
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
      cell.at[i] = OneOf(axes[i], value);
      is_found = true;
    }
    if (is_found) continue;
    names.emplace_back("rep");
    throw StoreError(
        fmt::format("there is no axis '{}'; there are {}", name, fmt::join(names, ", ")));
  }
}

std::string CellName(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
                     const results::ResultFile::Cell& cell) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < axes.size(); ++i)
    words.push_back(
        fmt::format("{} {}", axes[i].name, terminal::CoordinateText(axes[i], cell.at[i])));
  if (repeats > 1) words.push_back(fmt::format("rep {}", cell.rep));
  return fmt::format("{}", fmt::join(words, ", "));
}

}  // namespace cdb::view
