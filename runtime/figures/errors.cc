#include "runtime/figures/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <tuple>
#include <utility>

#include "runtime/figures/coverage.h"

namespace cdb::figures {
namespace {

bool Lists(const std::vector<std::size_t>& axes, std::size_t axis) {
  return std::ranges::find(axes, axis) != axes.end();
}

/// True if `one` is at least as fast and as accurate.
bool Dominates(const ErrorRow& one, const ErrorRow& other) {
  return one.MayBeOnFront() && one.ms_per_s.value <= other.ms_per_s.value &&
         one.Known() <= other.Known();
}

bool IsWithinNoise(const ErrorRow& one, const ErrorRow& other) {
  return one.time_interval.Overlaps(other.time_interval) &&
         one.PossibleErrors().Overlaps(other.PossibleErrors());
}

class Collector {
 public:
  Collector(const Model& model, const ErrorOptions& options)
      : model_(model), file_(model.file()), name_(options.error) {
    CheckName();
    ChooseAxes(options);
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
      if (figures_.has_fronts) MarkFront(table.rows);
    }
    return std::move(figures_);
  }

 private:
  void CheckName() {
    std::vector<std::string_view> names;
    for (const schema::ErrorInfo& error : schema::Errors())
      if (file_.Has(fmt::format("accuracy/{}", error.name))) names.push_back(error.name);
    if (names.empty())
      throw files::StoreError(
          "this file has no errors: its scenario has no accuracy { metrics … }, see `cdb doc "
          "accuracy`");
    needs_truth_ = std::ranges::any_of(schema::Errors(), [&](const schema::ErrorInfo& error) {
      return error.name == name_ && error.needs_truth;
    });
    if (std::ranges::find(names, name_) == names.end())
      throw files::StoreError(fmt::format("there is no error '{}' in this file; there are {}",
                                          name_, fmt::join(names, ", ")));
    if (!model_.HasTimes())
      throw files::StoreError(
          "this file has no timings to plot errors against; add timing to `record` in the "
          "scenario");
  }

  /// All axes make rows, unless some are requested; seeds only on request. By default each scene
  /// has a table, unless the file sweeps nothing but scenes.
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
    const std::vector<std::size_t>& scenes = model_.scene_axes();
    const auto is_scene = [&](std::size_t axis) { return Lists(scenes, axis); };
    if (options.by.empty() && options.each.empty() && !std::ranges::all_of(rows, is_scene)) {
      std::ranges::copy_if(rows, std::back_inserter(each), is_scene);
      std::erase_if(rows, is_scene);
    }
    figures_.has_fronts = std::ranges::none_of(rows, is_scene);
  }

  /// Points with an error and a time, by their coordinates on the axes `each`; the others are
  /// recorded as left out.
  std::map<Point, std::vector<const MeasuredPoint*>> PlacedPoints() {
    std::map<Point, std::vector<const MeasuredPoint*>> placed;
    for (const Point& at : AllPoints(file_)) {
      if (file_.ReadStatus({at, 0}) == results::Status::kSkipped) continue;
      const MeasuredPoint* point = model_.Find(at);
      if (point == nullptr) {
        figures_.left_out.push_back({at, TroubleAt(at).value_or("no value")});
      } else if (std::isnan(model_.ErrorOf(*point, name_)) ||
                 std::isnan(model_.MsPerSecondOf(*point).value)) {
        const std::string why = file_.ReadText("accuracy/message", point->cells[0]);
        figures_.left_out.push_back({at, !why.empty() ? why : TroubleAt(at).value_or("no value")});
      } else {
        placed[Project(at, figures_.each)].push_back(point);
        if (!point->IsSound())
          figures_.marked.push_back({at, TroubleAt(at).value_or(point->fault)});
      }
    }
    return placed;
  }

  /// Of the first repeat that was run, or of one that was not.
  std::optional<std::string> TroubleAt(const Point& at) const {
    const std::vector<Cell> cells = CellsThatRan(file_, at);
    return Trouble(file_, cells.empty() ? Cell{at, 0} : cells[0]);
  }

  ErrorRow RowOf(Row row) {
    std::vector<Estimate> times;
    std::map<Point, std::vector<double>> by_seed;
    std::vector<double> floors, of_seeds;
    ErrorRow made;
    for (const MeasuredPoint* point : row.points) {
      times.push_back(model_.MsPerSecondOf(*point));
      by_seed[Project(point->at, figures_.seeds)].push_back(model_.ErrorOf(*point, name_));
      floors.push_back(model_.ErrorOf(*point, name_ + "_floor"));
      made.horizon = std::fmin(made.horizon, model_.ErrorOf(*point, "horizon"));
    }
    for (const auto& [seed, errors] : by_seed) of_seeds.push_back(Mean(errors));
    const Bootstrap over_seeds(of_seeds.size());
    const Estimate error = over_seeds.MeanEstimate(of_seeds);
    figures_.seed_count = std::max(figures_.seed_count, of_seeds.size());
    made.unsound = UnsoundText(file_, row);
    if (needs_truth_)
      for (const MeasuredPoint* point : row.points)
        if (made.unsound.empty()) made.unsound = model_.ReferenceFaultOf(*point);
    made.row = std::move(row);
    made.ms_per_s = MeanOf(times);
    made.time_interval = model_.times().IntervalOf(made.ms_per_s);
    made.error = error.value;
    made.error_interval = over_seeds.IntervalOf(error);
    made.floor = Mean(floors);
    return made;
  }

  const Model& model_;
  const results::ResultFile& file_;
  const std::string name_;
  bool needs_truth_ = false;
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
    row.on_front = row.MayBeOnFront() && row.Known() < least;
    if (row.on_front) least = row.Known();
  }
  for (ErrorRow& row : rows)
    row.is_tie = row.MayBeOnFront() && !row.on_front &&
                 std::ranges::none_of(rows, [&row](const ErrorRow& other) {
                   return &other != &row && Dominates(other, row) && !IsWithinNoise(other, row);
                 });
}

std::vector<std::pair<const ErrorFigures::LeftOut*, std::size_t>> ByReason(
    const std::vector<ErrorFigures::LeftOut>& points) {
  std::vector<std::pair<const ErrorFigures::LeftOut*, std::size_t>> reasons;
  for (const ErrorFigures::LeftOut& point : points) {
    const auto same =
        std::ranges::find_if(reasons, [&](const auto& of) { return of.first->why == point.why; });
    if (same == reasons.end()) {
      reasons.emplace_back(&point, 1);
    } else {
      ++same->second;
    }
  }
  return reasons;
}

std::vector<std::string> ReferenceTexts(const Model& model) {
  std::vector<std::string> texts;
  std::map<std::string, std::size_t> faults;
  for (const results::ReferenceTrouble& trouble : model.reference_troubles())
    if (trouble.is_unsound)
      ++faults[trouble.text];
    else
      texts.push_back("A reference is missing: " + trouble.text);
  for (const auto& [fault, count] : faults)
    texts.push_back(fmt::format(
        "{} not sound: {}. What is compared with {} has no known error, and is on no front "
        "(cdb doc accuracy).",
        count == 1 ? "A reference is" : fmt::format("{} references are", count), fault,
        count == 1 ? "it" : "them"));
  return texts;
}

ErrorFigures CollectErrors(const Model& model, const ErrorOptions& options) {
  return Collector(model, options).Figures();
}

std::vector<std::pair<const schema::ErrorInfo*, ErrorFigures>> CollectAllErrors(
    const Model& model) {
  std::vector<std::pair<const schema::ErrorInfo*, ErrorFigures>> all;
  if (!model.HasTimes()) return all;
  for (const schema::ErrorInfo& error : schema::Errors()) {
    const std::string name(error.name);
    if (model.file().Has("accuracy/" + name))
      all.emplace_back(&error, CollectErrors(model, {.error = name, .by = {}, .each = {}}));
  }
  return all;
}

}  // namespace cdb::figures
