// Which configurations stay within a time per cycle, for `cdb show --budget`.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "runtime/figures/times.h"
#include "runtime/printers/show.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

using figures::MeasuredPoint;

/// Whether the 99th percentile is within the budget.
enum class Fit { kYes, kNo, kUnclear };

class BudgetTable {
 public:
  BudgetTable(const figures::Model& model, double budget_ns, protocol::Phase phase)
      : model_(model), budget_ns_(budget_ns), phase_(phase) {}

  Document Made() const {
    Section section = {
        .title = fmt::format("Cycles whose {} takes more than {}", figures::PhaseName(phase_),
                             figures::TimeText(budget_ns_)),
        .lines = Answers(),
        .table = Rows()};
    section.notes.push_back(
        fmt::format("fits: the 99th percentile over the cycles{} is within the budget. worst: the "
                    "longest cycle of any repeat, disturbances included.",
                    HasIntervals() ? fmt::format(", with its {},", model_.times().IntervalName())
                                   : std::string()));
    if (!HasIntervals())
      section.notes.emplace_back("One repeat: there is no interval; `repeats 5` gives one.");
    return {std::move(section)};
  }

 private:
  bool HasIntervals() const { return model_.times().HasIntervals(); }

  Fit FitOf(const MeasuredPoint& point) const {
    const figures::Estimate& p99 = model_.TimeOf(point, phase_);
    const figures::Interval range =
        HasIntervals() ? model_.times().IntervalOf(p99) : figures::Interval{p99.value, p99.value};
    return range.high <= budget_ns_ ? Fit::kYes : range.low > budget_ns_ ? Fit::kNo : Fit::kUnclear;
  }

  /// How many fit, and the largest of those along an axis that changes the number of objects.
  std::vector<std::string> Answers() const {
    std::vector<std::string> fitting, unclear;
    std::size_t sound = 0;
    for (const MeasuredPoint& point : model_.points()) {
      if (!point.IsSound()) continue;
      ++sound;
      const Fit fit = FitOf(point);
      if (fit == Fit::kNo) continue;
      (fit == Fit::kYes ? fitting : unclear)
          .push_back(figures::PlaceText(model_.file(), figures::AllAxes(model_.file()), point.at));
    }
    constexpr std::size_t kMostNamed = 6;
    const auto named = [&](const std::vector<std::string>& places) {
      const std::size_t count = std::min(places.size(), kMostNamed);
      return fmt::format(
          "{}{}",
          fmt::join(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(count), "; "),
          places.size() > kMostNamed ? "; …" : "");
    };
    std::vector<std::string> lines = {fmt::format("{} of {} sound configurations fit{}{}.",
                                                  fitting.size(), sound,
                                                  fitting.empty() ? "" : ": ", named(fitting))};
    if (!unclear.empty())
      lines.push_back(fmt::format("{} cannot be told: {}.", unclear.size(), named(unclear)));
    return lines;
  }

  Table Rows() const {
    const figures::Rows rows = figures::MatchRows(model_.points(), figures::AllAxes(model_.file()));
    const terminal::TimeUnit unit = terminal::TimeUnit::For(budget_ns_);
    RowTable table(model_.file(), rows);
    for (const char* head : {"above", "of cycles"}) table.AddColumn(head);
    table.AddColumn(fmt::format("p99, {}", unit.name));
    if (HasIntervals()) table.AddColumn(fmt::format("its {}", model_.times().IntervalName()));
    table.AddColumn(fmt::format("worst, {}", unit.name));
    table.AddColumn("fits");
    for (const figures::Row& row : rows.rows) {
      const MeasuredPoint& point = *row.points.front();
      const std::vector<double>& cycles = model_.times().Of(point, phase_).cycles;
      const auto above =
          std::ranges::count_if(cycles, [this](double ns) { return ns > budget_ns_; });
      const figures::Estimate& p99 = model_.TimeOf(point, phase_);
      std::vector<std::string> figures = {fmt::format("{}", above),
                                          fmt::format("{}", cycles.size()),
                                          terminal::ShortNumber(p99.value / unit.ns)};
      if (HasIntervals()) {
        const figures::Interval range = model_.times().IntervalOf(p99);
        figures.push_back(figures::IntervalText({range.low / unit.ns, range.high / unit.ns}));
      }
      figures.push_back(terminal::ShortNumber(WorstOf(point) / unit.ns));
      const Fit fit = FitOf(point);
      figures.emplace_back(fit == Fit::kYes ? "yes" : fit == Fit::kNo ? "no" : "cannot tell");
      table.AddRow(row, figures);
    }
    return table.Take();
  }

  /// The longest cycle of any repeat, ns.
  double WorstOf(const MeasuredPoint& point) const {
    double worst = figures::kNone;
    for (const figures::Cell& cell : point.cells)
      for (const double ns : model_.file().ReadDuration(phase_, cell)) worst = std::fmax(worst, ns);
    return worst;
  }

  const figures::Model& model_;
  double budget_ns_;
  protocol::Phase phase_;
};

}  // namespace

Printed ShowBudget(const results::ResultFile& file, const ShowBudgetOptions& options) {
  const figures::Model model(
      file, {.only_sound = options.only_sound, .statistic = figures::CycleStatistic::kP99});
  if (!model.HasTimes())
    throw files::StoreError("the file has no times; `record timing` adds them");
  return {TextOf(BudgetTable(model, options.budget_ns, options.phase).Made(), options.format),
          model.bad_count()};
}

}  // namespace cdb::printers
