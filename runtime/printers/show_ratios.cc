// Ratios of the detectors in a comparison to a baseline, for `cdb show`.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "compiler/schema/metrics.h"
#include "runtime/figures/bootstrap.h"
#include "runtime/figures/detectors.h"
#include "runtime/figures/errors.h"
#include "runtime/figures/ratios.h"
#include "runtime/figures/requirements.h"
#include "runtime/figures/times.h"
#include "runtime/printers/document.h"
#include "runtime/printers/show.h"
#include "runtime/terminal/log_plot.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

using figures::ComparedPoint;
using figures::Comparison;

/// A sentence if detectors that are compared at one point had different omissions.
std::string UnlikeText(const Comparison& comparison) {
  std::set<std::string> components;
  std::size_t unlike = 0;
  for (const ComparedPoint& point : comparison.points) {
    components.insert(point.unlike.begin(), point.unlike.end());
    unlike += point.unlike.empty() ? 0 : 1;
  }
  if (unlike == 0) return {};
  return fmt::format(
      "At {} of {} points, some detectors ran without {} and others with it: these ratios are "
      "not due to the detectors alone. omit none makes them alike.",
      unlike, comparison.points.size(), fmt::join(components, ", "));
}

class RatioTable {
 public:
  explicit RatioTable(const Comparison& comparison)
      : comparison_(comparison),
        file_(comparison.model->file()),
        times_(comparison.model->times()),
        detector_(file_.axes()[comparison.axis]),
        others_(figures::OtherAxes(file_, comparison.axis)) {}

  Section Made(protocol::Phase phase) {
    Table table;
    AddAxes(file_, others_, table);
    if (others_.empty()) table.AddColumn("", false);
    table.keys = HeadSize();
    for (std::size_t i = 0; i < detector_.values.size(); ++i)
      table.AddColumn(terminal::CoordinateText(detector_, i), true);
    if (comparison_.points.size() <= kMaxRows)
      for (const ComparedPoint& point : comparison_.points) AddPoint(table, point, phase);
    if (comparison_.points.size() > 1) AddMeans(table, phase);
    return {.title = fmt::format("{} {} over that of {}{}", times_.StatisticHead(),
                                 figures::PhaseName(phase),
                                 terminal::CoordinateText(detector_, comparison_.baseline),
                                 comparison_.points.size() > 1 ? " (geometric mean below)" : ""),
            .table = std::move(table),
            .notes = Legend()};
  }

 private:
  std::size_t HeadSize() const { return std::max<std::size_t>(1, others_.size()); }

  void AddPoint(Table& table, const ComparedPoint& point, protocol::Phase phase) {
    std::vector<std::string> row = Coordinates(file_, others_, point.at), below;
    row.resize(HeadSize());
    below.resize(HeadSize());
    for (std::size_t i = 0; i < detector_.values.size(); ++i) {
      const auto ratio = comparison_.RatioAt(point, i, phase);
      const std::string text = ratio ? terminal::ShortNumber(ratio->value) : "-";
      const bool counts = point.is_matched && !comparison_.is_void;
      row.push_back(counts || !ratio ? text : "(" + text + ")");
      has_parentheses_ = has_parentheses_ || (ratio && !counts);
      below.push_back(ratio && i != comparison_.baseline
                          ? figures::IntervalText(times_.IntervalOf(*ratio))
                          : "");
    }
    table.rows.push_back(std::move(row));
    const bool is_empty = std::ranges::all_of(below, &std::string::empty);
    if (times_.HasIntervals() && !is_empty) table.rows.push_back(std::move(below));
  }

  void AddMeans(Table& table, protocol::Phase phase) {
    std::vector<std::string> mean(HeadSize()), interval(HeadSize()), range(HeadSize());
    mean[0] = "mean";
    range[0] = "range";
    for (std::size_t i = 0; i < detector_.values.size(); ++i) {
      const auto all = figures::MeanRatioOf(comparison_, i, phase);
      if (!all || !all->is_matched) {
        for (auto* row : {&mean, &interval, &range}) row->push_back("-");
        continue;
      }
      const std::string text = terminal::ShortNumber(all->mean.value);
      mean.push_back(comparison_.is_void ? "(" + text + ")" : text);
      interval.push_back(i == comparison_.baseline ? "" : figures::IntervalText(all->interval));
      range.push_back(figures::IntervalText({all->least, all->most}));
    }
    table.rows.push_back(std::move(mean));
    if (times_.HasIntervals()) table.rows.push_back(std::move(interval));
    table.rows.push_back(std::move(range));
  }

  /// Explains the numbers below each ratio, and the means.
  std::vector<std::string> Legend() const {
    std::vector<std::string> notes = {"No interval: one repeat."};
    if (times_.bootstrap().kind() == figures::IntervalKind::kRange)
      notes[0] =
          "Below each ratio its range over all draws of repeats, the same for both detectors.";
    if (times_.bootstrap().kind() == figures::IntervalKind::kInterval)
      notes[0] =
          "Below each ratio its 95 % interval: bootstrap over repeats, the same for both "
          "detectors.";
    const std::size_t all = comparison_.points.size(), matched = comparison_.MatchedCount();
    if (all > 1)
      notes.push_back(fmt::format("Mean and range over {} of {} cells{}.", matched, all,
                                  matched < all ? ": those that all detectors have" : ""));
    if (comparison_.is_void)
      notes.emplace_back("In parentheses: every run is void.");
    else if (has_parentheses_)
      notes.emplace_back("In parentheses: a detector is void, missing, or has other omissions.");
    return notes;
  }

  const Comparison& comparison_;
  const results::ResultFile& file_;
  const figures::CycleTimes& times_;
  const plan::Axis& detector_;
  const std::vector<std::size_t> others_;  ///< indices of axes
  bool has_parentheses_ = false;           ///< some ratio is not included in the means
};

}  // namespace

void AddRatios(const figures::Model& model, const std::string& baseline,
               const std::vector<protocol::Phase>& phases, Document& document) {
  const auto comparison = figures::CompareDetectors(model, baseline);
  if (!comparison) return;
  RatioTable table(*comparison);
  if (std::string text = UnlikeText(*comparison); !text.empty())
    document.push_back({.title = std::move(text)});
  for (const protocol::Phase phase :
       phases.empty() ? std::vector{protocol::Phase::kDetect, protocol::Phase::kStep} : phases)
    document.push_back(table.Made(phase));
}

// The cost of each detector in a comparison, and its growth, for `cdb show`.

namespace {

using figures::DetectorCosts;
using figures::DetectorGrowth;
using figures::Model;

/// The axes that make rows, detectors last so that their rows are adjacent.
std::vector<std::size_t> RowsOf(const Model& model, std::size_t detector_axis,
                                std::vector<std::size_t> by) {
  if (by.empty() && model.points().size() <= kMaxRows) by = figures::AllAxes(model.file());
  std::erase(by, detector_axis);
  by.push_back(detector_axis);
  return by;
}

std::string CountText(double count) {
  return std::isnan(count) ? "-" : fmt::format("{:.0f}", count);
}

std::string ExponentText(double p) {
  // Avoids "-0.00".
  return std::isnan(p) ? "-" : fmt::format("{:.2f}", std::round(100 * p) / 100 + 0.0);
}

/// The unit in which most means are easy to read.
terminal::TimeUnit UnitOf(const std::vector<DetectorCosts>& costs) {
  std::vector<double> means;
  for (const DetectorCosts& row : costs) means.push_back(row.mean.value);
  return terminal::TimeUnit::For(figures::Median(std::move(means)));
}

Section CostsOf(const Model& model, const std::vector<std::size_t>& by, protocol::Phase phase) {
  const results::ResultFile& file = model.file();
  const figures::CycleTimes& times = model.times();
  const figures::Rows rows = figures::MatchRows(model.points(), by);
  std::vector<DetectorCosts> costs;
  for (const figures::Row& row : rows.rows) costs.push_back(figures::CostsOf(model, row, phase));
  const terminal::TimeUnit unit = UnitOf(costs);
  const bool has_pairs = file.Has("pairs"), has_exact = file.Has("exact_pairs"),
             has_heap = file.Has("heap");
  RowTable table(file, rows);
  table.AddColumn(times.statistic() == figures::CycleStatistic::kWorst ? "worst of any repeat"
                                                                       : times.StatisticName());
  if (times.HasIntervals()) table.AddColumn(times.IntervalName());
  table.AddColumn("worst");
  if (has_pairs) table.AddColumn("pairs");
  if (has_exact)
    for (const char* head : {"missed", "phantom"}) table.AddColumn(head);
  table.AddColumn("peak rss, MB");
  if (has_heap) table.AddColumn("heap, MB");
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const DetectorCosts& row = costs[i];
    std::vector<std::string> texts = {terminal::ShortNumber(row.mean.value / unit.ns)};
    if (times.HasIntervals())
      texts.push_back(
          figures::IntervalText(times.IntervalOf(figures::Scaled(row.mean, 1 / unit.ns))));
    texts.push_back(terminal::ShortNumber(row.worst / unit.ns));
    if (has_pairs) texts.push_back(terminal::ShortNumber(row.pairs));
    if (has_exact)
      for (const double count : {row.missed, row.phantom}) texts.push_back(CountText(count));
    texts.push_back(terminal::ShortNumber(row.peak_rss / 1e6));
    if (has_heap) texts.push_back(terminal::ShortNumber(row.heap / 1e6));
    table.AddRow(rows.rows[i], texts);
  }
  Section section = {
      .title = fmt::format("Detectors: a cycle's {}, {}", figures::PhaseName(phase), unit.name),
      .table = table.Take(),
      .notes = {times.StatisticAndIntervalNote(rows.pools)}};
  for (std::string& note : rows.MatchNotes()) section.notes.push_back(std::move(note));
  return section;
}

/// The range of the number of objects over which an exponent is fitted: `10 .. 40`.
std::string ObjectsText(const DetectorGrowth::Exponent& exponent) {
  return CountText(exponent.least) + " .. " + CountText(exponent.most);
}

/// Notes to read before the exponents of two rows are compared.
std::vector<std::string> GrowthNotes(const DetectorGrowth& growth) {
  std::vector<std::string> notes = {
      "The interval is that of the fit: it is wide where the times follow no power."};
  if (!growth.is_matched)
    notes.emplace_back("The rows have different numbers of objects: do not compare them.");
  if (growth.dropped > 0)
    notes.push_back(fmt::format("Over the numbers of objects that all rows have, {}.",
                                ObjectsText(growth.exponents.begin()->second)));
  if (!growth.unlike.empty())
    notes.push_back(fmt::format(
        "Some points ran without {} and others with it: the growth is not due to the number of "
        "objects alone.",
        fmt::join(growth.unlike, ", ")));
  return notes;
}

void AddGrowth(const Model& model, const std::vector<std::size_t>& rows, protocol::Phase phase,
               Document& document) {
  const auto growth = figures::GrowthByRow(model, rows, phase);
  if (!growth || growth->exponents.empty()) return;
  Table table;
  AddAxes(model.file(), growth->rows, table);
  table.keys = 1;
  table.AddColumn("p", true);
  table.AddColumn("95 % interval", true);
  if (!growth->is_matched) table.AddColumn("objects", true);
  for (const auto& [point, exponent] : growth->exponents) {
    std::vector<std::string> texts = Coordinates(model.file(), growth->rows, point);
    texts.push_back(ExponentText(exponent.fit.p));
    const auto& [low, high] = exponent.fit.interval;
    texts.push_back(std::isnan(low) ? "-" : ExponentText(low) + " .. " + ExponentText(high));
    if (!growth->is_matched) texts.push_back(ObjectsText(exponent));
    table.rows.push_back(std::move(texts));
  }
  document.push_back(
      {.title = fmt::format("Growth over {}: p of {} ~ objects^p{}", model.axis(growth->axis).name,
                            figures::PhaseName(phase), growth->is_mean ? ", over all else" : ""),
       .table = std::move(table),
       .notes = GrowthNotes(*growth)});
}

}  // namespace

void AddDetectors(const Model& model, const std::vector<std::size_t>& by,
                  const std::vector<protocol::Phase>& phases, Document& document) {
  const auto axis = model.ComparedDetectors();
  if (!axis) return;
  const std::vector<std::size_t> rows = RowsOf(model, *axis, by);
  for (const protocol::Phase phase :
       phases.empty() ? std::vector{protocol::Phase::kDetect} : phases) {
    document.push_back(CostsOf(model, rows, phase));
    AddGrowth(model, rows, phase, document);
  }
}

void AddOtherFaults(const Model& model, Document& document) {
  using Findings = figures::DetectorFindings;
  const auto add = [&](const char* head, std::uint64_t Findings::*count, bool of_exact) {
    std::vector<std::string> faults;
    for (const Findings& of : model.findings())
      if (of.*count > 0)
        faults.push_back(fmt::format("{} {}{}", of.detector, of.*count,
                                     of_exact ? fmt::format(" beside {}", of.exact) : ""));
    if (!faults.empty())
      document.push_back({.title = fmt::format("{}: {}.", head, fmt::join(faults, ", "))});
  };
  add("Pairs listed that do not overlap", &Findings::false_positives, true);
  add("Pairs listed again", &Findings::duplicate, true);
  const auto contacts = figures::ContactFindingsOf(model.file());
  std::vector<std::string> missed;
  for (const figures::ContactFindings& of : contacts)
    if (of.missed > 0)
      missed.push_back(fmt::format("{} {} of {} compared", of.narrow_phase, of.missed, of.exact));
  if (!missed.empty())
    document.push_back(
        {.title = fmt::format("Overlaps without a contact: {}.", fmt::join(missed, ", "))});
  // Results from before overlaps were counted.
  if (contacts.empty()) add("Overlaps without a contact", &Findings::missed_contacts, false);
}

// Error against run time, as tables and plots (`cdb show --error`).

namespace {

using figures::ErrorRow;
using figures::ErrorRows;

constexpr std::size_t kMaxListed = 12;

class ErrorSummary {
 public:
  ErrorSummary(const figures::Model& model, const figures::ErrorOptions& options)
      : model_(model),
        file_(model.file()),
        name_(options.error),
        figures_(figures::CollectErrors(model, options)),
        orders_(figures::OrdersOf(model, Info(), figures_)) {}

  Document Made() const {
    Document document = {Head()};
    bool has_below_floor = false;
    for (const auto& [key, table] : figures_.tables) {
      document.push_back({.title = figures::PlaceText(file_, figures_.each, key),
                          .table = TableOf(table),
                          .notes = Legend(key, table)});
      if (std::string plot = PlotOf(table.rows); !plot.empty())
        document.push_back({.plot = std::move(plot)});
      has_below_floor = has_below_floor || std::ranges::any_of(table.rows, &ErrorRow::IsBelowFloor);
    }
    if (has_below_floor)
      document.push_back({.title =
                              "An error below its floor is not significant: the reference changes "
                              "by as much with twice its time step and a displaced start."});
    return document;
  }

 private:
  const schema::ErrorInfo& Info() const {
    return *std::ranges::find(schema::Errors(), name_, &schema::ErrorInfo::name);
  }

  Section Head() const {
    const schema::ErrorInfo& info = Info();
    Section head = {.title = file_.title(), .lines = WrongDetectors(model_)};
    const auto add = [&](std::string line) {
      if (!line.empty()) head.lines.push_back(std::move(line));
    };
    add(fmt::format("{}{}: {}", name_, info.unit.empty() ? "" : fmt::format(", {}", info.unit),
                    info.doc));
    add(BuildNote(file_));
    for (std::string& note : ProcessorNotes(file_, figures::AllCells(file_))) add(std::move(note));
    std::vector<std::string> pooled;
    for (const std::size_t axis : figures::AllAxes(file_))
      if (std::ranges::find(figures_.rows, axis) == figures_.rows.end() &&
          std::ranges::find(figures_.each, axis) == figures_.each.end())
        pooled.push_back(file_.axes()[axis].name);
    if (!pooled.empty()) add(fmt::format("the mean over {}", fmt::join(pooled, ", ")));
    AddListed(figures_.left_out, "not on the plot, as the error is not known", head.lines);
    AddListed(figures_.marked, "did not end well; marked, and not on the front", head.lines);
    return head;
  }

  void AddListed(const std::vector<figures::ErrorFigures::LeftOut>& points, const char* what,
                 std::vector<std::string>& lines) const {
    if (points.empty()) return;
    lines.push_back(fmt::format("{} {}:", points.size(), what));
    const auto reasons = figures::ByReason(points);
    for (std::size_t i = 0; i < std::min(reasons.size(), kMaxListed); ++i) {
      const auto& [first, count] = reasons[i];
      const std::string place = figures::PlaceText(file_, figures::AllAxes(file_), first->at);
      lines.push_back(fmt::format("  {}{}: {}", place.empty() ? "the run" : place,
                                  count > 1 ? fmt::format(" and {} more", count - 1) : "",
                                  first->why));
    }
    if (reasons.size() > kMaxListed)
      lines.push_back(fmt::format("  and {} more reasons", reasons.size() - kMaxListed));
  }

  bool HasErrorIntervals() const { return figures_.seed_count > 1; }
  std::string_view ErrorIntervalName() const {
    return figures::NameOf(figures::Bootstrap(figures_.seed_count).kind());
  }

  Table TableOf(const ErrorRows& rows) const {
    const figures::CycleTimes& times = model_.times();
    RowTable table(file_, rows.matched);
    table.AddColumn("x real time");
    table.AddColumn("ms per s");
    if (times.HasIntervals()) table.AddColumn(times.IntervalName());
    table.AddColumn(name_);
    if (HasErrorIntervals()) table.AddColumn(ErrorIntervalName());
    const bool has_floor = file_.Has("accuracy/" + name_ + "_floor");
    if (has_floor) table.AddColumn("floor");
    if (has_floor) table.AddColumn("horizon, s");
    for (const ErrorRow& row : rows.rows) {
      std::vector<std::string> cells = {terminal::ShortNumber(row.RealTimeFactor()),
                                        terminal::ShortNumber(row.ms_per_s.value)};
      if (times.HasIntervals()) cells.push_back(figures::IntervalText(row.time_interval));
      cells.push_back(terminal::ShortNumber(row.error));
      if (HasErrorIntervals())
        cells.push_back(terminal::ShortNumber(row.error_interval.low) + " .. " +
                        terminal::ShortNumber(row.error_interval.high));
      if (has_floor) cells.push_back(terminal::ShortNumber(row.floor));
      if (has_floor) cells.push_back(terminal::ShortNumber(row.horizon));
      std::string note = row.on_front ? "front" : row.is_tie ? "tie" : "";
      for (const std::string& more :
           {std::string(row.IsBelowFloor() ? "below floor" : ""), row.unsound})
        if (!more.empty()) note += (note.empty() ? "" : ", ") + more;
      table.AddRow(row.row, cells, note);
    }
    return table.Take();
  }

  /// States the statistic, how the intervals were made, and the meaning of a tie.
  std::vector<std::string> Legend(const figures::Point& scene, const ErrorRows& rows) const {
    std::vector<std::string> notes = {model_.times().StatisticAndIntervalNote(rows.matched.pools)};
    for (const figures::ErrorOrder& order : orders_) {
      if (order.scene != scene) continue;
      const std::string place = figures::PlaceText(file_, order.axes, order.at);
      notes.push_back(fmt::format("Order in the time step{}: {} (95 % interval {} .. {}).",
                                  place.empty() ? place : fmt::format(", {}", place),
                                  ExponentText(order.fit.p), ExponentText(order.fit.interval.low),
                                  ExponentText(order.fit.interval.high)));
    }
    if (HasErrorIntervals())
      notes.push_back(fmt::format("Errors: the mean over {} seeds, their {}.", figures_.seed_count,
                                  ErrorIntervalName() == "range"
                                      ? "range over all draws of the seeds"
                                      : "interval by bootstrap over the seeds"));
    if (std::ranges::any_of(rows.rows, &ErrorRow::is_tie))
      notes.push_back(fmt::format(
          "tie: every configuration that is as fast and as accurate lies within the {} and the "
          "floor.",
          model_.times().IntervalName()));
    for (std::string& note : rows.matched.MatchNotes()) notes.push_back(std::move(note));
    return notes;
  }

  std::string PlotOf(const std::vector<ErrorRow>& rows) const {
    std::vector<terminal::PlotPoint> points;
    for (const ErrorRow& row : rows) {
      const terminal::PlotMark mark = row.row.is_void ? terminal::PlotMark::kVoid
                                      : row.on_front  ? terminal::PlotMark::kFront
                                      : row.is_tie    ? terminal::PlotMark::kTie
                                                      : terminal::PlotMark::kOff;
      if (row.Known() > 0) points.push_back({row.RealTimeFactor(), row.Known(), mark});
    }
    return terminal::LogPlot(points, "x real time", name_);
  }

  const figures::Model& model_;
  const results::ResultFile& file_;
  const std::string name_;
  const figures::ErrorFigures figures_;
  const std::vector<figures::ErrorOrder> orders_;
};

}  // namespace

Printed ShowError(const results::ResultFile& file, const ShowErrorOptions& options) {
  const figures::Model model(file, {.only_sound = options.only_sound});
  return {TextOf(ErrorSummary(model, options.errors).Made(), options.format),
          model.runs().bad.size(), figures::CountNotMet(model.requirements())};
}

}  // namespace cdb::printers
