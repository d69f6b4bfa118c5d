#include "runtime/printers/show.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/figures/points.h"
#include "runtime/printers/document.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

using plan::Axis;

/// The graded axis; none if no axis has numbers.
std::optional<std::size_t> OwnAxis(const std::vector<Axis>& axes) {
  for (std::size_t i = axes.size(); i-- > 0;)
    if (!axes[i].IsText()) return i;
  return std::nullopt;
}

std::string Range(const Axis& axis, std::size_t begin, std::size_t end) {
  const auto text = [&](std::size_t i) {
    return fmt::format("{:.4g}", std::get<double>(axis.values[i]));
  };
  return end - begin == 1 ? text(begin) : fmt::format("{} .. {}", text(begin), text(end - 1));
}

std::string AlongAxis(const results::ResultFile& file, figures::Point at, std::size_t own) {
  const Axis& axis = file.axes()[own];
  std::string line, before;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= axis.values.size(); ++i) {
    std::string here;
    if (i < axis.values.size()) {
      at[own] = i;
      here = figures::WorstEnding(file, at).Word();
      if (i == 0) before = here;
    }
    if (here == before) continue;
    line += fmt::format("{}{} {}", line.empty() ? "" : " | ", before, Range(axis, begin, i));
    before = std::move(here);
    begin = i;
  }
  return line;
}

}  // namespace

std::string StabilityMap(const results::ResultFile& file) {
  const auto& axes = file.axes();
  const auto own = OwnAxis(axes);
  Section section = {.title = file.title()};
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (i != own) section.table.AddColumn(axes[i].name, !axes[i].IsText());
  section.table.AddColumn(
      own ? axes[*own].name + (axes[*own].unit.empty() ? "" : ", " + axes[*own].unit) : "verdict",
      false);
  for (const figures::Point& at : figures::AllPoints(file)) {
    if (own && at[*own] != 0) continue;
    std::vector<std::string> row;
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (i != own) row.push_back(terminal::CoordinateText(axes[i], at[i]));
    row.push_back(own ? AlongAxis(file, at, *own) : figures::WorstEnding(file, at).Word());
    section.table.rows.push_back(std::move(row));
  }
  return TextOf({section}, Format::kTerminal);
}

}  // namespace cdb::printers
