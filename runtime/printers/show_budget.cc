// Which configurations stay within a time per cycle, for `cdb show`.

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "runtime/figures/coverage.h"
#include "runtime/figures/requirements.h"
#include "runtime/figures/times.h"
#include "runtime/printers/show.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

using figures::BudgetFigures;

constexpr std::string_view kAtLeastNote =
    "at least: on a noisy machine, which only adds time, the 99th percentile of the fastest repeat "
    "of each cycle (the median if there is one repeat). Only above the budget is the answer no.";

Table RowsOf(const figures::Model& model, const std::vector<BudgetFigures>& figures,
             const figures::Budget& budget) {
  const figures::Rows rows = figures::MatchRows(model.points(), figures::AllAxes(model.file()));
  const terminal::TimeUnit unit = terminal::TimeUnit::For(budget.ns);
  const bool has_intervals = model.times().HasIntervals();
  RowTable table(model.file(), rows);
  if (budget.frame_s) table.AddColumn(fmt::format("budget, {}", unit.name));
  for (const char* head : {"above", "of cycles"}) table.AddColumn(head);
  table.AddColumn(fmt::format("p99, {}", unit.name));
  if (has_intervals) table.AddColumn(fmt::format("its {}", model.times().IntervalName()));
  const bool has_noise =
      std::ranges::any_of(figures, [](const BudgetFigures& of) { return of.at_least.has_value(); });
  if (has_noise) table.AddColumn(fmt::format("at least, {}", unit.name));
  table.AddColumn(fmt::format("worst, {}", unit.name));
  table.AddColumn("fits");
  for (const figures::Row& row : rows.rows) {
    const BudgetFigures& of =
        *std::ranges::find(figures, row.points.front(), &BudgetFigures::point);
    std::vector<std::string> cells = {fmt::format("{}", of.above), fmt::format("{}", of.cycles),
                                      terminal::ShortNumber(of.p99.value / unit.ns)};
    if (budget.frame_s) cells.insert(cells.begin(), terminal::ShortNumber(of.budget_ns / unit.ns));
    if (of.interval)
      cells.push_back(
          figures::IntervalText({of.interval->low / unit.ns, of.interval->high / unit.ns}));
    if (has_noise)
      cells.push_back(of.at_least ? terminal::ShortNumber(*of.at_least / unit.ns) : "-");
    cells.push_back(terminal::ShortNumber(of.worst / unit.ns));
    cells.push_back(
        fmt::format("{}{}", figures::FitName(of.fit), of.MayBeNoise() ? ": noisy" : ""));
    table.AddRow(row, cells, figures::UnsoundText(model.file(), row));
  }
  return table.Take();
}

}  // namespace

Section BudgetSection(const figures::Model& model, const figures::Budget& budget,
                      protocol::Phase phase, bool has_answer) {
  const std::vector<BudgetFigures> figures = figures::BudgetOf(model, budget, phase);
  const bool has_intervals = model.times().HasIntervals();
  Section section = {
      .title = budget.frame_s
                   ? fmt::format("Cycles whose {} takes more than its part of {}",
                                 figures::PhaseName(phase), budget.Text())
                   : fmt::format("Cycles whose {} takes more than {}", figures::PhaseName(phase),
                                 figures::BudgetText(budget.ns)),
      .table = RowsOf(model, figures, budget)};
  if (has_answer) section.lines.push_back(figures::BudgetAnswer(model, figures));
  section.notes.push_back(fmt::format(
      "fits: the 99th percentile over the cycles{} is within the budget. worst: the "
      "longest cycle of any repeat, disturbances included.",
      has_intervals ? fmt::format(", with its {},", model.times().IntervalName()) : std::string()));
  if (std::ranges::any_of(figures, [](const BudgetFigures& of) { return of.at_least.has_value(); }))
    section.notes.emplace_back(kAtLeastNote);
  if (!has_intervals)
    section.notes.emplace_back("One repeat: there is no interval; `repeats 5` gives one.");
  return section;
}

Printed ShowBudget(const results::ResultFile& file, const ShowBudgetOptions& options) {
  const figures::Model model(
      file, {.only_sound = options.only_sound, .statistic = figures::CycleStatistic::kP99});
  if (!model.HasTimes())
    throw files::StoreError("the file has no times; `record timing` adds them");
  return {TextOf({BudgetSection(model, options.budget, options.phase, true)}, options.format),
          model.bad_count(), figures::CountNotMet(model.requirements())};
}

}  // namespace cdb::printers
