#include "runtime/document/points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "compiler/plan/coordinates.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/schema.h"
#include "runtime/document/time_steps.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/numbers.h"

namespace cdb::document {
namespace {

using Cell = store::ResultFile::Cell;
using GridPoint = DocumentSource::GridPoint;

struct PhaseWords {
  std::string_view label, definition;
};
/// In the order of measure::Phase.
constexpr std::array<PhaseWords, measure::kPhaseCount> kPhaseWords = {{
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

std::string LabelOf(const plan::Axis& axis) {
  const std::string kind = KindOf(axis);
  for (const AxisLabel& known : kAxisLabels)
    if (known.parameter == kind && axis.name == kind) return std::string(known.label);
  std::string label = axis.name;
  std::ranges::replace(label, '_', ' ');
  return label;
}

std::string DocOf(const plan::Axis& axis) {
  for (const schema::Parameter& parameter : schema::Schema())
    if (parameter.FullName() == axis.parameter) return std::string(parameter.doc);
  return {};
}

class PointColumns {
 public:
  explicit PointColumns(const DocumentSource& source)
      : source_(source), file_(source.file()), points_(source.points()) {}

  Json All() {
    Json columns = Json::object();
    AddFacts(columns);
    if (source_.HasTimes()) AddTimes(columns);
    if (!source_.IsLarge()) AddCounts(columns);
    AddErrors(columns);
    Json all = {{"at", source_.IsLarge()
                           ? FlatIndices()
                           : Column([](const GridPoint& point) -> Json { return point.at; })}};
    all.update(source_.IsLarge() ? FoldColumns(std::move(columns)) : columns);
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
      return source_.Number(of(*point.measured));
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
    all["mark"] = Column([&](const GridPoint& point) -> Json {
      return point.measured != nullptr ? point.measured->Mark()
                                       : statistics::WorstVerdict(file_, point.at).word;
    });
    all["is_void"] = Column([](const GridPoint& point) -> Json {
      return point.measured == nullptr || !point.measured->IsSound();
    });
    all["repeats"] = Column([](const GridPoint& point) -> Json {
      return point.measured == nullptr ? 0 : point.measured->cells.size();
    });
    all["verdict"] = Column([&](const GridPoint& point) -> Json {
      return statistics::WorstVerdict(file_, point.at).word;
    });
    all["first_bad_cycle"] = Column([&](const GridPoint& point) -> Json {
      const std::int64_t cycle = statistics::WorstVerdict(file_, point.at).first_bad_cycle;
      return cycle < 0 ? Json(nullptr) : Json(cycle);
    });
    all["cycles"] = Column([&](const GridPoint& point) -> Json {
      std::uint64_t most = 0;
      for (std::uint64_t rep = 0; rep < file_.repeats(); ++rep)
        most = std::max(most, file_.ReadCycleCount({point.at, rep}));
      return most;
    });
  }

  void AddTimes(Json& all) {
    for (std::size_t i = 0; i < measure::kPhaseCount; ++i) {
      const auto phase = static_cast<measure::Phase>(i);
      if (source_.IsLarge() && phase != measure::Phase::kStep && phase != measure::Phase::kDetect)
        continue;
      all["times"][std::string(measure::PhaseNames()[i])] = TimesOf(phase);
    }
    if (source_.IsLarge()) return;
    const TimeSteps steps(file_);
    const auto scale = [&](const statistics::MeasuredPoint& point) {
      return 1e-6 / steps.Of(point.cells[0]);
    };
    const auto mean = [&](const statistics::MeasuredPoint& point) -> const statistics::Estimate& {
      return source_.times().Of(point, measure::Phase::kStep).mean;
    };
    all["time_step"] = MeasuredColumn(
        [&](const statistics::MeasuredPoint& point) { return steps.Of(point.cells[0]); });
    all["ms_per_s"] = MeasuredColumn(
        [&](const statistics::MeasuredPoint& point) { return mean(point).value * scale(point); });
    all["ms_per_s_low"] = MeasuredColumn([&](const statistics::MeasuredPoint& point) {
      return source_.times().IntervalOf(mean(point)).low * scale(point);
    });
    all["ms_per_s_high"] = MeasuredColumn([&](const statistics::MeasuredPoint& point) {
      return source_.times().IntervalOf(mean(point)).high * scale(point);
    });
  }

  Json TimesOf(measure::Phase phase) const {
    const auto of =
        [&, phase](const statistics::MeasuredPoint& point) -> const statistics::PhaseTimes& {
      return source_.times().Of(point, phase);
    };
    const auto interval = [&](const statistics::MeasuredPoint& point) {
      return source_.times().IntervalOf(of(point).mean);
    };
    Json times = Json::object();
    times["mean"] =
        MeasuredColumn([&](const statistics::MeasuredPoint& p) { return of(p).mean.value; });
    times["low"] =
        MeasuredColumn([&](const statistics::MeasuredPoint& p) { return interval(p).low; });
    times["high"] =
        MeasuredColumn([&](const statistics::MeasuredPoint& p) { return interval(p).high; });
    if (source_.IsLarge()) return times;
    constexpr std::pair<const char*, double> kPercentiles[] = {
        {"median", 0.5}, {"p5", 0.05}, {"p95", 0.95}, {"min", 0}, {"max", 1}};
    std::vector<std::vector<double>> sorted(source_.points().size());
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      if (points_[i].measured == nullptr) continue;
      sorted[i] = of(*points_[i].measured).cycles;
      std::ranges::sort(sorted[i]);
    }
    for (const auto& [name, p] : kPercentiles)
      times[name] = JsonColumn(sorted.size(), [&, p = p](std::size_t i) {
        return source_.Number(statistics::Percentile(sorted[i], p));
      });
    return times;
  }

  /// All repeats have the same counts; memory is their maximum.
  void AddCounts(Json& all) const {
    for (const char* series : {"pairs", "manifolds", "contacts", "exact_pairs", "missed_pairs"})
      if (file_.Has(series))
        all["counts"][series] = MeasuredColumn([&](const statistics::MeasuredPoint& point) {
          return statistics::Mean(file_.ReadSeries(series, point.cells[0]));
        });
    const auto most = [](const statistics::MeasuredPoint& point, auto read) {
      double bytes = statistics::kNone;
      for (const Cell& cell : point.cells) bytes = std::fmax(bytes, read(cell));
      return bytes;
    };
    if (file_.Has("peak_rss"))
      all["memory"]["peak_rss"] = MeasuredColumn([&](const statistics::MeasuredPoint& point) {
        return most(point, [&](const Cell& cell) { return file_.ReadReal("peak_rss", cell); });
      });
    if (file_.Has("heap"))
      all["memory"]["heap"] = MeasuredColumn([&](const statistics::MeasuredPoint& point) {
        return most(point, [&](const Cell& cell) {
          const std::vector<double> heap = file_.ReadSeries("heap", cell);
          return heap.empty() ? statistics::kNone : std::ranges::max(heap);
        });
      });
  }

  void AddErrors(Json& all) const {
    for (const schema::ErrorInfo& error : schema::Errors()) {
      const std::string dataset = "accuracy/" + std::string(error.name);
      if (!file_.Has(dataset)) continue;
      Json& columns = all["errors"][std::string(error.name)];
      columns["unit"] = error.unit;
      columns["label"] = error.doc;
      columns["value"] = MeasuredColumn([&](const statistics::MeasuredPoint& point) {
        return file_.ReadReal(dataset, point.cells[0]);
      });
      if (file_.Has(dataset + "_floor"))
        columns["floor"] = MeasuredColumn([&](const statistics::MeasuredPoint& point) {
          return file_.ReadReal(dataset + "_floor", point.cells[0]);
        });
    }
  }

  const DocumentSource& source_;
  const store::ResultFile& file_;
  const std::vector<GridPoint>& points_;
};

}  // namespace

Json DocumentAxes(const DocumentSource& source) {
  Json axes = Json::array();
  for (std::size_t i = 0; i < source.file().axes().size(); ++i) {
    const plan::Axis& axis = source.file().axes()[i];
    axes.push_back({{"name", axis.name},
                    {"label", LabelOf(axis)},
                    {"unit", axis.unit},
                    {"is_text", axis.IsText()},
                    {"kind", KindOf(axis)},
                    {"doc", DocOf(axis)},
                    {"value_labels", plan::CoordinateLabels(axis)},
                    {"values", JsonColumn(axis.values.size(),
                                          [&](std::size_t v) { return source.Value(i, v); })}});
  }
  return axes;
}

Json DocumentPhases() {
  return JsonColumn(measure::kPhaseCount, [](std::size_t i) -> Json {
    return {{"name", measure::PhaseNames()[i]},
            {"label", kPhaseWords[i].label},
            {"definition", kPhaseWords[i].definition}};
  });
}

Json DocumentPoints(const DocumentSource& source) { return PointColumns(source).All(); }

}  // namespace cdb::document
