// The time of each phase of a cycle, for `cdb show`.
#include <fmt/format.h>

#include <algorithm>

#include "runtime/figures/bootstrap.h"
#include "runtime/printers/show_parts.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

using figures::Row;
using protocol::Phase;

class PhaseTables {
 public:
  PhaseTables(const figures::Model& model, const std::vector<std::size_t>& by,
              const std::vector<Phase>& phases)
      : model_(model),
        times_(model.times()),
        phases_(phases.empty() ? figures::AllPhases() : phases),
        rows_(figures::MatchRows(model.points(), by)),
        has_times_(model.HasTimes()),
        has_intervals_(has_times_ && times_.HasIntervals()),
        unit_(UnitOf()) {
    for (const char* series : {"pairs", "contacts"})
      if (model.file().Has(series)) counts_.emplace_back(series);
  }

  void AddTo(Document& document) const {
    const std::string unit = has_times_ ? fmt::format(", {}", unit_.name) : "",
                      head(times_.StatisticHead());
    document.push_back({.title = fmt::format("{} of a cycle{}", head, unit),
                        .table = Means(),
                        .notes = {StatisticNote()}});
    for (std::string& note : rows_.MatchNotes()) document.back().notes.push_back(std::move(note));
    if (!has_times_) return;
    document.push_back(
        {.title = "5th .. 95th percentile over the cycles" + unit,
         .table = Ranges([this](const Row& row, Phase phase) { return SpreadOf(row, phase); })});
    if (!has_intervals_) return;
    document.push_back(
        {.title = fmt::format("{} of a cycle, its {}{}", head, times_.IntervalName(), unit),
         .table = Ranges([this](const Row& row, Phase phase) {
           return times_.IntervalOf(model_.TimeOf(row, phase));
         }),
         .notes = {times_.IntervalNote(LacksRepeats())}});
  }

 private:
  /// Counts are the same in all repeats.
  std::string StatisticNote() const {
    if (!has_times_) return rows_.pools ? "Mean over cycles and cells." : "Mean over cycles.";
    return has_intervals_ ? times_.StatisticNote(rows_.pools)
                          : times_.StatisticAndIntervalNote(rows_.pools);
  }

  bool LacksRepeats() const {
    return std::ranges::any_of(rows_.rows, [this](const Row& row) {
      return model_.TimeOf(row, Phase::kStep).things < times_.bootstrap().size();
    });
  }

  /// The unit of the median step.
  terminal::TimeUnit UnitOf() const {
    std::vector<double> steps;
    if (has_times_)
      for (const Row& row : rows_.rows) steps.push_back(model_.TimeOf(row, Phase::kStep).value);
    return terminal::TimeUnit::For(figures::Median(std::move(steps)));
  }

  Table Means() const {
    RowTable table(model_.file(), rows_);
    if (has_times_)
      for (const Phase phase : phases_) table.AddColumn(figures::PhaseName(phase));
    for (const std::string& series : counts_) table.AddColumn(series);
    for (const Row& row : rows_.rows) {
      std::vector<std::string> figures;
      if (has_times_)
        for (const Phase phase : phases_)
          figures.push_back(terminal::ShortNumber(model_.TimeOf(row, phase).value / unit_.ns));
      for (const std::string& series : counts_)
        figures.push_back(terminal::ShortNumber(model_.CountOf(row, series)));
      table.AddRow(row, figures);
    }
    return table.Take();
  }

  /// A table whose cells are `range_of(row, phase)`, in ns.
  template <typename RangeOf>
  Table Ranges(RangeOf range_of) const {
    RowTable table(model_.file(), rows_);
    for (const Phase phase : phases_) table.AddColumn(figures::PhaseName(phase));
    for (const Row& row : rows_.rows) {
      std::vector<std::string> figures;
      for (const Phase phase : phases_) {
        const figures::Interval ns = range_of(row, phase);
        figures.push_back(figures::IntervalText({ns.low / unit_.ns, ns.high / unit_.ns}));
      }
      table.AddRow(row, figures);
    }
    return table.Take();
  }

  figures::Interval SpreadOf(const Row& row, Phase phase) const {
    std::vector<double> cycles;
    for (const figures::MeasuredPoint* point : row.points) {
      const std::vector<double>& more = times_.Of(*point, phase).cycles;
      cycles.insert(cycles.end(), more.begin(), more.end());
    }
    std::ranges::sort(cycles);
    return {figures::Percentile(cycles, 0.05), figures::Percentile(cycles, 0.95)};
  }

  const figures::Model& model_;
  figures::CycleTimes& times_;
  const std::vector<Phase> phases_;
  const figures::Rows rows_;
  const bool has_times_, has_intervals_;
  const terminal::TimeUnit unit_;
  std::vector<std::string> counts_;  ///< series
};

}  // namespace

void AddPhases(const figures::Model& model, const std::vector<std::size_t>& by,
               const std::vector<Phase>& phases, Document& document) {
  if (model.points().empty() || (!model.HasTimes() && !model.file().Has("pairs"))) return;
  PhaseTables(model, by, phases).AddTo(document);
}

}  // namespace cdb::printers
