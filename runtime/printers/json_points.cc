// The axes and points of a results document.

#include "runtime/printers/json_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/schema.h"
#include "runtime/figures/bootstrap.h"
#include "runtime/figures/coverage.h"
#include "runtime/figures/model.h"
#include "runtime/figures/steady/steady_state.h"
#include "runtime/printers/show.h"

namespace cdb::printers {
namespace {

using figures::Estimate;
using figures::GridPoint;
using figures::MeasuredPoint;

struct PhaseWords {
  std::string_view label, definition;
};
/// In the order of protocol::Phase.
constexpr std::array<PhaseWords, protocol::kPhaseCount> kPhaseWords = {{
    {"broad phase", "Boxes are updated; overlapping pairs of boxes are added and removed."},
    {"narrow phase", "Contacts of the pairs are computed, and manifolds refreshed."},
    {"collision detection", "Broad and narrow phase."},
    {"solver",
     "Islands are built from the manifolds; contacts are set up and solved; gravity and applied "
     "forces become velocity."},
    {"integration", "Positions and orientations are updated, with the sweeps of ccd."},
    {"whole step",
     "The whole cycle, including parts outside of the other phases, such as predicted poses and "
     "sleeping."},
}};

struct AxisLabel {
  std::string_view parameter, label;
};
constexpr AxisLabel kAxisLabels[] = {
    {"quantity", "number of objects"},   {"timestep", "time step"},
    {"type", "type of object"},          {"size", "size of an object"},
    {"iterations", "solver iterations"}, {"side", "side of the world"},
};

/// `quantity` of `objects.quantity`.
std::string KindOf(const plan::Axis& axis) {
  const auto dot = axis.parameter.rfind('.');
  return dot == std::string::npos ? axis.parameter : axis.parameter.substr(dot + 1);
}

std::string DocOf(const plan::Axis& axis) {
  for (const schema::Parameter& parameter : schema::Schema())
    if (parameter.FullName() == axis.parameter) return std::string(parameter.doc);
  return {};
}

class PointColumns {
 public:
  explicit PointColumns(const figures::Model& model)
      : model_(model), file_(model.file()), points_(model.grid()) {}

  Json All() const {
    Json columns = Json::object();
    AddFacts(columns);
    if (model_.HasTimes()) AddTimes(columns);
    if (!IsLarge(model_)) AddCounts(columns);
    if (!IsLarge(model_)) AddQueries(columns);
    if (!IsLarge(model_)) AddCounters(columns);
    AddErrors(columns);
    Json all = {{"at", IsLarge(model_) ? FlatIndices() : Column([](const GridPoint& point) -> Json {
                   return point.at;
                 })}};
    all.update(IsLarge(model_) ? FoldColumns(std::move(columns)) : columns);
    return all;
  }

 private:
  template <typename Of>
  Json Column(Of of) const {
    return JsonColumn(points_.size(), [&](std::size_t i) -> Json { return of(points_[i]); });
  }
  /// Values for points with cycles; null for the others.
  template <typename Of>
  Json MeasuredColumn(Of of) const {
    return Column([&](const GridPoint& point) -> Json {
      if (point.measured == nullptr) return nullptr;
      return ModelNumber(model_, of(*point.measured));
    });
  }

  /// `{"grid": [[first, count], …]}`: runs of indices, the last axis fastest.
  Json FlatIndices() const {
    Json ranges = Json::array();
    for (const GridPoint& point : points_) {
      std::size_t flat = 0;
      for (std::size_t i = 0; i < point.at.size(); ++i)
        flat = flat * file_.axes()[i].values.size() + point.at[i];
      if (!ranges.empty() &&
          ranges.back()[0].get<std::size_t>() + ranges.back()[1].get<std::size_t>() == flat) {
        ranges.back()[1] = ranges.back()[1].get<std::size_t>() + 1;
      } else {
        ranges.push_back({flat, 1});
      }
    }
    return {{"grid", std::move(ranges)}};
  }

  void AddFacts(Json& all) const {
    all["mark"] = Column([](const GridPoint& point) -> Json { return point.Mark(); });
    all["is_void"] = Column([](const GridPoint& point) -> Json { return point.IsVoid(); });
    all["repeats"] = Column([](const GridPoint& point) -> Json {
      return point.measured == nullptr ? 0 : point.measured->cells.size();
    });
    all["verdict"] = Column([](const GridPoint& point) -> Json { return point.ending.Word(); });
    all["criterion"] = Column([](const GridPoint& point) -> Json {
      const std::string& series = point.ending.judgement.criterion;
      return series.empty() ? Json(nullptr) : Json(series);
    });
    all["first_bad_cycle"] =
        Column([](const GridPoint& point) { return CycleOrNull(point.ending); });
    const auto count = [](double value) {
      return std::isfinite(value) && value >= 0 ? Json(static_cast<std::int64_t>(value))
                                                : Json(nullptr);
    };
    all["bad_objects"] = Column([&](const GridPoint& point) {
      return count(static_cast<double>(point.ending.judgement.bad_objects));
    });
    all["moving_objects"] = Column([&](const GridPoint& point) {
      const auto ran = figures::CellsThatRan(file_, point.at);
      return count(ran.empty() ? figures::kNone : figures::MovingObjectsOf(file_, ran[0]));
    });
    all["cycles"] = Column([&](const GridPoint& point) -> Json {
      std::uint64_t most = 0;
      for (std::uint64_t rep = 0; rep < file_.repeats(); ++rep)
        most = std::max(most, file_.ReadCycleCount({point.at, rep}));
      return most;
    });
  }

  void AddTimes(Json& all) const {
    for (const protocol::Phase phase : DocumentedPhases(model_))
      all["times"][figures::PhaseName(phase)] = TimesOf(phase);
    if (IsLarge(model_)) return;
    all["time_step"] =
        MeasuredColumn([&](const MeasuredPoint& point) { return model_.TimeStepOf(point); });
    const auto add = [&](const char* name, auto part_of) {
      all[name] = MeasuredColumn(
          [&](const MeasuredPoint& point) { return part_of(model_.MsPerSecondOf(point)); });
    };
    add("ms_per_s", [](const Estimate& ms) { return ms.value; });
    add("ms_per_s_low", [&](const Estimate& ms) { return model_.times().IntervalOf(ms).low; });
    add("ms_per_s_high", [&](const Estimate& ms) { return model_.times().IntervalOf(ms).high; });
  }

  Json TimesOf(protocol::Phase phase) const {
    figures::CycleTimes& times = model_.times();
    Json columns = Json::object();
    const auto add = [&](const char* name, auto part_of) {
      columns[name] = MeasuredColumn(
          [&](const MeasuredPoint& point) { return part_of(times.Of(point, phase).mean); });
    };
    add("mean", [](const Estimate& mean) { return mean.value; });
    add("low", [&](const Estimate& mean) { return times.IntervalOf(mean).low; });
    add("high", [&](const Estimate& mean) { return times.IntervalOf(mean).high; });
    if (IsLarge(model_)) return columns;
    for (const auto& [name, statistic] : kDocumentedStatistics)
      columns[name] = MeasuredColumn([&, statistic = statistic](const MeasuredPoint& point) {
        return times.StatisticOf(point, phase, statistic);
      });
    return columns;
  }

  void AddCounts(Json& all) const {
    for (const std::string& series : DocumentedCounts(model_))
      all["counts"][series] =
          MeasuredColumn([&](const MeasuredPoint& point) { return model_.CountOf(point, series); });
    if (file_.Has("hit")) AddConfigurations(all);
    if (model_.HasNarrowTraces())
      all["ns_per_pair"] =
          MeasuredColumn([&](const MeasuredPoint& point) { return model_.NsPerPairOf(point); });
    for (const std::string& name : DocumentedMemory(model_))
      all["memory"][name] =
          MeasuredColumn([&](const MeasuredPoint& point) { return model_.MemoryOf(point, name); });
  }

  /// Of each event and phase.
  void AddCounters(Json& all) const {
    if (!file_.Has("counters")) return;
    for (std::size_t i = 0; i < protocol::kCounterCount; ++i)
      for (std::size_t phase = 0; phase < protocol::kPhaseCount; ++phase)
        all["counters"][std::string(schema::kCounters[i])][std::string(schema::kPhases[phase])] =
            MeasuredColumn([&, i, phase](const MeasuredPoint& point) {
              const MeasuredPoint* const points[] = {&point};
              return figures::CounterOf(file_, points, static_cast<schema::Counter>(i),
                                        static_cast<protocol::Phase>(phase));
            });
  }

  /// Of each type of queries.
  void AddQueries(Json& all) const {
    if (!figures::HasQueries(model_.file())) return;
    using figures::QueryFigures;
    constexpr std::pair<const char*, double QueryFigures::*> kColumns[] = {
        {"count", &QueryFigures::count},
        {"hits", &QueryFigures::hits},
        {"time", &QueryFigures::time_ns},
        {"update_time", &QueryFigures::update_ns},
        {"ns_per_query", &QueryFigures::ns_per_query},
        {"compared", &QueryFigures::compared},
        {"missed", &QueryFigures::missed},
        {"false", &QueryFigures::wrong},
        {"error", &QueryFigures::error},
        {"normal_error", &QueryFigures::normal_error}};
    for (std::size_t type = 0; type < protocol::kQueryTypeCount; ++type)
      for (const auto& [name, figure] : kColumns)
        all["queries"][std::string(schema::kQueryTypes[type])][name] =
            MeasuredColumn([&, figure = figure](const MeasuredPoint& point) {
              const MeasuredPoint* const points[] = {&point};
              return figures::QueriesOf(file_, points, static_cast<schema::QueryType>(type)).*
                     figure;
            });
  }
  /// Null for points that check none.
  void AddConfigurations(Json& all) const {
    const auto add = [&](const char* name, auto of) {
      all["configurations"][name] = Column([&](const GridPoint& point) -> Json {
        if (point.measured == nullptr) return nullptr;
        const ConfigurationFigures sums = ConfigurationFiguresOf(model_, {point.measured});
        return sums.all == 0 ? Json(nullptr) : Json(of(*point.measured, sums));
      });
    };
    using Sums = ConfigurationFigures;
    add("count", [](const MeasuredPoint&, const Sums& sums) { return Json(sums.all); });
    add("hit", [](const MeasuredPoint&, const Sums& sums) { return Json(sums.hit); });
    add("compared", [](const MeasuredPoint&, const Sums& sums) { return Json(sums.compared); });
    add("missed", [](const MeasuredPoint&, const Sums& sums) { return Json(sums.missed); });
    add("false", [](const MeasuredPoint&, const Sums& sums) { return Json(sums.wrong); });
    if (model_.HasTimes())
      add("per_second", [&](const MeasuredPoint& point, const Sums&) {
        return ModelNumber(
            model_, ConfigurationsPerSecond(model_.TimeOf(point, protocol::Phase::kStep).value));
      });
  }

  void AddErrors(Json& all) const {
    for (const schema::ErrorInfo& error : schema::Errors()) {
      const std::string name(error.name);
      if (!file_.Has("accuracy/" + name)) continue;
      Json& columns = all["errors"][name];
      columns["unit"] = error.unit;
      columns["label"] = error.doc;
      columns["value"] =
          MeasuredColumn([&](const MeasuredPoint& point) { return model_.ErrorOf(point, name); });
      if (file_.Has("accuracy/" + name + "_floor"))
        columns["floor"] = MeasuredColumn(
            [&](const MeasuredPoint& point) { return model_.ErrorOf(point, name + "_floor"); });
    }
  }

  const figures::Model& model_;
  const results::ResultFile& file_;
  const std::vector<GridPoint>& points_;
};

Json ValueJson(const plan::Axis& axis, std::size_t index) {
  const plan::Coordinate& value = axis.values[index];
  if (const auto* number = std::get_if<double>(&value)) return JsonNumber(*number, 17);
  return std::get<std::string>(value);
}

std::vector<std::string> Those(const results::ResultFile& file,
                               std::initializer_list<const char*> names) {
  std::vector<std::string> those;
  for (const char* name : names)
    if (file.Has(name)) those.emplace_back(name);
  return those;
}

}  // namespace

bool IsLarge(const figures::Model& model) { return model.grid().size() > kMaxWholePoints; }

Json SectionsJson(const Document& document) {
  Json sections = Json::array();
  for (const Section& section : document) {
    Json columns = Json::array();
    for (const Table::Column& column : section.table.columns)
      columns.push_back({{"label", column.head}, {"is_number", column.is_number}});
    sections.push_back({{"title", section.title},
                        {"lines", section.lines},
                        {"columns", std::move(columns)},
                        {"rows", section.table.rows},
                        {"notes", section.notes}});
  }
  return sections;
}

Json ModelNumber(const figures::Model& model, double value) {
  return JsonNumber(value, IsLarge(model) ? 4 : 6);
}

Json CycleOrNull(const figures::Ending& ending) {
  return ending.judgement.first_bad_cycle < 0 ? Json(nullptr)
                                              : Json(ending.judgement.first_bad_cycle);
}

std::vector<protocol::Phase> DocumentedPhases(const figures::Model& model) {
  if (!IsLarge(model)) return figures::AllPhases();
  return {protocol::Phase::kDetect, protocol::Phase::kStep};
}

std::string LabelOf(const plan::Axis& axis) {
  if (!axis.title.empty()) return axis.title;
  const std::string kind = KindOf(axis);
  for (const AxisLabel& known : kAxisLabels)
    if (known.parameter == kind && axis.name == kind) return std::string(known.label);
  std::string label = axis.name;
  std::ranges::replace(label, '_', ' ');
  return label;
}

std::vector<std::string> DocumentedCounts(const figures::Model& model) {
  return Those(model.file(), {"pairs", "unhandled_pairs", "manifolds", "contacts", "present",
                              "departed", "exact_pairs", "missed_pairs", "repose_angle", "runout"});
}

std::vector<std::string> DocumentedMemory(const figures::Model& model) {
  return Those(model.file(), {"peak_rss", "heap"});
}

Json PlaceJson(const figures::Model& model, const std::vector<std::size_t>& axes,
               const figures::Point& at) {
  Json place = Json::object();
  for (std::size_t i = 0; i < axes.size(); ++i)
    place[model.axis(axes[i]).name] = ValueJson(model.axis(axes[i]), at[i]);
  return place;
}

Json DocumentAxes(const figures::Model& model) {
  Json axes = Json::array();
  for (std::size_t i = 0; i < model.file().axes().size(); ++i) {
    const plan::Axis& axis = model.axis(i);
    Json sampled = Json::array();
    for (const plan::Coordinates& of : axis.sampled)
      sampled.push_back({{"name", of.name}, {"log", of.is_log}, {"values", of.values}});
    axes.push_back({{"name", axis.name},
                    {"sampled", std::move(sampled)},
                    {"label", LabelOf(axis)},
                    {"has_title", !axis.title.empty()},
                    {"unit", axis.unit},
                    {"is_text", axis.IsText()},
                    {"kind", KindOf(axis)},
                    {"doc", DocOf(axis)},
                    {"value_labels", plan::CoordinateLabels(axis)},
                    {"values", JsonColumn(axis.values.size(),
                                          [&](std::size_t v) { return ValueJson(axis, v); })}});
  }
  return axes;
}

Json DocumentPhases() {
  return JsonColumn(protocol::kPhaseCount, [](std::size_t i) -> Json {
    return {{"name", protocol::PhaseNames()[i]},
            {"label", kPhaseWords[i].label},
            {"definition", kPhaseWords[i].definition}};
  });
}

Json DocumentPoints(const figures::Model& model) { return PointColumns(model).All(); }

// The times of single cycles, for results documents of a page.

namespace {

using protocol::Phase;

constexpr std::size_t kMaxBins = 200, kMaxTimelines = 60;
constexpr std::size_t kMaxDistributions = 500, kMaxStepDistributions = 2000;
constexpr int kPercents[] = {0, 5, 10, 20, 25, 30, 40, 50, 60, 70, 75, 80, 90, 95, 100};
constexpr int kDigits = 4;  // more than a screen can show

/// The points whose cycles are drawn: the same number for each detector.
std::vector<std::size_t> ChooseTimelines(const figures::Model& model) {
  const auto axis = model.detector_axis();
  const std::size_t detectors = axis ? model.axis(*axis).values.size() : 1;
  const std::size_t each = model.grid().size() <= kMaxTimelines
                               ? model.grid().size()
                               : std::max<std::size_t>(1, kMaxTimelines / detectors);
  std::map<std::size_t, std::size_t> taken;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < model.grid().size() && chosen.size() < kMaxTimelines; ++i) {
    const figures::GridPoint& point = model.grid()[i];
    if (point.measured != nullptr && ++taken[axis ? point.at[*axis] : 0] <= each)
      chosen.push_back(i);
  }
  return chosen;
}

/// The begin and end of each bin.
std::vector<std::pair<std::size_t, std::size_t>> BinsOf(std::uint64_t cycles) {
  const std::size_t count = std::min<std::size_t>(cycles, kMaxBins);
  std::vector<std::pair<std::size_t, std::size_t>> bins;
  for (std::size_t i = 0; i < count; ++i)
    bins.emplace_back(i * cycles / count, (i + 1) * cycles / count);
  return bins;
}

/// The mean of each bin over the cycles that ran; null if none did.
Json Binned(const std::vector<double>& cycles,
            const std::vector<std::pair<std::size_t, std::size_t>>& bins) {
  return JsonColumn(bins.size(), [&](std::size_t i) {
    double sum = 0, count = 0;
    for (std::size_t c = bins[i].first; c < std::min(bins[i].second, cycles.size()); ++c) {
      if (std::isnan(cycles[c])) continue;
      sum += cycles[c];
      ++count;
    }
    return JsonNumber(sum / count, kDigits);
  });
}

Json QuantilesOf(std::vector<double> cycles) {
  std::erase_if(cycles, [](double time) { return std::isnan(time); });
  std::ranges::sort(cycles);
  return JsonColumn(std::size(kPercents), [&](std::size_t i) {
    return JsonNumber(figures::Percentile(cycles, kPercents[i] / 100.0), kDigits);
  });
}

/// The mean over the cycles, for each repeat of a point.
Json RepeatMeans(const figures::Model& model, const figures::MeasuredPoint& point, Phase phase) {
  const std::vector<double>& means = model.times().Of(point, phase).repeat_means;
  return JsonColumn(point.cells.size(),
                    [&](std::size_t i) { return JsonNumber(means[point.cells[i].rep], kDigits); });
}

}  // namespace

Json DocumentCycles(const figures::Model& model) {
  if (!model.HasTimes() || IsLarge(model)) return nullptr;
  const std::vector<std::size_t> chosen = ChooseTimelines(model);
  // Cycles that ran; the file has room for more.
  std::size_t cycles = 0;
  for (const std::size_t i : chosen)
    cycles =
        std::max(cycles, model.times().Of(*model.grid()[i].measured, Phase::kStep).cycles.size());
  const auto bins = BinsOf(cycles);
  Json all = {{"points", chosen}, {"of", model.points().size()}, {"bins", bins}};
  for (const Phase phase : figures::AllPhases())
    all[figures::PhaseName(phase)] = JsonColumn(chosen.size(), [&](std::size_t i) {
      return Binned(model.times().Of(*model.grid()[chosen[i]].measured, phase).cycles, bins);
    });
  return all;
}

Json DocumentDistributions(const figures::Model& model) {
  const std::size_t count = model.grid().size();
  if (!model.HasTimes() || count > kMaxStepDistributions) return nullptr;
  Json all = {{"percents", kPercents}};
  for (const Phase phase : figures::AllPhases()) {
    if (count > kMaxDistributions && phase != Phase::kStep && phase != Phase::kDetect) continue;
    const std::string name = figures::PhaseName(phase);
    Json quantiles = Json::array(), means = Json::array();
    for (const figures::GridPoint& point : model.grid()) {
      const figures::MeasuredPoint* measured = point.measured;
      quantiles.push_back(measured == nullptr
                              ? Json(nullptr)
                              : QuantilesOf(model.times().Of(*measured, phase).cycles));
      means.push_back(measured == nullptr ? Json(nullptr) : RepeatMeans(model, *measured, phase));
    }
    all["quantiles"][name] = std::move(quantiles);
    all["repeat_means"][name] = std::move(means);
  }
  return all;
}

Json DocumentSteady(const figures::Model& model) {
  const std::vector<steady::PointState> states = steady::FindSteadyStates(model);
  const std::string text = steady::SteadyText(states);
  if (text.empty()) return nullptr;
  Json points = Json::array();
  for (const steady::PointState& of : states)
    points.push_back({{"point", model.IndexOf(of.point->at)},
                      {"state", steady::StateName(of.steady.state)},
                      {"warmup", of.steady.warmup},
                      {"all", JsonNumber(of.steady.all)},
                      {"rest", JsonNumber(of.steady.rest)}});
  return {{"text", text}, {"points", std::move(points)}};
}

}  // namespace cdb::printers
