#include "runtime/report/show_phases.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "runtime/report/row_table.h"
#include "runtime/statistics/figures.h"
#include "runtime/statistics/numbers.h"
#include "runtime/terminal/table.h"

namespace cdb::report {
namespace {

class PhaseTables {
 public:
  PhaseTables(const store::ResultFile& file, const std::vector<statistics::MeasuredPoint>& points,
              const std::vector<std::size_t>& by, const std::vector<measure::Phase>& phases,
              statistics::CycleTimes& times)
      : file_(file),
        times_(times),
        by_(by),
        phases_(phases.empty() ? AllPhases() : phases),
        rows_(statistics::MatchRows(points, by)),
        has_times_(file.Has("duration")),
        has_intervals_(has_times_ && times.bootstrap().kind() != statistics::IntervalKind::kAbsent),
        unit_(UnitOf()) {}

  std::string Text() {
    if (!has_times_ && !file_.Has("pairs")) return {};
    std::string text = fmt::format("\n{} of a cycle{}\n{}{}{}", times_.StatisticHead(), Unit(),
                                   Means(), StatisticLine(), rows_.MatchLines());
    if (!has_times_) return text;
    text += fmt::format("\n5th .. 95th percentile over the cycles{}\n{}", Unit(), Spreads());
    if (has_intervals_)
      text += fmt::format("\n{} of a cycle, its {}{}\n{}{}", times_.StatisticHead(),
                          times_.IntervalName(), Unit(), Intervals(),
                          times_.IntervalLine(LacksRepeats()));
    return text;
  }

 private:
  static std::vector<measure::Phase> AllPhases() {
    std::vector<measure::Phase> phases;
    for (std::size_t i = 0; i < measure::kPhaseCount; ++i)
      phases.push_back(static_cast<measure::Phase>(i));
    return phases;
  }
  static std::string_view NameOf(measure::Phase phase) {
    return measure::PhaseNames()[measure::IndexOf(phase)];
  }

  /// Counts are the same in all repeats.
  std::string StatisticLine() const {
    if (!has_times_)
      return rows_.pools ? "  Mean over cycles and cells.\n" : "  Mean over cycles.\n";
    return has_intervals_ ? times_.StatisticLine(rows_.pools)
                          : times_.StatisticAndIntervalLine(rows_.pools);
  }

  std::string Unit() const { return has_times_ ? fmt::format(", {}", unit_.name) : ""; }

  bool LacksRepeats() {
    return std::ranges::any_of(rows_.rows, [this](const statistics::Row& row) {
      return MeanOfRow(row, measure::Phase::kStep).things < times_.bootstrap().size();
    });
  }

  /// The unit of the median step.
  terminal::TimeUnit UnitOf() {
    std::vector<double> steps;
    if (has_times_)
      for (const statistics::Row& row : rows_.rows)
        steps.push_back(MeanOfRow(row, measure::Phase::kStep).value);
    std::ranges::sort(steps);
    return terminal::TimeUnit::For(statistics::Percentile(steps, 0.5));
  }

  statistics::Estimate MeanOfRow(const statistics::Row& row, measure::Phase phase) {
    std::vector<statistics::Estimate> means;
    for (const statistics::MeasuredPoint* point : row.points)
      means.push_back(times_.FigureOf(*point, phase));
    return statistics::MeanOf(means);
  }

  /// Repeats have the same counts.
  double MeanCount(const statistics::Row& row, const char* series) const {
    std::vector<double> means;
    for (const statistics::MeasuredPoint* point : row.points)
      means.push_back(statistics::Mean(file_.ReadSeries(series, point->cells[0])));
    return statistics::Mean(means);
  }

  std::string Means() {
    RowTable table(file_, by_, rows_.pools);
    if (has_times_)
      for (const measure::Phase phase : phases_) table.AddColumn(NameOf(phase));
    for (const char* series : {"pairs", "contacts"})
      if (file_.Has(series)) table.AddColumn(series);
    for (const statistics::Row& row : rows_.rows) {
      std::vector<std::string> figures;
      if (has_times_)
        for (const measure::Phase phase : phases_)
          figures.push_back(terminal::ShortNumber(MeanOfRow(row, phase).value / unit_.ns));
      for (const char* series : {"pairs", "contacts"})
        if (file_.Has(series)) figures.push_back(terminal::ShortNumber(MeanCount(row, series)));
      table.AddRow(row, std::move(figures));
    }
    return table.Text();
  }

  /// A table whose cells are `range_of(row, phase)`, in ns.
  template <typename RangeOf>
  std::string Ranges(RangeOf range_of) {
    RowTable table(file_, by_, rows_.pools);
    for (const measure::Phase phase : phases_) table.AddColumn(NameOf(phase));
    for (const statistics::Row& row : rows_.rows) {
      std::vector<std::string> figures;
      for (const measure::Phase phase : phases_) {
        const statistics::Interval ns = range_of(row, phase);
        figures.push_back(statistics::IntervalText({ns.low / unit_.ns, ns.high / unit_.ns}));
      }
      table.AddRow(row, std::move(figures));
    }
    return table.Text();
  }

  std::string Spreads() {
    return Ranges([this](const statistics::Row& row, measure::Phase phase) -> statistics::Interval {
      std::vector<double> cycles;
      for (const statistics::MeasuredPoint* point : row.points)
        statistics::Append(cycles, times_.Of(*point, phase).cycles);
      std::ranges::sort(cycles);
      return {statistics::Percentile(cycles, 0.05), statistics::Percentile(cycles, 0.95)};
    });
  }

  std::string Intervals() {
    return Ranges([this](const statistics::Row& row, measure::Phase phase) {
      return times_.IntervalOf(MeanOfRow(row, phase));
    });
  }

  const store::ResultFile& file_;
  statistics::CycleTimes& times_;
  const std::vector<std::size_t>& by_;
  const std::vector<measure::Phase> phases_;
  const statistics::Rows rows_;
  const bool has_times_, has_intervals_;
  const terminal::TimeUnit unit_;
};

}  // namespace

std::string ShowPhases(const store::ResultFile& file,
                       const std::vector<statistics::MeasuredPoint>& points,
                       const std::vector<std::size_t>& by,
                       const std::vector<measure::Phase>& phases, statistics::CycleTimes& times) {
  return points.empty() ? "" : PhaseTables(file, points, by, phases, times).Text();
}

}  // namespace cdb::report
