#include "runtime/document/comparison.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "compiler/schema/metrics.h"
#include "runtime/conclusions/scene_axes.h"
#include "runtime/report/show_ratios.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/detector_ratios.h"
#include "runtime/statistics/error_figures.h"
#include "runtime/terminal/table.h"

namespace cdb::document {
namespace {

using measure::Phase;

class RatioColumns {
 public:
  RatioColumns(const DocumentSource& source, std::size_t axis,
               const statistics::Comparison& comparison)
      : source_(source), axis_(axis), comparison_(comparison) {}

  Json All() const {
    const plan::Axis& detectors = source_.file().axes()[axis_];
    Json all = {{"baseline", terminal::CoordinateText(detectors, comparison_.baseline)},
                {"cells", comparison_.points.size()},
                {"matched", comparison_.MatchedCount()},
                {"is_void", comparison_.is_void}};
    for (std::size_t i = 0; i < measure::kPhaseCount; ++i) {
      const auto phase = static_cast<Phase>(i);
      if (source_.IsLarge() && phase != Phase::kStep && phase != Phase::kDetect) continue;
      const std::string name(measure::PhaseNames()[i]);
      all["phases"][name] = source_.IsLarge() ? FoldColumns(ColumnsOf(phase)) : ColumnsOf(phase);
      all["means"][name] = JsonColumn(
          detectors.values.size(), [&](std::size_t detector) { return MeanOf(detector, phase); });
    }
    return all;
  }

 private:
  Json ColumnsOf(Phase phase) const {
    const std::size_t n = source_.points().size();
    Json value(n, nullptr), low(n, nullptr), high(n, nullptr), is_matched(n, false);
    for (const statistics::ComparedPoint& point : comparison_.points)
      for (std::size_t i = 0; i < point.detectors.size(); ++i) {
        const auto ratio = statistics::RatioAt(comparison_, point, i, phase, source_.times());
        if (!ratio) continue;
        const std::size_t row = source_.IndexOf(point.detectors[i]->at);
        const statistics::Interval interval = source_.times().IntervalOf(*ratio);
        value[row] = source_.Number(ratio->value);
        low[row] = source_.Number(interval.low);
        high[row] = source_.Number(interval.high);
        is_matched[row] = point.is_matched;
      }
    return {{"value", std::move(value)},
            {"low", std::move(low)},
            {"high", std::move(high)},
            {"is_matched", std::move(is_matched)}};
  }

  /// The geometric mean over the matched points.
  Json MeanOf(std::size_t detector, Phase phase) const {
    const std::vector<statistics::Estimate> ratios =
        statistics::MatchedRatios(comparison_, detector, phase, source_.times());
    Json mean = {{"detector", terminal::CoordinateText(source_.file().axes()[axis_], detector)},
                 {"value", nullptr},
                 {"low", nullptr},
                 {"high", nullptr},
                 {"least", nullptr},
                 {"most", nullptr},
                 {"cells", ratios.size()},
                 {"of", comparison_.points.size()}};
    if (ratios.empty()) return mean;
    const statistics::Estimate all = statistics::GeometricMeanOf(ratios);
    const statistics::Interval interval = source_.times().IntervalOf(all);
    const auto [least, most] = std::ranges::minmax(ratios, {}, &statistics::Estimate::value);
    mean["value"] = source_.Number(all.value);
    mean["low"] = source_.Number(interval.low);
    mean["high"] = source_.Number(interval.high);
    mean["least"] = source_.Number(least.value);
    mean["most"] = source_.Number(most.value);
    return mean;
  }

  const DocumentSource& source_;
  const std::size_t axis_;
  const statistics::Comparison& comparison_;
};

/// The axis of detectors, if they can be compared.
std::optional<std::size_t> ComparedAxis(const DocumentSource& source) {
  const auto axis = statistics::DetectorAxis(source.file());
  if (!axis || source.file().axes()[*axis].values.size() < 2 || !source.HasTimes() ||
      source.measured().empty())
    return std::nullopt;
  return axis;
}

Json FrontRow(const DocumentSource& source, const statistics::ErrorFigures& figures,
              const statistics::ErrorRow& row) {
  Json points = Json::array();
  for (const statistics::MeasuredPoint* point : row.row.points)
    points.push_back(source.IndexOf(point->at));
  return {{"at", source.Place(figures.rows, row.row.at)},
          {"mark", row.row.mark},
          {"ms_per_s", source.Number(row.ms_per_s.value)},
          {"low", source.Number(row.time_interval.low)},
          {"high", source.Number(row.time_interval.high)},
          {"error", source.Number(row.error)},
          {"error_low", source.Number(row.error_interval.low)},
          {"error_high", source.Number(row.error_interval.high)},
          {"floor", source.Number(row.floor)},
          {"on_front", row.on_front},
          {"is_tie", row.is_tie},
          {"is_void", row.row.is_void},
          {"points", std::move(points)}};
}

void AddFronts(const DocumentSource& source, const statistics::ErrorFigures& figures,
               const schema::ErrorInfo& error, Json& fronts) {
  for (const auto& [key, table] : figures.tables) {
    Json rows = Json::array();
    for (const statistics::ErrorRow& row : table.rows)
      rows.push_back(FrontRow(source, figures, row));
    fronts.push_back({{"error", error.name},
                      {"unit", error.unit},
                      {"label", error.doc},
                      {"each", source.Place(figures.each, key)},
                      {"seeds", figures.seed_count},
                      {"rows", std::move(rows)}});
  }
}

}  // namespace

Json DocumentDetectorAxis(const DocumentSource& source) {
  const auto axis = statistics::DetectorAxis(source.file());
  return axis ? Json(*axis) : Json(nullptr);
}

Json DocumentRatios(const DocumentSource& source, const std::string& baseline) {
  const auto asked = report::FindBaseline(source.file(), baseline);
  const auto axis = ComparedAxis(source);
  if (!axis) return nullptr;
  const statistics::Comparison comparison =
      statistics::CompareDetectors(source.file(), source.measured(), *axis, asked);
  return RatioColumns(source, *axis, comparison).All();
}

Json DocumentFronts(const DocumentSource& source, bool only_sound) {
  Json fronts = Json::array();
  if (!source.HasTimes()) return fronts;
  const store::ResultFile& file = source.file();
  statistics::ErrorOptions options;
  options.only_sound = only_sound;
  for (const std::size_t axis : conclusions::SceneAxes(file))
    options.each.push_back(file.axes()[axis].name);
  for (const schema::ErrorInfo& error : schema::Errors()) {
    options.error = error.name;
    if (!file.Has("accuracy/" + options.error)) continue;
    AddFronts(source, statistics::CollectErrors(file, options, source.times()), error, fronts);
  }
  return fronts;
}

}  // namespace cdb::document
