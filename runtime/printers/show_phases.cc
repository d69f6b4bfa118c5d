// The time of each phase of a cycle, for `cdb show`.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "runtime/figures/bootstrap.h"
#include "runtime/figures/coverage.h"
#include "runtime/figures/times.h"
#include "runtime/printers/show.h"
#include "runtime/terminal/log_plot.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

/// A smaller part of a step outside of the phases is not worth a note.
constexpr double kNoticeableRest = 0.1;

using figures::Row;
using protocol::Phase;

class PhaseTables {
 public:
  PhaseTables(const figures::Model& model, const std::vector<std::size_t>& by,
              const std::vector<Phase>& phases)
      : model_(model),
        times_(model.times()),
        phases_(!phases.empty() || !model.HasTimes() ? phases : model.TimedPhases()),
        has_all_(phases.empty()),
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
    if (const double rest = LargestRest(); rest > kNoticeableRest)
      document.back().notes.push_back(
          fmt::format("Up to {:.0f} % of a step is in none of detect, solve and integrate: "
                      "predicting the motion, islands and sleep, and with `ccd on` the contacts "
                      "ahead of fast objects; on a noisy machine also pauses in between.",
                      100 * rest));
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

  /// The largest part of a step, of all rows, that is in no other column; 0 if not all are shown.
  double LargestRest() const {
    double largest = 0;
    if (!has_times_ || !has_all_) return largest;
    for (const Row& row : rows_.rows) {
      const auto time_of = [&](Phase phase) { return model_.TimeOf(row, phase).value; };
      const double step = time_of(Phase::kStep);
      const double named =
          time_of(Phase::kDetect) + time_of(Phase::kSolve) + time_of(Phase::kIntegrate);
      if (step > 0) largest = std::fmax(largest, (step - named) / step);
    }
    return largest;
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
      table.AddRow(row, figures, figures::UnsoundText(model_.file(), row));
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
  const bool has_all_;  ///< shows every phase that has a time
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

// Events that `record counters` counted, for `cdb show`.

namespace {

class CounterTables {
 public:
  CounterTables(const figures::Model& model, const std::vector<std::size_t>& by)
      : model_(model), rows_(figures::MatchRows(model.points(), by)) {
    for (std::size_t i = 0; i < protocol::kCounterCount; ++i) {
      const auto counter = static_cast<schema::Counter>(i);
      (IsCounted(counter)         ? counted_
       : IsPartlyCounted(counter) ? partial_
                                  : missing_)
          .push_back(counter);
    }
  }

  /// Without a table if the phase was not measured.
  void AddPhase(Phase phase, Document& document) const {
    RowTable table(model_.file(), rows_);
    for (const schema::Counter counter : counted_) table.AddColumn(NameOf(counter));
    const bool has_rate =
        Counts(schema::Counter::kInstructions) && Counts(schema::Counter::kCpuCycles);
    if (has_rate) table.AddColumn("per cpu_cycle");
    bool has_rows = false;
    for (const Row& row : rows_.rows) {
      const auto count_of = [&](schema::Counter counter) {
        return figures::CounterOf(model_.file(), row.points, counter, phase);
      };
      std::vector<std::string> figures;
      for (const schema::Counter counter : counted_) {
        const double count = count_of(counter);
        has_rows = has_rows || !std::isnan(count);
        figures.push_back(std::isnan(count) ? "-" : terminal::ShortNumber(count));
      }
      if (has_rate)
        figures.push_back(terminal::ShortNumber(count_of(schema::Counter::kInstructions) /
                                                count_of(schema::Counter::kCpuCycles)));
      table.AddRow(row, figures, figures::UnsoundText(model_.file(), row));
    }
    if (!has_rows) return;
    document.push_back(
        {.title = fmt::format("Events of {} in a cycle, the mean", figures::PhaseName(phase)),
         .table = table.Take()});
  }

  /// Lines about the counters that have no column.
  std::vector<std::string> Notes() const {
    std::vector<std::string> lines;
    if (!missing_.empty())
      lines.push_back(
          fmt::format("{}: not counted by the machine of these runs{} (cdb doc counters).",
                      NamesOf(missing_), ReasonText()));
    if (!partial_.empty())
      lines.push_back(
          fmt::format("{}: without a mean, since only some of the cycles were counted (cdb doc "
                      "counters).",
                      NamesOf(partial_)));
    return lines;
  }

 private:
  /// The likely reason why counters are missing, by those that are not.
  const char* ReasonText() const {
    const std::size_t missing = missing_.size();
    if (missing == protocol::kCounterCount) return ", which does not permit it";
    const bool misses_faults =
        std::ranges::find(missing_, schema::Counter::kPageFaults) != missing_.end();
    const bool misses_processor = missing + 1 == protocol::kCounterCount && !misses_faults;
    return misses_processor ? "; most virtual machines hide these counters" : "";
  }
  static std::string NamesOf(const std::vector<schema::Counter>& counters) {
    std::vector<std::string_view> names;
    for (const schema::Counter counter : counters) names.push_back(NameOf(counter));
    return fmt::format("{}", fmt::join(names, ", "));
  }
  static std::string_view NameOf(schema::Counter counter) {
    return schema::kCounters[static_cast<std::size_t>(counter)];
  }
  bool Counts(schema::Counter counter) const {
    return std::ranges::find(counted_, counter) != counted_.end();
  }
  bool IsCounted(schema::Counter counter) const {
    return std::ranges::any_of(rows_.rows, [&](const Row& row) {
      return !std::isnan(figures::CounterOf(model_.file(), row.points, counter, Phase::kStep));
    });
  }
  bool IsPartlyCounted(schema::Counter counter) const {
    for (const figures::MeasuredPoint& point : model_.points())
      for (const figures::Cell& cell : point.cells)
        for (const double count : model_.file().ReadCounter(counter, Phase::kStep, cell))
          if (!std::isnan(count)) return true;
    return false;
  }

  const figures::Model& model_;
  const figures::Rows rows_;
  std::vector<schema::Counter> counted_;
  std::vector<schema::Counter> partial_;  ///< in some cycles, but in all cycles of no row
  std::vector<schema::Counter> missing_;
};

}  // namespace

void AddCounters(const figures::Model& model, const std::vector<std::size_t>& by,
                 const std::vector<Phase>& phases, Document& document) {
  if (model.points().empty() || !model.file().Has("counters")) return;
  const CounterTables tables(model, by);
  for (const Phase phase : phases) tables.AddPhase(phase, document);
  if (phases.empty())
    for (std::size_t i = 0; i < protocol::kPhaseCount; ++i)
      tables.AddPhase(static_cast<Phase>(i), document);
  std::vector<std::string> notes = tables.Notes();
  if (!notes.empty()) document.push_back({.lines = std::move(notes)});
}

// Small plots of characters, for `cdb show --plot`.

namespace {

constexpr std::size_t kMaxSparklines = 24, kSparkWidth = 50;
/// An axis with fewer numbers gets no curve.
constexpr std::size_t kLeastOnAxis = 3;
constexpr std::string_view kBars[] = {"\u2581", "\u2582", "\u2583", "\u2584",
                                      "\u2585", "\u2586", "\u2587", "\u2588"};
constexpr double kMiddleBar = 3.0 / 7;
constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyz";

std::vector<double> Bins(const std::vector<double>& values, std::size_t width) {
  const std::size_t count = std::min(values.size(), width);
  std::vector<double> bins;
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0, n = 0;
    for (std::size_t j = i * values.size() / count; j < (i + 1) * values.size() / count; ++j) {
      if (std::isnan(values[j])) continue;
      sum += values[j];
      ++n;
    }
    bins.push_back(sum / n);
  }
  return bins;
}

Section OverCycles(const figures::Model& model, protocol::Phase phase) {
  const std::vector<figures::MeasuredPoint>& points = model.points();
  const std::vector<std::size_t> all = figures::AllAxes(model.file());
  Table table;
  AddAxes(model.file(), all, table);
  table.AddColumn("over the cycles", false);
  table.AddColumn("least", true);
  table.AddColumn("most", true);
  for (std::size_t i = 0; i < std::min(points.size(), kMaxSparklines); ++i) {
    const std::vector<double>& cycles = model.times().Of(points[i], phase).cycles;
    double least = figures::kNone;
    for (const double ns : cycles) least = std::fmin(least, ns);
    std::vector<std::string> row = Coordinates(model.file(), all, points[i].at);
    row.insert(row.end(), {Sparkline(cycles, kSparkWidth), figures::TimeText(least),
                           figures::TimeText(figures::Largest(cycles))});
    table.rows.push_back(std::move(row));
  }
  Section section = {
      .title = fmt::format(
          "Time of {} over the cycles{}; each line has its own scale", figures::PhaseName(phase),
          model.times().bootstrap().size() > 1 ? ", medians over the repeats" : ""),
      .table = std::move(table)};
  if (points.size() > kMaxSparklines)
    section.notes.push_back(fmt::format("The first {} of {} points; --select chooses others.",
                                        kMaxSparklines, points.size()));
  return section;
}

/// The geometric mean over all other axes except that of detectors, with a letter for each
/// detector.
void AddOverAxis(const figures::Model& model, std::size_t axis, protocol::Phase phase,
                 Document& document) {
  const auto detectors = model.detector_axis();
  std::map<std::pair<std::size_t, std::size_t>, std::vector<double>> found;
  for (const figures::MeasuredPoint& point : model.points())
    if (point.IsSound())
      found[{detectors ? point.at[*detectors] : 0, point.at[axis]}].push_back(
          model.TimeOf(point, phase).value);
  std::vector<terminal::PlotPoint> plotted;
  std::string legend;
  std::size_t last = kLetters.size();
  for (const auto& [key, values] : found) {
    const auto& [detector, value] = key;
    const double x = std::get<double>(model.axis(axis).values[value]),
                 y = figures::GeometricMean(values);
    if (!(x > 0) || !(y > 0)) continue;
    const char letter = detectors ? kLetters[detector % kLetters.size()] : 'o';
    if (detectors && detector != last)
      legend += fmt::format("{}{} {}", legend.empty() ? ": " : ", ", letter,
                            terminal::CoordinateText(model.axis(*detectors), detector));
    last = detector;
    plotted.push_back({x, y, terminal::PlotMark::kOff, letter});
  }
  const std::string& name = model.axis(axis).name;
  std::string plot =
      terminal::LogPlot(plotted, name,
                        fmt::format("{} {} over {}, ns{}", model.times().StatisticHead(),
                                    figures::PhaseName(phase), name, legend));
  if (!plot.empty())
    document.push_back(
        {.plot = std::move(plot), .notes = {"Logarithmic; geometric mean over all other axes."}});
}

}  // namespace

std::string Sparkline(const std::vector<double>& values, std::size_t width, double alike) {
  const std::vector<double> bins = Bins(values, width);
  const double most = figures::Largest(bins);
  double least = figures::kNone;
  for (const double value : bins) least = std::fmin(least, value);
  std::string text;
  for (const double value : bins) {
    const double share = most > least * (1 + alike) ? (value - least) / (most - least)
                         : alike > 0                ? kMiddleBar
                                                    : 0;
    text += std::isnan(value) ? std::string(" ")
                              : std::string(kBars[static_cast<std::size_t>(std::lround(
                                    share * static_cast<double>(std::size(kBars) - 1)))]);
  }
  return text;
}

void AddPlots(const figures::Model& model, const std::vector<protocol::Phase>& phases,
              Document& document) {
  if (!model.HasTimes() || model.points().empty()) return;
  for (const protocol::Phase phase :
       phases.empty() ? std::vector{protocol::Phase::kStep} : phases) {
    document.push_back(OverCycles(model, phase));
    for (const std::size_t i : figures::AllAxes(model.file()))
      if (model.axis(i).IsScale() && model.axis(i).values.size() >= kLeastOnAxis)
        AddOverAxis(model, i, phase, document);
  }
}

}  // namespace cdb::printers
