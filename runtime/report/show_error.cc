#include "runtime/report/show_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compiler/schema/metrics.h"
#include "runtime/report/row_table.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/error_figures.h"
#include "runtime/statistics/findings.h"
#include "runtime/statistics/processors.h"
#include "runtime/terminal/log_plot.h"
#include "runtime/terminal/table.h"

namespace cdb::report {
namespace {

constexpr std::size_t kMaxListed = 12;

class ErrorSummary {
 public:
  ErrorSummary(const store::ResultFile& file, const statistics::ErrorOptions& options)
      : file_(file),
        name_(options.error),
        dataset_("accuracy/" + options.error),
        times_(file),
        figures_(statistics::CollectErrors(file, options, times_)) {}

  ShowText Text() const {
    std::string text = Head();
    bool has_below_floor = false;
    for (const auto& [key, table] : figures_.tables) {
      text += "\n" + Caption(key) + TableOf(table) + Legend(table) + PlotOf(table.rows);
      has_below_floor =
          has_below_floor || std::ranges::any_of(table.rows, &statistics::ErrorRow::IsBelowFloor);
    }
    if (has_below_floor)
      text +=
          "\nAn error below its floor is not significant: the reference and its perturbed run "
          "differ by as much.\n";
    return {text, figures_.bad_cells};
  }

 private:
  /// `scene stack, detector dbvt`; empty for a single table.
  std::string Caption(const statistics::Point& key) const {
    std::string text;
    const auto& each = figures_.each;
    for (std::size_t i = 0; i < each.size(); ++i)
      text += fmt::format("{} {}{}", file_.axes()[each[i]].name,
                          terminal::CoordinateText(file_.axes()[each[i]], key[i]),
                          i + 1 < each.size() ? ", " : "\n");
    return text;
  }

  static bool IsIn(const std::vector<std::size_t>& axes, std::size_t axis) {
    return std::ranges::find(axes, axis) != axes.end();
  }
  std::string PlaceOf(const statistics::Point& at) const {
    std::string text;
    for (std::size_t i = 0; i < at.size(); ++i)
      text += fmt::format("{}{} {}", i == 0 ? "" : ", ", file_.axes()[i].name,
                          terminal::CoordinateText(file_.axes()[i], at[i]));
    return text.empty() ? "the run" : text;
  }

  std::string Head() const {
    const auto& info = *std::ranges::find(schema::Errors(), name_, &schema::ErrorInfo::name);
    std::string text =
        fmt::format("{}\n{}  {}{}: {}\n", file_.title(),
                    statistics::WrongDetectors(file_, statistics::FindingsOf(file_)), name_,
                    info.unit.empty() ? "" : fmt::format(", {}", info.unit), info.doc);
    if (const std::string build = file_.ReadProvenance("build_type"); build != "Release")
      text += fmt::format("  Timed with a {} build of cdb: do not quote these timings.\n", build);
    text += statistics::ProcessorText(file_, statistics::AllCells(file_));
    std::string pooled;
    for (std::size_t i = 0; i < file_.axes().size(); ++i)
      if (!IsIn(figures_.rows, i) && !IsIn(figures_.each, i))
        pooled += (pooled.empty() ? "" : ", ") + file_.axes()[i].name;
    if (!pooled.empty()) text += fmt::format("  the mean over {}\n", pooled);
    return text + Listed(figures_.left_out, "not on the plot, as the error is not known") +
           Listed(figures_.marked, "did not end well; marked, and not on the front");
  }

  std::string Listed(const std::vector<statistics::ErrorFigures::LeftOut>& points,
                     const char* what) const {
    if (points.empty()) return {};
    std::string text = fmt::format("  {} {}:\n", points.size(), what);
    for (std::size_t i = 0; i < std::min(points.size(), kMaxListed); ++i)
      text += fmt::format("    {}: {}\n", PlaceOf(points[i].at), points[i].why);
    if (points.size() > kMaxListed)
      text += fmt::format("    and {} more\n", points.size() - kMaxListed);
    return text;
  }

  bool HasTimeIntervals() const {
    return times_.bootstrap().kind() != statistics::IntervalKind::kAbsent;
  }
  bool HasErrorIntervals() const { return figures_.seed_count > 1; }
  statistics::IntervalKind ErrorKind() const {
    return statistics::Bootstrap(figures_.seed_count).kind();
  }

  std::string TableOf(const statistics::ErrorRows& rows) const {
    RowTable table(file_, figures_.rows, rows.matched.pools);
    table.AddColumn("x real time");
    table.AddColumn("ms per s");
    if (HasTimeIntervals()) table.AddColumn(times_.IntervalName());
    table.AddColumn(name_);
    if (HasErrorIntervals())
      table.AddColumn(ErrorKind() == statistics::IntervalKind::kRange ? "range" : "95 % interval");
    const bool has_floor = file_.Has(dataset_ + "_floor");
    if (has_floor) table.AddColumn("floor");
    if (has_floor) table.AddColumn("horizon, s");
    for (const statistics::ErrorRow& row : rows.rows) {
      std::vector<std::string> cells = {terminal::ShortNumber(row.RealTimeFactor()),
                                        terminal::ShortNumber(row.ms_per_s.value)};
      if (HasTimeIntervals()) cells.push_back(statistics::IntervalText(row.time_interval));
      cells.push_back(terminal::ScientificNumber(row.error));
      if (HasErrorIntervals())
        cells.push_back(terminal::ScientificNumber(row.error_interval.low) + " .. " +
                        terminal::ScientificNumber(row.error_interval.high));
      if (has_floor) cells.push_back(terminal::ScientificNumber(row.floor));
      if (has_floor) cells.push_back(terminal::ShortNumber(row.horizon));
      std::string note = row.on_front ? "front" : row.is_tie ? "tie" : "";
      if (row.IsBelowFloor()) note += note.empty() ? "below floor" : ", below floor";
      table.AddRow(row.row, std::move(cells), note);
    }
    return table.Text();
  }

  /// States the statistic, how the intervals were made, and the meaning of a tie.
  std::string Legend(const statistics::ErrorRows& rows) const {
    std::string text = times_.StatisticAndIntervalLine(rows.matched.pools);
    if (HasErrorIntervals())
      text += fmt::format("  Errors: the mean over {} seeds, their {}.\n", figures_.seed_count,
                          ErrorKind() == statistics::IntervalKind::kRange
                              ? "range over all draws of the seeds"
                              : "interval by bootstrap over the seeds");
    if (std::ranges::any_of(rows.rows, &statistics::ErrorRow::is_tie))
      text += fmt::format(
          "  tie: every configuration that is as fast and as accurate lies within the {} and the "
          "floor.\n",
          times_.IntervalName());
    return text + rows.matched.MatchLines();
  }

  std::string PlotOf(const std::vector<statistics::ErrorRow>& rows) const {
    std::vector<terminal::PlotPoint> points;
    for (const statistics::ErrorRow& row : rows) {
      const terminal::PlotMark mark = row.row.is_void ? terminal::PlotMark::kVoid
                                      : row.on_front  ? terminal::PlotMark::kFront
                                      : row.is_tie    ? terminal::PlotMark::kTie
                                                      : terminal::PlotMark::kOff;
      if (row.error > 0) points.push_back({row.RealTimeFactor(), row.error, mark});
    }
    const std::string plot = terminal::LogPlot(points, "x real time", name_);
    return plot.empty() ? plot : "\n" + plot;
  }

  const store::ResultFile& file_;
  const std::string name_, dataset_;
  statistics::CycleTimes times_;
  const statistics::ErrorFigures figures_;
};

}  // namespace

ShowText ShowError(const store::ResultFile& file, const statistics::ErrorOptions& options) {
  return ErrorSummary(file, options).Text();
}

}  // namespace cdb::report
