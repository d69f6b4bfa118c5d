#include "runtime/report/show_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "compiler/schema/metrics.h"
#include "runtime/report/cells.h"
#include "runtime/report/figures.h"
#include "runtime/report/findings.h"
#include "runtime/report/table.h"

namespace cdb::report {
namespace {

using Cell = store::ResultFile::Cell;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kPlotWidth = 60, kPlotHeight = 14;
constexpr std::size_t kMaxListed = 12;

double Mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// One configuration: its repeats together, and all points of the axes that are not shown.
struct Row {
  Point at;                      ///< on the axes that make the rows
  std::vector<double> ms_per_s;  ///< of each run, sorted
  std::vector<double> errors, floors;
  double horizon = kNone;  ///< the shortest
  bool on_front = false;

  double Error() const { return Mean(errors); }
  double Floor() const { return Mean(floors); }
  /// What is known of the error: a smaller one than its floor is not better.
  double Known() const { return std::fmax(Error(), Floor()); }
  double Time() const { return Percentile(ms_per_s, 0.5); }
  /// Simulated seconds in a second.
  double RealTimeFactor() const { return 1000 / Time(); }
};

/// The fastest first; of those on the front, each is more accurate than all before it.
void MarkFront(std::vector<Row>& rows) {
  std::ranges::stable_sort(rows, {},
                           [](const Row& row) { return std::pair(row.Time(), row.Known()); });
  double least = std::numeric_limits<double>::infinity();
  for (Row& row : rows) {
    row.on_front = row.Known() < least;
    least = std::min(least, row.Known());
  }
}

/// Few digits, also where the number is small.
std::string ErrorText(double value) {
  return std::isnan(value) ? "-" : value == 0 ? "0" : fmt::format("{:.2e}", value);
}

class ErrorTable {
 public:
  ErrorTable(const store::ResultFile& file, const ShowErrorOptions& options)
      : file_(file), name_(options.error), dataset_("accuracy/" + options.error) {
    CheckName();
    for (const std::string& axis : options.each) each_.push_back(FindAxis(file, axis));
    for (const std::string& axis : options.by) rows_.push_back(FindAxis(file, axis));
    if (rows_.empty())
      for (std::size_t i = 0; i < file.axes().size(); ++i) rows_.push_back(i);
    std::erase_if(rows_, [&](std::size_t axis) { return IsIn(each_, axis); });
    Collect();
  }

  ShowText Text() {
    std::string text = Head();
    for (auto& [key, rows_of_key] : tables_) {
      std::vector<Row> rows;
      for (auto& [at, row] : rows_of_key) {
        std::ranges::sort(row.ms_per_s);
        rows.push_back(std::move(row));
      }
      MarkFront(rows);
      text += "\n";
      for (std::size_t i = 0; i < each_.size(); ++i)
        text += fmt::format("{} {}{}", file_.axes()[each_[i]].name,
                            CoordinateText(file_.axes()[each_[i]], key[i]),
                            i + 1 < each_.size() ? ", " : "\n");
      text += TableOf(rows) + PlotOf(rows);
    }
    if (!below_floor_.empty())
      text += "\nBelow its floor an error says nothing: reference and twin are as far apart.\n";
    return {text, bad_};
  }

 private:
  void CheckName() const {
    std::string names;
    for (const schema::ErrorInfo& error : schema::Errors())
      if (file_.Has("accuracy/" + std::string(error.name)))
        names += fmt::format("{}{}", names.empty() ? "" : ", ", error.name);
    if (names.empty())
      throw store::StoreError(
          "this file holds no errors: its scenario has no accuracy { metrics … }, see "
          "`cdb doc accuracy`");
    const bool is_error = std::ranges::any_of(
        schema::Errors(), [&](const schema::ErrorInfo& error) { return error.name == name_; });
    if (!is_error || !file_.Has(dataset_))
      throw store::StoreError(
          fmt::format("there is no error '{}' in this file; there are {}", name_, names));
    if (!file_.Has("duration"))
      throw store::StoreError(
          "this file holds no timings to set errors against; add timing to what the scenario "
          "records");
  }

  void Collect() {
    Point at(file_.axes().size(), 0);
    for (;;) {
      CollectPoint(at);
      std::size_t i = at.size();
      while (i > 0 && ++at[i - 1] == file_.axes()[i - 1].values.size()) at[--i] = 0;
      if (i == 0) return;
    }
  }

  void CollectPoint(const Point& at) {
    std::vector<double> ms_per_s;
    double error = kNone, floor = kNone, horizon = kNone;
    std::string why;
    for (std::uint64_t rep = 0; rep < file_.repeats(); ++rep) {
      const Cell cell{at, rep};
      const store::Status status = file_.ReadStatus(cell);
      if (status == store::Status::kSkipped) return;
      if (const auto trouble = Trouble(file_, cell)) {
        why = *trouble;
        bad_ += status == store::Status::kMissing ? 0 : 1;
        continue;
      }
      const std::vector<double> steps = file_.ReadDuration(measure::Phase::kStep, cell);
      const double ns =
          std::accumulate(steps.begin(), steps.end(), 0.0) / static_cast<double>(steps.size());
      if (!steps.empty() && std::isfinite(ns))
        ms_per_s.push_back(ns * 1e-6 / file_.ReadReal("accuracy/timestep", cell));
      // Repeats go the same way, so that errors are alike.
      error = file_.ReadReal(dataset_, cell);
      if (file_.Has(dataset_ + "_floor")) floor = file_.ReadReal(dataset_ + "_floor", cell);
      if (file_.Has("accuracy/horizon")) horizon = file_.ReadReal("accuracy/horizon", cell);
      if (std::isnan(error)) why = file_.ReadText("accuracy/message", cell);
    }
    if (ms_per_s.empty() || std::isnan(error)) {
      left_out_.push_back(fmt::format("{}: {}", PlaceOf(at), why.empty() ? "no value" : why));
      return;
    }
    Row& row = tables_[Project(at, each_)][Project(at, rows_)];
    row.at = Project(at, rows_);
    row.ms_per_s.insert(row.ms_per_s.end(), ms_per_s.begin(), ms_per_s.end());
    row.errors.push_back(error);
    row.floors.push_back(floor);
    row.horizon = std::fmin(row.horizon, horizon);
  }

  static bool IsIn(const std::vector<std::size_t>& axes, std::size_t axis) {
    return std::ranges::find(axes, axis) != axes.end();
  }
  static Point Project(const Point& at, const std::vector<std::size_t>& axes) {
    Point part;
    for (const std::size_t axis : axes) part.push_back(at[axis]);
    return part;
  }

  /// Several runs are in one row.
  bool Pools() const {
    return file_.repeats() > 1 || rows_.size() + each_.size() < file_.axes().size();
  }

  std::string PlaceOf(const Point& at) const {
    std::string text;
    for (std::size_t i = 0; i < at.size(); ++i)
      text += fmt::format("{}{} {}", i == 0 ? "" : ", ", file_.axes()[i].name,
                          CoordinateText(file_.axes()[i], at[i]));
    return text.empty() ? "the run" : text;
  }

  std::string Head() const {
    const auto& info = *std::ranges::find(schema::Errors(), name_, &schema::ErrorInfo::name);
    std::string text =
        fmt::format("{}\n{}  {}{}: {}\n", file_.title(), WrongDetectors(file_, FindingsOf(file_)),
                    name_, info.unit.empty() ? "" : fmt::format(", {}", info.unit), info.doc);
    if (const std::string build = file_.ReadProvenance("build_type"); build != "Release")
      text +=
          fmt::format("  Timed with a {} build of cdb: these are not timings to quote.\n", build);
    std::string pooled;
    for (std::size_t i = 0; i < file_.axes().size(); ++i)
      if (!IsIn(rows_, i) && !IsIn(each_, i))
        pooled += (pooled.empty() ? "" : ", ") + file_.axes()[i].name;
    if (!pooled.empty()) text += fmt::format("  the mean over {}\n", pooled);
    if (left_out_.empty()) return text;
    text += fmt::format("  {} without a place in it:\n", left_out_.size());
    for (std::size_t i = 0; i < std::min(left_out_.size(), kMaxListed); ++i)
      text += fmt::format("    {}\n", left_out_[i]);
    if (left_out_.size() > kMaxListed)
      text += fmt::format("    and {} more\n", left_out_.size() - kMaxListed);
    return text;
  }

  std::string TableOf(const std::vector<Row>& rows) {
    Table table;
    for (const std::size_t axis : rows_)
      table.AddColumn(file_.axes()[axis].name, !file_.axes()[axis].IsText());
    table.AddColumn("x real time", true);
    table.AddColumn("ms per s", true);
    if (Pools()) table.AddColumn("5th .. 95th", true);
    table.AddColumn(name_, true);
    const bool has_floor = file_.Has(dataset_ + "_floor");
    if (has_floor) table.AddColumn("floor", true);
    if (has_floor) table.AddColumn("horizon, s", true);
    table.AddColumn("", false);
    for (const Row& row : rows) {
      std::vector<std::string> cells;
      for (std::size_t i = 0; i < rows_.size(); ++i)
        cells.push_back(CoordinateText(file_.axes()[rows_[i]], row.at[i]));
      cells.push_back(ShortNumber(row.RealTimeFactor()));
      cells.push_back(ShortNumber(row.Time()));
      if (Pools())
        cells.push_back(ShortNumber(Percentile(row.ms_per_s, 0.05)) + " .. " +
                        ShortNumber(Percentile(row.ms_per_s, 0.95)));
      cells.push_back(ErrorText(row.Error()));
      if (has_floor) cells.push_back(ErrorText(row.Floor()));
      if (has_floor) cells.push_back(ShortNumber(row.horizon));
      std::string mark = row.on_front ? "front" : "";
      if (row.Error() < row.Floor()) {
        mark += mark.empty() ? "below floor" : ", below floor";
        below_floor_ = mark;
      }
      cells.push_back(std::move(mark));
      table.AddRow(std::move(cells));
    }
    return table.Text();
  }

  std::string PlotOf(const std::vector<Row>& rows) const {
    std::vector<PlotPoint> points;
    for (const Row& row : rows)
      if (row.Error() > 0) points.push_back({row.RealTimeFactor(), row.Error(), row.on_front});
    const std::string plot = LogPlot(points, "x real time", name_);
    return plot.empty() ? plot : "\n" + plot;
  }

  const store::ResultFile& file_;
  const std::string name_, dataset_;
  std::vector<std::size_t> rows_, each_;  ///< axes
  std::map<Point, std::map<Point, Row>> tables_;
  std::vector<std::string> left_out_;
  std::string below_floor_;
  std::size_t bad_ = 0;
};

}  // namespace

std::string LogPlot(const std::vector<PlotPoint>& points, const std::string& x_name,
                    const std::string& y_name) {
  if (points.size() < 2) return {};
  const auto range = [&points](auto of) {
    double low = of(points[0]), high = low;
    for (const PlotPoint& point : points) {
      low = std::min(low, of(point));
      high = std::max(high, of(point));
    }
    return std::pair(low, high);
  };
  const auto [left, right] = range([](const PlotPoint& point) { return point.x; });
  const auto [bottom, top] = range([](const PlotPoint& point) { return point.y; });
  const auto place = [](double value, double low, double high, std::size_t extent) {
    const double share = low == high ? 0.5 : std::log(value / low) / std::log(high / low);
    return static_cast<std::size_t>(std::lround(share * static_cast<double>(extent - 1)));
  };
  std::vector<std::string> lines(kPlotHeight, std::string(kPlotWidth, ' '));
  for (const bool front : {false, true})
    for (const PlotPoint& point : points)
      if (point.on_front == front)
        lines[kPlotHeight - 1 - place(point.y, bottom, top, kPlotHeight)]
             [place(point.x, left, right, kPlotWidth)] = front ? '*' : 'o';
  std::string text = fmt::format("{}, * front\n", y_name);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::string label;
    if (i == 0) label = ErrorText(top);
    if (i + 1 == lines.size()) label = ErrorText(bottom);
    const std::size_t end = lines[i].find_last_not_of(' ') + 1;
    text += fmt::format("{:>9} |{}\n", label, lines[i].substr(0, end));
  }
  const std::string from = ShortNumber(left), to = ShortNumber(right);
  text += fmt::format("{:>9} +{}\n", "", std::string(kPlotWidth, '-'));
  const std::size_t room = kPlotWidth - std::min(kPlotWidth, from.size() + to.size());
  text += fmt::format("{:>11}{}{:^{}}{}\n", "", from, x_name, room, to);
  return text;
}

ShowText ShowError(const store::ResultFile& file, const ShowErrorOptions& options) {
  return ErrorTable(file, options).Text();
}

}  // namespace cdb::report
