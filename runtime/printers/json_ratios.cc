// Ratios between detectors, and fronts of error against run time, for results documents.
#include <algorithm>
#include <utility>

#include "compiler/plan/coordinates.h"
#include "runtime/figures/errors.h"
#include "runtime/printers/json_parts.h"

namespace cdb::printers {
namespace {

using figures::Comparison;
using figures::Model;
using measure::Phase;

Json ColumnsOf(const Comparison& comparison, Phase phase) {
  const Model& model = *comparison.model;
  const std::size_t n = model.grid().size();
  Json value(n, nullptr), low(n, nullptr), high(n, nullptr), is_matched(n, false);
  for (const figures::ComparedPoint& point : comparison.points)
    for (std::size_t i = 0; i < point.values.size(); ++i) {
      const auto ratio = comparison.RatioAt(point, i, phase);
      if (!ratio) continue;
      const std::size_t row = model.IndexOf(point.values[i]->at);
      const figures::Interval interval = model.times().IntervalOf(*ratio);
      value[row] = ModelNumber(model, ratio->value);
      low[row] = ModelNumber(model, interval.low);
      high[row] = ModelNumber(model, interval.high);
      is_matched[row] = point.is_matched;
    }
  return {{"value", std::move(value)},
          {"low", std::move(low)},
          {"high", std::move(high)},
          {"is_matched", std::move(is_matched)}};
}

/// The geometric mean over the matched points.
Json MeanOf(const Comparison& comparison, std::size_t detector, Phase phase) {
  const Model& model = *comparison.model;
  const auto all = figures::MeanRatioOf(comparison, detector, phase);
  const bool has_mean = all && all->is_matched;
  const auto number = [&](double value) {
    return has_mean ? ModelNumber(model, value) : Json(nullptr);
  };
  const figures::MeanRatio none = {};
  const figures::MeanRatio& of = has_mean ? *all : none;
  return {{"detector", plan::CoordinateLabel(model.axis(comparison.axis), detector)},
          {"value", number(of.mean.value)},
          {"low", number(of.interval.low)},
          {"high", number(of.interval.high)},
          {"least", number(of.least)},
          {"most", number(of.most)},
          {"cells", of.cells},
          {"of", comparison.points.size()}};
}

Json FrontRow(const Model& model, const figures::ErrorFigures& figures,
              const figures::ErrorRow& row) {
  Json points = Json::array();
  for (const figures::MeasuredPoint* point : row.row.points)
    points.push_back(model.IndexOf(point->at));
  const auto number = [&](double value) { return ModelNumber(model, value); };
  return {{"at", PlaceJson(model, figures.rows, row.row.at)},
          {"mark", row.row.mark},
          {"ms_per_s", number(row.ms_per_s.value)},
          {"low", number(row.time_interval.low)},
          {"high", number(row.time_interval.high)},
          {"error", number(row.error)},
          {"error_low", number(row.error_interval.low)},
          {"error_high", number(row.error_interval.high)},
          {"floor", number(row.floor)},
          {"on_front", row.on_front},
          {"is_tie", row.is_tie},
          {"is_void", row.row.is_void},
          {"points", std::move(points)}};
}

}  // namespace

Json DocumentRatios(const Model& model, const Comparison* comparison) {
  if (comparison == nullptr) return nullptr;
  const plan::Axis& detectors = model.axis(comparison->axis);
  Json all = {{"baseline", plan::CoordinateLabel(detectors, comparison->baseline)},
              {"cells", comparison->points.size()},
              {"matched", comparison->MatchedCount()},
              {"is_void", comparison->is_void}};
  for (const Phase phase : DocumentedPhases(model)) {
    const std::string name = figures::PhaseName(phase);
    Json columns = ColumnsOf(*comparison, phase);
    all["phases"][name] = IsLarge(model) ? FoldColumns(std::move(columns)) : std::move(columns);
    all["means"][name] = JsonColumn(detectors.values.size(), [&](std::size_t detector) {
      return MeanOf(*comparison, detector, phase);
    });
  }
  return all;
}

Json DocumentFronts(const Model& model) {
  Json fronts = Json::array();
  for (const auto& [error, figures] : figures::CollectAllErrors(model))
    for (const auto& [key, table] : figures.tables) {
      Json rows = Json::array();
      for (const figures::ErrorRow& row : table.rows) rows.push_back(FrontRow(model, figures, row));
      fronts.push_back({{"error", error->name},
                        {"unit", error->unit},
                        {"label", error->doc},
                        {"each", PlaceJson(model, figures.each, key)},
                        {"seeds", figures.seed_count},
                        {"rows", std::move(rows)}});
    }
  return fronts;
}

}  // namespace cdb::printers
