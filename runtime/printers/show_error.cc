// Error against run time, as tables and plots (`cdb show --error`).
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "compiler/schema/metrics.h"
#include "runtime/figures/errors.h"
#include "runtime/printers/notes.h"
#include "runtime/printers/show.h"
#include "runtime/printers/show_parts.h"
#include "runtime/terminal/log_plot.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
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
        figures_(figures::CollectErrors(model, options)) {}

  Document Made() const {
    Document document = {Head()};
    bool has_below_floor = false;
    for (const auto& [key, table] : figures_.tables) {
      document.push_back({.title = figures::PlaceText(file_, figures_.each, key),
                          .table = TableOf(table),
                          .notes = Legend(table)});
      if (std::string plot = PlotOf(table.rows); !plot.empty())
        document.push_back({.plot = std::move(plot)});
      has_below_floor = has_below_floor || std::ranges::any_of(table.rows, &ErrorRow::IsBelowFloor);
    }
    if (has_below_floor)
      document.push_back({.title =
                              "An error below its floor is not significant: the reference and its "
                              "perturbed run differ by as much."});
    return document;
  }

 private:
  Section Head() const {
    const auto& info = *std::ranges::find(schema::Errors(), name_, &schema::ErrorInfo::name);
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
    for (std::size_t i = 0; i < std::min(points.size(), kMaxListed); ++i) {
      const std::string place = figures::PlaceText(file_, figures::AllAxes(file_), points[i].at);
      lines.push_back(fmt::format("  {}: {}", place.empty() ? "the run" : place, points[i].why));
    }
    if (points.size() > kMaxListed)
      lines.push_back(fmt::format("  and {} more", points.size() - kMaxListed));
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
      cells.push_back(terminal::ScientificNumber(row.error));
      if (HasErrorIntervals())
        cells.push_back(terminal::ScientificNumber(row.error_interval.low) + " .. " +
                        terminal::ScientificNumber(row.error_interval.high));
      if (has_floor) cells.push_back(terminal::ScientificNumber(row.floor));
      if (has_floor) cells.push_back(terminal::ShortNumber(row.horizon));
      std::string note = row.on_front ? "front" : row.is_tie ? "tie" : "";
      if (row.IsBelowFloor()) note += note.empty() ? "below floor" : ", below floor";
      table.AddRow(row.row, cells, note);
    }
    return table.Take();
  }

  /// States the statistic, how the intervals were made, and the meaning of a tie.
  std::vector<std::string> Legend(const ErrorRows& rows) const {
    std::vector<std::string> notes = {model_.times().StatisticAndIntervalNote(rows.matched.pools)};
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
      if (row.error > 0) points.push_back({row.RealTimeFactor(), row.error, mark});
    }
    return terminal::LogPlot(points, "x real time", name_);
  }

  const figures::Model& model_;
  const results::ResultFile& file_;
  const std::string name_;
  const figures::ErrorFigures figures_;
};

}  // namespace

Printed ShowError(const results::ResultFile& file, const ShowErrorOptions& options) {
  const figures::Model model(file, {.only_sound = options.only_sound});
  return {TextOf(ErrorSummary(model, options.errors).Made(), options.format),
          model.runs().bad.size()};
}

}  // namespace cdb::printers
