#include "runtime/protocol/series.h"

#include <algorithm>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/queries.h"
#include "compiler/analysis/reference.h"
#include "compiler/analysis/trace.h"
#include "compiler/schema/schema.h"

namespace cdb::protocol {

RunExtents ExtentsOf(const plan::Scene& scene) {
  return {scene.world.Count("cycles"), scene.ObjectCount(), analysis::BodyCount(scene),
          scene.QueryCount()};
}

namespace {

enum class RunKind { kLive, kOnBoxes, kOnPairs, kConfigurations };

RunKind KindOf(const plan::Scene& scene) {
  if (analysis::HasConfigurations(scene)) return RunKind::kConfigurations;
  if (!analysis::TraceOf(scene)) return RunKind::kLive;
  return analysis::IsOnPairs(scene) ? RunKind::kOnPairs : RunKind::kOnBoxes;
}

bool IsRecordedIn(RunKind kind, const Series& series) {
  using enum schema::OnTraces;
  const schema::OnTraces on_traces = series.on_traces;
  switch (kind) {
    case RunKind::kLive:
      return on_traces != kNarrowOnly &&
             series.on_configurations != schema::OnConfigurations::kOnly;
    case RunKind::kOnBoxes:
      return on_traces == kBroad || on_traces == kBoth;
    case RunKind::kOnPairs:
      return on_traces == kNarrow || on_traces == kNarrowOnly || on_traces == kBoth;
    case RunKind::kConfigurations:
      return series.on_configurations != schema::OnConfigurations::kNo;
  }
  return false;
}

}  // namespace

bool IsRecordedBy(const Series& series, const plan::Scene& scene) {
  if (!IsRecordedIn(KindOf(scene), series)) return false;
  if (series.of_queries && !analysis::HasQueries(scene)) return false;
  return std::ranges::any_of(scene.world.Words("record"), [&](const std::string& word) {
    return schema::ListsWord(series.records, word);
  });
}

bool IsRecordedBy(const Series& series, const plan::Plan& plan) {
  return std::ranges::any_of(plan.Bounds(),
                             [&](const plan::Run& run) { return IsRecordedBy(series, run.scene); });
}

const std::vector<const Series*>& RecordedSeriesOf::Find(const plan::Scene& scene) {
  const int kind = static_cast<int>(KindOf(scene));
  const schema::Value& record = scene.world.Get("record");
  const bool asks = analysis::HasQueries(scene);
  if (kind == kind_ && record == record_ && asks == asks_) return series_;
  kind_ = kind;
  asks_ = asks;
  record_ = record;
  series_.clear();
  for (const Series& series : AllSeries())
    if (IsRecordedBy(series, scene)) series_.push_back(&series);
  return series_;
}

std::vector<const Series*> RecordedSeries(const plan::Plan& plan) {
  std::vector<const Series*> all;
  RecordedSeriesOf of_run;
  std::vector<const Series*> seen;
  for (const plan::Run& run : plan.Bounds()) {
    const auto& series = of_run.Find(run.scene);
    if (series == seen) continue;
    seen = series;
    all.insert(all.end(), series.begin(), series.end());
  }
  // The pointers refer to elements of one array, so this is its order.
  std::ranges::sort(all);
  const auto repeated = std::ranges::unique(all);
  all.erase(repeated.begin(), repeated.end());
  return all;
}

}  // namespace cdb::protocol
