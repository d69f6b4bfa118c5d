// Which configurations stay within a time per cycle, for `cdb show`.

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "runtime/figures/budget.h"
#include "runtime/figures/coverage.h"
#include "runtime/figures/times.h"
#include "runtime/printers/show.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

using figures::BudgetFigures;

Table RowsOf(const figures::Model& model, const std::vector<BudgetFigures>& figures,
             double budget_ns) {
  const figures::Rows rows = figures::MatchRows(model.points(), figures::AllAxes(model.file()));
  const terminal::TimeUnit unit = terminal::TimeUnit::For(budget_ns);
  const bool has_intervals = model.times().HasIntervals();
  RowTable table(model.file(), rows);
  for (const char* head : {"above", "of cycles"}) table.AddColumn(head);
  table.AddColumn(fmt::format("p99, {}", unit.name));
  if (has_intervals) table.AddColumn(fmt::format("its {}", model.times().IntervalName()));
  table.AddColumn(fmt::format("worst, {}", unit.name));
  table.AddColumn("fits");
  for (const figures::Row& row : rows.rows) {
    const BudgetFigures& of =
        *std::ranges::find(figures, row.points.front(), &BudgetFigures::point);
    std::vector<std::string> cells = {fmt::format("{}", of.above), fmt::format("{}", of.cycles),
                                      terminal::ShortNumber(of.p99.value / unit.ns)};
    if (of.interval)
      cells.push_back(
          figures::IntervalText({of.interval->low / unit.ns, of.interval->high / unit.ns}));
    cells.push_back(terminal::ShortNumber(of.worst / unit.ns));
    cells.emplace_back(figures::FitName(of.fit));
    table.AddRow(row, cells, figures::UnsoundText(model.file(), row));
  }
  return table.Take();
}

}  // namespace

Section BudgetSection(const figures::Model& model, double budget_ns, protocol::Phase phase) {
  const std::vector<BudgetFigures> figures = figures::BudgetOf(model, budget_ns, phase);
  const bool has_intervals = model.times().HasIntervals();
  Section section = {.title = fmt::format("Cycles whose {} takes more than {}",
                                          figures::PhaseName(phase), figures::TimeText(budget_ns)),
                     .lines = {figures::BudgetAnswer(model, figures)},
                     .table = RowsOf(model, figures, budget_ns)};
  section.notes.push_back(fmt::format(
      "fits: the 99th percentile over the cycles{} is within the budget. worst: the "
      "longest cycle of any repeat, disturbances included.",
      has_intervals ? fmt::format(", with its {},", model.times().IntervalName()) : std::string()));
  if (!has_intervals)
    section.notes.emplace_back("One repeat: there is no interval; `repeats 5` gives one.");
  return section;
}

Printed ShowBudget(const results::ResultFile& file, const ShowBudgetOptions& options) {
  const figures::Model model(
      file, {.only_sound = options.only_sound, .statistic = figures::CycleStatistic::kP99});
  if (!model.HasTimes())
    throw files::StoreError("the file has no times; `record timing` adds them");
  return {TextOf({BudgetSection(model, options.budget_ns, options.phase)}, options.format),
          model.bad_count()};
}

}  // namespace cdb::printers
