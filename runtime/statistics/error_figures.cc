#include "runtime/statistics/error_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "compiler/schema/metrics.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/numbers.h"

namespace cdb::statistics {
namespace {

using Cell = store::ResultFile::Cell;

bool Lists(const std::vector<std::size_t>& axes, std::size_t axis) {
  return std::ranges::find(axes, axis) != axes.end();
}

/// True if `one` is at least as fast and as accurate.
bool Dominates(const ErrorRow& one, const ErrorRow& other) {
  return !one.row.is_void && one.ms_per_s.value <= other.ms_per_s.value &&
         one.Known() <= other.Known();
}

bool IsWithinNoise(const ErrorRow& one, const ErrorRow& other) {
  return one.time_interval.Overlaps(other.time_interval) &&
         one.PossibleErrors().Overlaps(other.PossibleErrors());
}

class Collector {
 public:
  Collector(const store::ResultFile& file, const ErrorOptions& options, CycleTimes& times)
      : file_(file), name_(options.error), dataset_("accuracy/" + options.error), times_(times) {
    CheckName();
    ChooseAxes(options);
    figures_.points = MeasuredPoints(file, options.only_sound);
  }

  ErrorFigures Figures() {
    for (const auto& [key, points] : PlacedPoints()) {
      ErrorRows& table = figures_.tables[key];
      table.matched = MatchRows(points, figures_.rows);
      for (Row& row : table.matched.rows) table.rows.push_back(RowOf(std::move(row)));
      table.matched.rows.clear();
      std::ranges::stable_sort(table.rows, {}, [](const ErrorRow& row) {
        return std::tuple(row.row.is_void, row.ms_per_s.value, row.Known());
      });
      MarkFront(table.rows);
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
      throw files::StoreError(
          "this file has no errors: its scenario has no accuracy { metrics … }, see `cdb doc "
          "accuracy`");
    const bool is_error = std::ranges::any_of(
        schema::Errors(), [&](const schema::ErrorInfo& error) { return error.name == name_; });
    if (!is_error || !file_.Has(dataset_))
      throw files::StoreError(
          fmt::format("there is no error '{}' in this file; there are {}", name_, names));
    if (!file_.Has("duration"))
      throw files::StoreError(
          "this file has no timings to plot errors against; add timing to `record` in the "
          "scenario");
  }

  /// All axes make rows, unless some are requested; seeds only on request.
  void ChooseAxes(const ErrorOptions& options) {
    std::vector<std::size_t>&rows = figures_.rows, &each = figures_.each, &seeds = figures_.seeds;
    for (const std::string& axis : options.each) each.push_back(FindAxis(file_, axis));
    for (const std::string& axis : options.by) rows.push_back(FindAxis(file_, axis));
    for (std::size_t i = 0; i < file_.axes().size(); ++i) {
      if (Lists(each, i) || Lists(rows, i)) continue;
      const plan::Axis& axis = file_.axes()[i];
      if (axis.parameter == "seed" || axis.name == "seed") {
        seeds.push_back(i);
      } else if (options.by.empty()) {
        rows.push_back(i);
      }
    }
    std::erase_if(rows, [&](std::size_t axis) { return Lists(each, axis); });
  }

  /// Points with an error and a time, by their coordinates on the axes `each`; the others are
  /// recorded as left out.
  std::map<Point, std::vector<const MeasuredPoint*>> PlacedPoints() {
    std::map<Point, const MeasuredPoint*> measured;
    for (const MeasuredPoint& point : figures_.points) measured[point.at] = &point;
    std::map<Point, std::vector<const MeasuredPoint*>> placed;
    for (const Cell& cell : AllCells(file_)) {
      if (file_.ReadStatus(cell) == store::Status::kSkipped) continue;
      const auto trouble = Trouble(file_, cell);
      if (trouble && file_.ReadStatus(cell) != store::Status::kMissing) ++figures_.bad_cells;
      if (cell.rep != 0) continue;
      const auto found = measured.find(cell.at);
      if (found == measured.end()) {
        figures_.left_out.push_back({cell.at, trouble.value_or("no value")});
      } else if (std::isnan(ErrorOf(*found->second)) || std::isnan(TimeOf(*found->second).value)) {
        const std::string why = file_.ReadText("accuracy/message", found->second->cells[0]);
        figures_.left_out.push_back({cell.at, !why.empty() ? why : trouble.value_or("no value")});
      } else {
        placed[Project(cell.at, figures_.each)].push_back(found->second);
        if (!found->second->IsSound())
          figures_.marked.push_back({cell.at, trouble.value_or(found->second->fault)});
      }
    }
    return placed;
  }

  /// Repeats have the same motion, and so the same errors.
  double ErrorOf(const MeasuredPoint& point) const {
    return file_.ReadReal(dataset_, point.cells[0]);
  }
  double ReadIfAny(const std::string& dataset, const MeasuredPoint& point) const {
    return file_.Has(dataset) ? file_.ReadReal(dataset, point.cells[0]) : kNone;
  }
  Estimate TimeOf(const MeasuredPoint& point) {
    const double timestep = file_.ReadReal("accuracy/timestep", point.cells[0]);
    return Scaled(times_.Of(point, measure::Phase::kStep).mean, 1e-6 / timestep);
  }

  ErrorRow RowOf(Row row) {
    std::vector<Estimate> times;
    std::map<Point, std::vector<double>> by_seed;
    std::vector<double> floors, of_seeds;
    ErrorRow made;
    for (const MeasuredPoint* point : row.points) {
      times.push_back(TimeOf(*point));
      by_seed[Project(point->at, figures_.seeds)].push_back(ErrorOf(*point));
      floors.push_back(ReadIfAny(dataset_ + "_floor", *point));
      made.horizon = std::fmin(made.horizon, ReadIfAny("accuracy/horizon", *point));
    }
    for (const auto& [seed, errors] : by_seed) of_seeds.push_back(Mean(errors));
    const Bootstrap over_seeds(of_seeds.size());
    const Estimate error = over_seeds.MeanEstimate(of_seeds);
    figures_.seed_count = std::max(figures_.seed_count, of_seeds.size());
    made.row = std::move(row);
    made.ms_per_s = MeanOf(times);
    made.time_interval = times_.IntervalOf(made.ms_per_s);
    made.error = error.value;
    made.error_interval = over_seeds.IntervalOf(error);
    made.floor = Mean(floors);
    return made;
  }

  const store::ResultFile& file_;
  const std::string name_, dataset_;
  CycleTimes& times_;
  ErrorFigures figures_;
};

}  // namespace

double ErrorRow::Known() const { return std::fmax(error, floor); }

Interval ErrorRow::PossibleErrors() const {
  const double beside = std::isnan(floor) ? 0 : floor;
  return {std::fmin(error, error_interval.low) - beside,
          std::fmax(error, error_interval.high) + beside};
}

void MarkFront(std::vector<ErrorRow>& rows) {
  double least = std::numeric_limits<double>::infinity();
  for (ErrorRow& row : rows) {
    row.on_front = !row.row.is_void && row.Known() < least;
    if (row.on_front) least = row.Known();
  }
  for (ErrorRow& row : rows)
    row.is_tie = !row.row.is_void && !row.on_front &&
                 std::ranges::none_of(rows, [&row](const ErrorRow& other) {
                   return &other != &row && Dominates(other, row) && !IsWithinNoise(other, row);
                 });
}

ErrorFigures CollectErrors(const store::ResultFile& file, const ErrorOptions& options,
                           CycleTimes& times) {
  return Collector(file, options, times).Figures();
}

}  // namespace cdb::statistics
