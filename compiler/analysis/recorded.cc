#include "compiler/analysis/recorded.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/population.h"
#include "compiler/analysis/queries.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/schema/schema.h"

namespace cdb::analysis {

RunKind KindOf(const plan::Scene& scene) {
  if (HasConfigurations(scene)) return RunKind::kConfigurations;
  if (HasSoft(scene)) return RunKind::kSoft;
  if (!TraceOf(scene)) return ComesOrGoes(scene) ? RunKind::kChanging : RunKind::kLive;
  return IsOnPairs(scene) ? RunKind::kOnPairs : RunKind::kOnBoxes;
}

namespace {

/// The series of `record stability` that do not follow objects from cycle to cycle.
constexpr std::string_view kOfChanging[] = {
    schema::RealSeries("kinetic_energy").name(),  schema::RealSeries("energy").name(),
    schema::RealSeries("max_penetration").name(), schema::RealSeries("penetration_ratio").name(),
    schema::RealSeries("max_speed").name(),       schema::IntSeries("escaped").name(),
    schema::IntSeries("asleep").name(),           schema::IntSeries("removed").name(),
    schema::IntSeries("non_finite").name(),       schema::IntSeries("pairs").name(),
    schema::IntSeries("manifolds").name(),        schema::IntSeries("contacts").name()};

bool IsRecordedIn(RunKind kind, const schema::Series& series) {
  using enum schema::OnTraces;
  const schema::OnTraces on_traces = series.on_traces;
  switch (kind) {
    case RunKind::kChanging:
      if (schema::ListsWord(series.records, "stability") &&
          std::ranges::find(kOfChanging, series.name) == std::end(kOfChanging))
        return false;
      [[fallthrough]];
    case RunKind::kLive:
      return on_traces != kNarrowOnly && on_traces != kBroadOnly &&
             series.on_configurations != schema::OnConfigurations::kOnly &&
             series.on_soft != schema::OnSoft::kOnly;
    case RunKind::kOnBoxes:
      return on_traces == kBroad || on_traces == kBroadOnly || on_traces == kBoth;
    case RunKind::kOnPairs:
      return on_traces == kNarrow || on_traces == kNarrowOnly || on_traces == kBoth;
    case RunKind::kConfigurations:
      return series.on_configurations != schema::OnConfigurations::kNo;
    case RunKind::kSoft:
      return series.on_soft != schema::OnSoft::kNo;
  }
  return false;
}

}  // namespace

bool IsRecordedBy(const schema::Series& series, const plan::Scene& scene) {
  if (!IsRecordedIn(KindOf(scene), series)) return false;
  if (series.of_queries && !HasQueries(scene)) return false;
  if (series.of_changes && KindOf(scene) != RunKind::kChanging) return false;
  return std::ranges::any_of(scene.world.Words("record"), [&](const std::string& word) {
    return schema::ListsWord(series.records, word);
  });
}

bool MeasuresPhases(const plan::Scene& scene) {
  return scene.world.Lists("record", "timing") || scene.world.Lists("record", "counters");
}

}  // namespace cdb::analysis
