// Pooled rows for the page, which draws them and computes nothing.
#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

#include "compiler/plan/plan.h"
#include "runtime/figures/bootstrap.h"
#include "runtime/figures/errors.h"
#include "runtime/printers/json_points.h"

namespace cdb::printers {
namespace {

using figures::Comparison;
using figures::Estimate;
using figures::Model;
using figures::Point;
using figures::Row;
using protocol::Phase;

constexpr std::size_t kMostRows = 20'000, kMostTables = 256;

/// The sets of axes with several values, without the one of all of them, the smallest first.
std::vector<std::vector<std::size_t>> KeptAxes(const Model& model) {
  std::vector<std::size_t> varied;
  for (const std::size_t axis : figures::AllAxes(model.file()))
    if (model.axis(axis).values.size() > 1) varied.push_back(axis);
  std::vector<std::vector<std::size_t>> sets;
  if (varied.empty()) return sets;
  const std::uint64_t all = (std::uint64_t{1} << std::min<std::size_t>(varied.size(), 12)) - 1;
  for (std::uint64_t bits = 0; bits < all; ++bits) {
    std::vector<std::size_t>& set = sets.emplace_back();
    for (std::size_t i = 0; i < varied.size(); ++i)
      if ((bits >> i & 1) != 0) set.push_back(varied[i]);
  }
  std::ranges::stable_sort(sets, {}, [](const auto& set) { return set.size(); });
  if (sets.size() > kMostTables) sets.resize(kMostTables);
  return sets;
}

class PooledTable {
 public:
  PooledTable(const Model& model, const Comparison* comparison,
              const std::vector<std::size_t>& axes)
      : model_(model),
        comparison_(comparison),
        axes_(axes),
        rows_(figures::MatchRows(model.points(), axes)) {
    for (const figures::GridPoint& point : model.grid())
      places_[figures::Project(point.at, axes)].push_back(&point);
  }

  std::size_t size() const { return rows_.rows.size() + places_.size(); }

  Json Made() const {
    return {{"axes", axes_},
            {"is_unmatched", rows_.is_unmatched},
            {"rows", RowColumns()},
            {"places", PlaceColumns()}};
  }

 private:
  template <typename Of>
  Json Column(Of of) const {
    return JsonColumn(rows_.rows.size(), [&](std::size_t i) -> Json { return of(rows_.rows[i]); });
  }
  template <typename Of>
  Json Numbers(Of of) const {
    return Column([&](const Row& row) { return ModelNumber(model_, of(row)); });
  }

  Json RowColumns() const {
    Json rows = {{"at", Column([](const Row& row) { return row.at; })},
                 {"mark", Column([](const Row& row) { return row.mark; })},
                 {"is_void", Column([](const Row& row) { return row.is_void; })},
                 {"points", Column([](const Row& row) { return row.points.size(); })},
                 {"own", Column([](const Row& row) { return row.own; })}};
    if (model_.HasTimes())
      for (const Phase phase : DocumentedPhases(model_))
        rows["times"][figures::PhaseName(phase)] = TimesOf(phase);
    if (IsLarge(model_)) return rows;
    for (const std::string& series : DocumentedCounts(model_))
      rows["counts"][series] = Numbers([&](const Row& row) { return model_.CountOf(row, series); });
    for (const std::string& name : DocumentedMemory(model_))
      rows["memory"][name] = Numbers([&](const Row& row) { return model_.MemoryOf(row, name); });
    return rows;
  }

  Json TimesOf(Phase phase) const {
    Json value = Json::array(), low = Json::array(), high = Json::array();
    for (const Row& row : rows_.rows) {
      const Estimate mean = model_.TimeOf(row, phase);
      const figures::Interval interval = model_.times().IntervalOf(mean);
      value.push_back(ModelNumber(model_, mean.value));
      low.push_back(ModelNumber(model_, interval.low));
      high.push_back(ModelNumber(model_, interval.high));
    }
    Json times = {{"mean", std::move(value)}, {"low", std::move(low)}, {"high", std::move(high)}};
    if (IsLarge(model_)) return times;
    for (const auto& [name, statistic] : kDocumentedStatistics)
      times[name] = Numbers([&, statistic = statistic](const Row& row) {
        std::vector<double> of_points;
        for (const figures::MeasuredPoint* point : row.points)
          of_points.push_back(model_.times().StatisticOf(*point, phase, statistic));
        return figures::Mean(of_points);
      });
    return times;
  }

  Json PlaceColumns() const {
    Json at = Json::array(), points = Json::array(), verdict = Json::array(),
         first_bad_cycle = Json::array();
    for (const auto& [place, here] : places_) {
      figures::Ending worst;
      for (const figures::GridPoint* point : here) worst = figures::WorseOf(worst, point->ending);
      at.push_back(place);
      points.push_back(here.size());
      verdict.push_back(worst.Word());
      first_bad_cycle.push_back(CycleOrNull(worst));
    }
    Json places = {{"at", std::move(at)},
                   {"points", std::move(points)},
                   {"verdict", std::move(verdict)},
                   {"first_bad_cycle", std::move(first_bad_cycle)}};
    if (comparison_ == nullptr || std::ranges::find(axes_, comparison_->axis) == axes_.end())
      return places;
    for (const Phase phase : DocumentedPhases(model_))
      places["ratios"][figures::PhaseName(phase)] = RatiosOf(phase);
    return places;
  }

  /// The mean ratio of the detector of each place, over its points.
  Json RatiosOf(Phase phase) const {
    std::vector<std::size_t> others = axes_;
    std::erase(others, comparison_->axis);
    // Compared points are without the axis of detectors.
    for (std::size_t& axis : others) axis -= axis > comparison_->axis ? 1 : 0;
    std::map<Point, std::vector<const figures::ComparedPoint*>> compared;
    for (const figures::ComparedPoint& point : comparison_->points)
      compared[figures::Project(point.at, others)].push_back(&point);
    const auto own =
        static_cast<std::size_t>(std::ranges::find(axes_, comparison_->axis) - axes_.begin());
    Json columns = Json::object();
    for (const auto& [place, here] : places_) {
      const auto found = compared.find(figures::Without(place, own));
      const auto mean = found == compared.end()
                            ? std::nullopt
                            : figures::MeanRatioOf(*comparison_, found->second, place[own], phase);
      const auto add = [&](const char* name, double value) {
        columns[name].push_back(mean ? ModelNumber(model_, value) : Json(nullptr));
      };
      const figures::MeanRatio none = {};
      const figures::MeanRatio& of = mean ? *mean : none;
      add("value", of.mean.value);
      add("low", of.interval.low);
      add("high", of.interval.high);
      add("least", of.least);
      add("most", of.most);
      columns["cells"].push_back(of.cells);
      columns["of"].push_back(of.of);
      columns["is_matched"].push_back(of.is_matched);
      columns["is_void"].push_back(of.is_void);
    }
    return columns;
  }

  const Model& model_;
  const Comparison* comparison_;
  const std::vector<std::size_t>& axes_;
  const figures::Rows rows_;
  std::map<Point, std::vector<const figures::GridPoint*>> places_;
};

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
          {"unsound", row.unsound},
          {"is_void", row.row.is_void},
          {"points", std::move(points)}};
}

}  // namespace

Json DocumentPooled(const Model& model, const Comparison* comparison) {
  Json all = Json::array();
  std::size_t left = kMostRows;
  for (const std::vector<std::size_t>& axes : KeptAxes(model)) {
    const PooledTable table(model, comparison, axes);
    if (table.size() > left) continue;
    left -= table.size();
    all.push_back(table.Made());
  }
  return all;
}

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
  for (const auto& [error, figures] : figures::CollectAllErrors(model)) {
    const std::vector<figures::ErrorOrder> fits = figures::OrdersOf(model, *error, figures);
    for (const auto& [key, table] : figures.tables) {
      Json rows = Json::array(), orders = Json::array();
      for (const figures::ErrorRow& row : table.rows) rows.push_back(FrontRow(model, figures, row));
      for (const figures::ErrorOrder& order : fits)
        if (order.scene == key)
          orders.push_back({{"at", PlaceJson(model, order.axes, order.at)},
                            {"p", ModelNumber(model, order.fit.p)},
                            {"low", ModelNumber(model, order.fit.interval.low)},
                            {"high", ModelNumber(model, order.fit.interval.high)}});
      fronts.push_back({{"error", error->name},
                        {"unit", error->unit},
                        {"label", error->doc},
                        {"each", PlaceJson(model, figures.each, key)},
                        {"seeds", figures.seed_count},
                        {"orders", std::move(orders)},
                        {"rows", std::move(rows)}});
    }
  }
  return fronts;
}

}  // namespace cdb::printers
