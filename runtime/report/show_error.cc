#include "runtime/report/show_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compiler/schema/metrics.h"
#include "runtime/report/error_figures.h"
#include "runtime/report/findings.h"
#include "runtime/report/log_plot.h"
#include "runtime/report/table.h"

namespace cdb::report {
namespace {

constexpr std::size_t kMaxListed = 12;

class ErrorTable {
 public:
  ErrorTable(const store::ResultFile& file, const ShowErrorOptions& options)
      : file_(file),
        name_(options.error),
        dataset_("accuracy/" + options.error),
        figures_(CollectErrors(file, options)) {}

  ShowText Text() const {
    std::string text = Head();
    bool has_below_floor = false;
    for (const auto& [key, rows] : figures_.tables) {
      text += "\n" + Caption(key) + TableOf(rows) + PlotOf(rows);
      has_below_floor = has_below_floor || std::ranges::any_of(rows, &ErrorRow::IsBelowFloor);
    }
    if (has_below_floor)
      text += "\nBelow its floor an error says nothing: reference and twin are as far apart.\n";
    return {text, figures_.bad_cells};
  }

 private:
  /// `scene stack, detector dbvt`; empty for a single table.
  std::string Caption(const Point& key) const {
    std::string text;
    const auto& each = figures_.each;
    for (std::size_t i = 0; i < each.size(); ++i)
      text += fmt::format("{} {}{}", file_.axes()[each[i]].name,
                          CoordinateText(file_.axes()[each[i]], key[i]),
                          i + 1 < each.size() ? ", " : "\n");
    return text;
  }

  static bool IsIn(const std::vector<std::size_t>& axes, std::size_t axis) {
    return std::ranges::find(axes, axis) != axes.end();
  }
  /// Several runs are in one row.
  bool Pools() const {
    return file_.repeats() > 1 || figures_.rows.size() + figures_.each.size() < file_.axes().size();
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
      if (!IsIn(figures_.rows, i) && !IsIn(figures_.each, i))
        pooled += (pooled.empty() ? "" : ", ") + file_.axes()[i].name;
    if (!pooled.empty()) text += fmt::format("  the mean over {}\n", pooled);
    if (figures_.left_out.empty()) return text;
    text += fmt::format("  {} without a place in it:\n", figures_.left_out.size());
    for (std::size_t i = 0; i < std::min(figures_.left_out.size(), kMaxListed); ++i)
      text +=
          fmt::format("    {}: {}\n", PlaceOf(figures_.left_out[i].at), figures_.left_out[i].why);
    if (figures_.left_out.size() > kMaxListed)
      text += fmt::format("    and {} more\n", figures_.left_out.size() - kMaxListed);
    return text;
  }

  std::string TableOf(const std::vector<ErrorRow>& rows) const {
    Table table;
    for (const std::size_t axis : figures_.rows)
      table.AddColumn(file_.axes()[axis].name, !file_.axes()[axis].IsText());
    table.AddColumn("x real time", true);
    table.AddColumn("ms per s", true);
    if (Pools()) table.AddColumn("5th .. 95th", true);
    table.AddColumn(name_, true);
    const bool has_floor = file_.Has(dataset_ + "_floor");
    if (has_floor) table.AddColumn("floor", true);
    if (has_floor) table.AddColumn("horizon, s", true);
    table.AddColumn("", false);
    for (const ErrorRow& row : rows) {
      std::vector<std::string> cells;
      for (std::size_t i = 0; i < figures_.rows.size(); ++i)
        cells.push_back(CoordinateText(file_.axes()[figures_.rows[i]], row.at[i]));
      cells.push_back(ShortNumber(row.RealTimeFactor()));
      cells.push_back(ShortNumber(row.Time()));
      if (Pools())
        cells.push_back(ShortNumber(Percentile(row.ms_per_s, 0.05)) + " .. " +
                        ShortNumber(Percentile(row.ms_per_s, 0.95)));
      cells.push_back(ScientificNumber(row.Error()));
      if (has_floor) cells.push_back(ScientificNumber(row.Floor()));
      if (has_floor) cells.push_back(ShortNumber(row.horizon));
      std::string mark = row.on_front ? "front" : "";
      if (row.IsBelowFloor()) mark += mark.empty() ? "below floor" : ", below floor";
      cells.push_back(std::move(mark));
      table.AddRow(std::move(cells));
    }
    return table.Text();
  }

  std::string PlotOf(const std::vector<ErrorRow>& rows) const {
    std::vector<PlotPoint> points;
    for (const ErrorRow& row : rows)
      if (row.Error() > 0) points.push_back({row.RealTimeFactor(), row.Error(), row.on_front});
    const std::string plot = LogPlot(points, "x real time", name_);
    return plot.empty() ? plot : "\n" + plot;
  }

  const store::ResultFile& file_;
  const std::string name_, dataset_;
  const ErrorFigures figures_;
};

}  // namespace

ShowText ShowError(const store::ResultFile& file, const ShowErrorOptions& options) {
  return ErrorTable(file, options).Text();
}

}  // namespace cdb::report
