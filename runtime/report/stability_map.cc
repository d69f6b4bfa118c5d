#include "runtime/report/stability_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/report/table.h"

namespace cdb::report {
namespace {

using plan::Axis;

/// Of a point's repeats. A run without a verdict says how its process ended.
std::string WorstAt(const store::ResultFile& file, const std::vector<std::size_t>& at) {
  std::optional<measure::Verdict> worst;
  for (std::uint64_t rep = 0; rep < file.repeats(); ++rep) {
    const store::Status status = file.ReadStatus({at, rep});
    const measure::Verdict verdict = file.ReadJudgement({at, rep}).verdict;
    if (verdict == measure::Verdict::kUnknown && status != store::Status::kDone)
      return std::string(store::StatusName(status));
    if (!worst || verdict > *worst) worst = verdict;
  }
  return std::string(measure::VerdictName(*worst));
}

/// The graded axis; none where no axis has numbers.
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
      here = WorstAt(file, at);
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
  Table table;
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (i != own) table.AddColumn(axes[i].name, !axes[i].IsText());
  table.AddColumn(
      own ? axes[*own].name + (axes[*own].unit.empty() ? "" : ", " + axes[*own].unit) : "verdict",
      false);
  std::vector<std::size_t> at(axes.size(), 0);
  for (;;) {
    std::vector<std::string> row;
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (i != own) row.push_back(CoordinateText(axes[i], at[i]));
    row.push_back(own ? AlongAxis(file, at, *own) : WorstAt(file, at));
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
