// One table for a paper (`cdb show --table`): a figure of each configuration, with one axis across.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "compiler/schema/metrics.h"
#include "compiler/schema/series.h"
#include "runtime/figures/coverage.h"
#include "runtime/figures/errors.h"
#include "runtime/figures/model.h"
#include "runtime/figures/times.h"
#include "runtime/printers/json_points.h"
#include "runtime/printers/show.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

using figures::Estimate;
using figures::Interval;
using figures::Point;

/// Significant digits of a value.
constexpr int kFewestDigits = 2, kMostDigits = 6;
/// Half an interval that begins with less has two digits, else one: the rule of the Particle Data
/// Group (Review of Particle Physics, introduction).
constexpr double kTwoDigits = 3.55;
constexpr std::size_t kMaxPlaces = 6;  // in one remark

int ExponentOf(double value) { return static_cast<int>(std::floor(std::log10(std::fabs(value)))); }

/// `value` to the digit of 10^`last`.
std::string RoundedText(double value, int last, bool has_exponent) {
  const double unit = std::pow(10.0, last), rounded = std::round(value / unit) * unit;
  if (rounded == 0) return "0";
  if (has_exponent) return fmt::format("{:.{}e}", rounded, std::max(0, ExponentOf(rounded) - last));
  return last > 0 ? fmt::format("{:.0f}", rounded) : fmt::format("{:.{}f}", value, -last);
}

bool HasEnds(const Interval& interval) {
  return std::isfinite(interval.low) && std::isfinite(interval.high);
}

}  // namespace

std::string MeasuredText(double value, const Interval& interval) {
  if (!std::isfinite(value)) return "-";
  const double half = (interval.high - interval.low) / 2;
  if (!HasEnds(interval)) return terminal::ShortNumber(value);
  if (!(half > 0) || value == 0)
    return fmt::format("{} [{}, {}]", terminal::ShortNumber(value),
                       terminal::ShortNumber(interval.low), terminal::ShortNumber(interval.high));
  const int first = ExponentOf(value), of_half = ExponentOf(half);
  const int last = std::clamp(half < kTwoDigits * std::pow(10.0, of_half) ? of_half - 1 : of_half,
                              first - kMostDigits + 1, first - kFewestDigits + 1);
  const auto text = [&](double number) {
    return RoundedText(number, last, first < -4 || first >= 7);  // as ShortNumber
  };
  return fmt::format("{} [{}, {}]", text(value), text(interval.low), text(interval.high));
}

namespace {

/// The figure of one row of the model, before the table.
struct Figure {
  figures::Row row;
  double value;
  Interval interval;
  std::string doubt;  ///< the reason why it is not a sound figure of its place; may be empty
};

/// The figure that a table shows.
struct Metric {
  std::string name, unit;
  double scale = 1;  ///< of the unit
  bool is_time = false;
  std::optional<protocol::Phase> phase = {};  ///< of a time, if it is of one phase
};

/// One table, with a column for each value of an axis.
class PaperTable {
 public:
  PaperTable(const figures::Model& model, const ShowTableOptions& options)
      : model_(model), file_(model.file()), options_(options), is_error_(IsError(options.metric)) {
    ChooseAxes();
    if (is_error_)
      AddErrors();
    else
      AddMeasured();
    ChooseBase();
  }

  Section Made() {
    Section section = {.title = file_.title()};
    AddHeads(section.table);
    for (const Point& at : Rows()) {
      std::vector<std::string> cells = Coordinates(file_, rows_, at);
      for (const std::size_t value : Values()) cells.push_back(CellText(at, value));
      if (base_)
        for (const std::size_t value : Values())
          if (value != *base_) cells.push_back(SpeedUpText(at, value));
      section.table.rows.push_back(std::move(cells));
    }
    section.notes = Notes();
    return section;
  }

 private:
  static constexpr const char *kTimePerSecond = "ms_per_s", *kMegabytes = "MB";

  bool IsError(const std::string& name) const {
    return std::ranges::any_of(schema::Errors(), [&](const schema::ErrorInfo& error) {
      return error.name == name && file_.Has(fmt::format("accuracy/{}", name));
    });
  }

  static bool IsSeed(const plan::Axis& axis) {
    return axis.parameter == "seed" || axis.name == "seed";
  }

  /// Across: the axis of detectors, else the last one with several values. Down: the others, but
  /// for seeds.
  void ChooseAxes() {
    std::vector<std::size_t> varied;
    for (const std::size_t axis : figures::AllAxes(file_))
      if (model_.axis(axis).values.size() > 1 && !IsSeed(model_.axis(axis))) varied.push_back(axis);
    for (const std::string& name : options_.by) rows_.push_back(figures::FindAxis(file_, name));
    const auto is_row = [&](std::size_t axis) {
      return std::ranges::find(rows_, axis) != rows_.end();
    };
    std::vector<std::size_t> left = varied;
    std::erase_if(left, is_row);
    const auto detectors = model_.detector_axis();
    if (!options_.columns.empty())
      across_ = figures::FindAxis(file_, options_.columns);
    else if (detectors && std::ranges::find(left, *detectors) != left.end())
      across_ = detectors;
    else if (left.size() > (rows_.empty() ? 1U : 0U))
      across_ = left.back();
    if (across_ && is_row(*across_))
      throw files::StoreError(
          fmt::format("--by and --columns both name the axis '{}'", model_.axis(*across_).name));
    if (options_.by.empty())
      for (const std::size_t axis : varied)
        if (axis != across_) rows_.push_back(axis);
    shown_ = rows_;
    if (across_) shown_.push_back(*across_);
  }

  void ChooseBase() {
    if (options_.baseline.empty()) return;
    if (!metric_.is_time)
      throw files::StoreError(fmt::format(
          "--baseline is for times, of which there is a speed-up; {} is none", options_.metric));
    if (!across_)
      throw files::StoreError("--baseline names a value of the columns, but there is one column");
    const plan::Axis& axis = model_.axis(*across_);
    const figures::NamedValues found = figures::FindValues(axis, options_.baseline);
    if (found.indices.size() != 1)
      throw files::StoreError(
          fmt::format("the axis '{}' of the columns has no value '{}'; it has "
                      "{}",
                      axis.name, options_.baseline, figures::ValuesText(axis)));
    base_ = found.indices[0];
  }

  std::string AllNames() const {
    std::vector<std::string> names;
    if (model_.HasTimes()) {
      for (const protocol::Phase phase : model_.TimedPhases())
        names.push_back(figures::PhaseName(phase));
      names.emplace_back(kTimePerSecond);
    }
    for (const std::string& name : DocumentedCounts(model_)) names.push_back(name);
    for (const std::string& name : DocumentedMemory(model_)) names.push_back(name);
    for (const schema::ErrorInfo& error : schema::Errors())
      if (std::string name(error.name); IsError(name)) names.push_back(std::move(name));
    return fmt::format("{}", fmt::join(names, ", "));
  }

  void AddErrors() {
    const figures::ErrorFigures found =
        figures::CollectErrors(model_, {.error = options_.metric, .by = Names(shown_), .each = {}});
    const auto& info =
        *std::ranges::find(schema::Errors(), options_.metric, &schema::ErrorInfo::name);
    metric_ = {.name = options_.metric, .unit = std::string(info.unit)};
    seed_count_ = found.seed_count;
    for (const auto& [key, table] : found.tables) {
      matched_ = table.matched;
      for (const figures::ErrorRow& row : table.rows) {
        figures_.push_back(
            {row.row, row.error, row.error_interval,
             Joined({row.unsound, row.IsBelowFloor() ? "below its floor" : "", row.row.mark})});
        if (shown_.empty()) figures_.back().row.at.clear();
      }
    }
    // The fastest were first.
    std::ranges::stable_sort(figures_, {}, [](const Figure& of) { return of.row.is_void; });
    matched_.by = shown_;
  }

  /// The words that are not empty, by commas.
  static std::string Joined(std::vector<std::string> words) {
    std::erase(words, "");
    return fmt::format("{}", fmt::join(words, ", "));
  }

  std::vector<std::string> Names(const std::vector<std::size_t>& axes) const {
    std::vector<std::string> names;
    for (const std::size_t axis : axes) names.push_back(model_.axis(axis).name);
    return names;
  }

  void AddMeasured() {
    const auto value_of = ChooseMeasured();
    matched_ = figures::MatchRows(model_.points(), shown_);
    for (figures::Row& row : matched_.rows) {
      const Estimate estimate = value_of(row);
      figures_.push_back({row, estimate.value,
                          metric_.is_time ? model_.times().IntervalOf(estimate)
                                          : Interval{figures::kNone, figures::kNone},
                          Joined({figures::UnsoundText(file_, row), row.mark})});
    }
    if (!metric_.phase) return;
    std::vector<double> times;
    for (const Figure& of : figures_) times.push_back(of.value);
    const terminal::TimeUnit unit = terminal::TimeUnit::For(figures::Median(std::move(times)));
    metric_.unit = unit.name;
    metric_.scale = unit.ns;
  }

  /// Sets the metric; the function gives its value in a row. Throws StoreError.
  std::function<Estimate(const figures::Row&)> ChooseMeasured() {
    const std::string& name = options_.metric;
    metric_.name = name;
    if (model_.HasTimes()) {
      for (const protocol::Phase phase : model_.TimedPhases())
        if (figures::PhaseName(phase) == name) {
          metric_.is_time = true;
          metric_.phase = phase;
          return [this, phase](const figures::Row& row) { return model_.TimeOf(row, phase); };
        }
      if (name == kTimePerSecond) {
        metric_ = {.name = "run time of a simulated second", .unit = "ms", .is_time = true};
        return [this](const figures::Row& row) {
          std::vector<Estimate> times;
          for (const figures::MeasuredPoint* point : row.points)
            times.push_back(model_.MsPerSecondOf(*point));
          return figures::MeanOf(times);
        };
      }
    }
    const auto lists = [&](const std::vector<std::string>& names) {
      return std::ranges::find(names, name) != names.end();
    };
    if (lists(DocumentedCounts(model_))) {
      if (const schema::Series* series = schema::FindSeries(name)) metric_.unit = series->unit;
      return [this, name](const figures::Row& row) {
        return Estimate{model_.CountOf(row, name), {}};
      };
    }
    if (lists(DocumentedMemory(model_))) {
      metric_.unit = kMegabytes;
      metric_.scale = 1e6;
      return [this, name](const figures::Row& row) {
        return Estimate{model_.MemoryOf(row, name), {}};
      };
    }
    throw files::StoreError(fmt::format(
        "--table takes a figure of the file, not '{}'; there are {}", name, AllNames()));
  }

  /// The places of the rows, in grid order.
  std::set<Point> Rows() const {
    std::set<Point> rows;
    for (const Figure& of : figures_) rows.insert(RowOf(of));
    return rows;
  }
  Point RowOf(const Figure& of) const {
    Point at = of.row.at;
    if (across_) at.pop_back();
    return at;
  }
  /// The values of the columns; 0 if there is no axis across.
  std::set<std::size_t> Values() const {
    std::set<std::size_t> values;
    for (const Figure& of : figures_) values.insert(across_ ? of.row.at.back() : 0);
    return values;
  }

  /// The figure of a place: sound, and with nothing left out, if there is one.
  const Figure* Find(const Point& row, std::size_t value) const {
    const auto found = std::ranges::find_if(figures_, [&](const Figure& of) {
      return RowOf(of) == row && (!across_ || of.row.at.back() == value);
    });
    return found == figures_.end() ? nullptr : &*found;
  }

  std::string UnitText() const {
    const bool is_terminal =
        options_.format == Format::kTerminal || options_.format == Format::kWrapped;
    return metric_.unit == "us" && !is_terminal ? "µs" : metric_.unit;
  }

  void AddHeads(Table& table) const {
    for (const std::size_t axis : rows_) {
      const plan::Axis& of = model_.axis(axis);
      table.AddColumn(LabelOf(of) + (of.unit.empty() ? "" : ", " + of.unit), !of.IsText());
    }
    table.keys = rows_.size();
    std::string metric = metric_.name;
    std::ranges::replace(metric, '_', ' ');
    if (!metric_.unit.empty()) metric += ", " + UnitText();
    if (!across_) return table.AddColumn(metric, true);
    const plan::Axis& axis = model_.axis(*across_);
    // Words such as the names of detectors need no name of the axis.
    const auto head_of = [&](std::size_t value) {
      const std::string text = terminal::CoordinateText(axis, value);
      return axis.IsText() ? text : fmt::format("{} {}", axis.name, text);
    };
    for (const std::size_t value : Values()) table.AddColumn(head_of(value), true, metric);
    if (!base_) return;
    for (const std::size_t value : Values())
      if (value != *base_)
        table.AddColumn(head_of(value), true, fmt::format("speed-up over {}", head_of(*base_)));
  }

  std::string CellText(const Point& row, std::size_t value) {
    const Figure* of = Find(row, value);
    if (of == nullptr) return "-";
    const std::string text =
        MeasuredText(of->value / metric_.scale,
                     {of->interval.low / metric_.scale, of->interval.high / metric_.scale});
    has_intervals_ = has_intervals_ || HasEnds(of->interval);
    const std::string doubt = Joined({of->doubt, OthersText(*of)});
    if (doubt.empty()) return text;
    doubts_[doubt].push_back(figures::PlaceText(file_, shown_, of->row.at));
    return text + " *";
  }

  /// Points of the same place that are not pooled with `shown`.
  std::string OthersText(const Figure& shown) const {
    std::set<std::string> marks;
    for (const Figure& of : figures_)
      if (&of != &shown && of.row.at == shown.row.at)
        marks.insert(of.row.mark.empty() ? "nothing left out" : of.row.mark);
    return marks.empty()
               ? ""
               : fmt::format("without its runs that are marked {}", fmt::join(marks, ", "));
  }

  /// The geometric mean of the ratios at the points that both have, if both are sound and alike in
  /// their omissions.
  std::string SpeedUpText(const Point& row, std::size_t value) const {
    const Figure *base = Find(row, *base_), *of = Find(row, value);
    if (base == nullptr || of == nullptr || base->row.is_void || of->row.is_void) return "-";
    std::vector<Estimate> ratios;
    for (const figures::MeasuredPoint* point : of->row.points) {
      Point at = point->at;
      at[*across_] = *base_;
      const auto other = std::ranges::find(base->row.points, at,
                                           [](const figures::MeasuredPoint* p) { return p->at; });
      if (other == base->row.points.end() || !point->UnlikeComponents(**other).empty()) return "-";
      ratios.push_back(figures::RatioOf(TimeOf(**other), TimeOf(*point)));
    }
    const Estimate mean = figures::GeometricMeanOf(ratios);
    const bool is_doubtful = !base->doubt.empty() || !of->doubt.empty();
    return MeasuredText(mean.value, model_.times().IntervalOf(mean)) + (is_doubtful ? " *" : "");
  }
  Estimate TimeOf(const figures::MeasuredPoint& point) const {
    return metric_.phase ? model_.TimeOf(point, *metric_.phase) : model_.MsPerSecondOf(point);
  }

  std::vector<std::string> Notes() const {
    std::vector<std::string> notes;
    const figures::CycleTimes& times = model_.times();
    if (metric_.is_time) {
      notes.push_back(times.StatisticNote(matched_.pools));
      std::string interval = times.IntervalNote();
      if (has_intervals_) {
        interval[0] = static_cast<char>(std::tolower(interval[0]));
        const bool is_range = times.bootstrap().kind() == figures::IntervalKind::kRange;
        interval =
            fmt::format("In brackets: {}{}", is_range ? "" : times.IntervalName() + ", ", interval);
      }
      notes.push_back(std::move(interval));
    } else if (is_error_) {
      if (has_intervals_)
        notes.push_back(
            fmt::format("Mean over {} seeds; in brackets: {}, by bootstrap over the "
                        "seeds.",
                        seed_count_, figures::NameOf(figures::Bootstrap(seed_count_).kind())));
    } else {
      notes.emplace_back(metric_.unit == kMegabytes ? "The largest of the repeats."
                         : matched_.pools           ? "Mean over cycles and cells."
                                                    : "Mean over cycles.");
    }
    if (base_ && matched_.pools)
      notes.emplace_back("Speed-ups are geometric means over the pooled cells.");
    for (std::string& note : matched_.MatchNotes()) notes.push_back(std::move(note));
    for (const auto& [doubt, places] : doubts_) {
      const std::size_t named = std::min(places.size(), kMaxPlaces);
      const std::vector<std::string> first(places.begin(),
                                           places.begin() + static_cast<std::ptrdiff_t>(named));
      notes.push_back(fmt::format(
          "* {}: {}{}", doubt, fmt::join(first, "; "),
          places.size() > named ? fmt::format("; and {} more", places.size() - named) : ""));
    }
    return notes;
  }

  const figures::Model& model_;
  const results::ResultFile& file_;
  const ShowTableOptions& options_;
  const bool is_error_;
  std::vector<std::size_t> rows_, shown_;  ///< axes
  std::optional<std::size_t> across_;      ///< an axis
  std::optional<std::size_t> base_;        ///< a value on it
  Metric metric_;
  figures::Rows matched_;
  std::vector<Figure> figures_;
  std::size_t seed_count_ = 0;
  bool has_intervals_ = false;
  std::map<std::string, std::vector<std::string>> doubts_;  ///< with their places
};

}  // namespace

Printed ShowTable(const results::ResultFile& file, const ShowTableOptions& options) {
  const figures::Model model(file,
                             {.only_sound = options.only_sound, .statistic = options.statistic});
  Document document = {PaperTable(model, options).Made()};
  if (Section doubts = BriefDoubts(model); !doubts.lines.empty())
    document.push_back(std::move(doubts));
  return {TextOf(document, options.format), model.bad_count(),
          figures::CountNotMet(model.requirements())};
}

}  // namespace cdb::printers
