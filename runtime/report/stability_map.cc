#include "runtime/report/stability_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/statistics/cells.h"
#include "runtime/terminal/table.h"

namespace cdb::report {
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

std::string AlongAxis(const store::ResultFile& file, std::vector<std::size_t> at, std::size_t own) {
  const Axis& axis = file.axes()[own];
  std::string line, before;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= axis.values.size(); ++i) {
    std::string here;
    if (i < axis.values.size()) {
      at[own] = i;
      here = statistics::WorstVerdict(file, at).word;
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

std::string StabilityMap(const store::ResultFile& file) {
  const auto& axes = file.axes();
  const auto own = OwnAxis(axes);
  std::string text = fmt::format("{}\n", file.title());
  terminal::Table table;
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (i != own) table.AddColumn(axes[i].name, !axes[i].IsText());
  table.AddColumn(
      own ? axes[*own].name + (axes[*own].unit.empty() ? "" : ", " + axes[*own].unit) : "verdict",
      false);
  std::vector<std::size_t> at(axes.size(), 0);
  for (;;) {
    std::vector<std::string> row;
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (i != own) row.push_back(terminal::CoordinateText(axes[i], at[i]));
    row.push_back(own ? AlongAxis(file, at, *own) : statistics::WorstVerdict(file, at).word);
    table.AddRow(std::move(row));
    std::size_t i = axes.size();
    const auto advance = [&] {
      while (i-- > 0) {
        if (i == own) continue;
        if (++at[i] < axes[i].values.size()) return true;
        at[i] = 0;
      }
      return false;
    };
    if (!advance()) return text + table.Text();
  }
}

}  // namespace cdb::report
