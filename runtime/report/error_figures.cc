#include "runtime/report/error_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "compiler/schema/metrics.h"
#include "runtime/report/cells.h"
#include "runtime/report/numbers.h"

namespace cdb::report {
namespace {

using Cell = store::ResultFile::Cell;

/// The fastest first; of those on the front, each is more accurate than all before it.
void MarkFront(std::vector<ErrorRow>& rows) {
  std::ranges::stable_sort(rows, {},
                           [](const ErrorRow& row) { return std::pair(row.Time(), row.Known()); });
  double least = std::numeric_limits<double>::infinity();
  for (ErrorRow& row : rows) {
    row.on_front = row.Known() < least;
    least = std::min(least, row.Known());
  }
}

Point Project(const Point& at, const std::vector<std::size_t>& axes) {
  Point part;
  for (const std::size_t axis : axes) part.push_back(at[axis]);
  return part;
}

class Collector {
 public:
  Collector(const store::ResultFile& file, const ShowErrorOptions& options)
      : file_(file), name_(options.error), dataset_("accuracy/" + options.error) {
    CheckName();
    std::vector<std::size_t>&rows = figures_.rows, &each = figures_.each;
    for (const std::string& axis : options.each) each.push_back(FindAxis(file, axis));
    for (const std::string& axis : options.by) rows.push_back(FindAxis(file, axis));
    if (rows.empty())
      for (std::size_t i = 0; i < file.axes().size(); ++i) rows.push_back(i);
    std::erase_if(rows,
                  [&](std::size_t axis) { return std::ranges::find(each, axis) != each.end(); });
  }

  ErrorFigures Figures() {
    Collect();
    for (auto& [key, rows_of_key] : points_) {
      std::vector<ErrorRow>& rows = figures_.tables[key];
      for (auto& [at, row] : rows_of_key) {
        std::ranges::sort(row.ms_per_s);
        rows.push_back(std::move(row));
      }
      MarkFront(rows);
    }
    return std::move(figures_);
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
        figures_.bad_cells += status == store::Status::kMissing ? 0 : 1;
        continue;
      }
      const std::vector<double> steps = file_.ReadDuration(measure::Phase::kStep, cell);
      const double ns = Mean(steps);
      if (!steps.empty() && std::isfinite(ns))
        ms_per_s.push_back(ns * 1e-6 / file_.ReadReal("accuracy/timestep", cell));
      // Repeats go the same way, so that errors are alike.
      error = file_.ReadReal(dataset_, cell);
      if (file_.Has(dataset_ + "_floor")) floor = file_.ReadReal(dataset_ + "_floor", cell);
      if (file_.Has("accuracy/horizon")) horizon = file_.ReadReal("accuracy/horizon", cell);
      if (std::isnan(error)) why = file_.ReadText("accuracy/message", cell);
    }
    if (ms_per_s.empty() || std::isnan(error)) {
      figures_.left_out.push_back({at, why.empty() ? "no value" : why});
      return;
    }
    ErrorRow& row = points_[Project(at, figures_.each)][Project(at, figures_.rows)];
    row.at = Project(at, figures_.rows);
    row.ms_per_s.insert(row.ms_per_s.end(), ms_per_s.begin(), ms_per_s.end());
    row.errors.push_back(error);
    row.floors.push_back(floor);
    row.horizon = std::fmin(row.horizon, horizon);
  }

  const store::ResultFile& file_;
  const std::string name_, dataset_;
  ErrorFigures figures_;
  std::map<Point, std::map<Point, ErrorRow>> points_;
};

}  // namespace

double ErrorRow::Error() const { return Mean(errors); }
double ErrorRow::Floor() const { return Mean(floors); }
double ErrorRow::Known() const { return std::fmax(Error(), Floor()); }

ErrorFigures CollectErrors(const store::ResultFile& file, const ShowErrorOptions& options) {
  return Collector(file, options).Figures();
}

}  // namespace cdb::report
