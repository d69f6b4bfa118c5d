#include "compiler/analysis/recorded.h"

#include <algorithm>
#include <string>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/queries.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/schema/schema.h"

namespace cdb::analysis {

RunKind KindOf(const plan::Scene& scene) {
  if (HasConfigurations(scene)) return RunKind::kConfigurations;
  if (HasSoft(scene)) return RunKind::kSoft;
  if (!TraceOf(scene)) return RunKind::kLive;
  return IsOnPairs(scene) ? RunKind::kOnPairs : RunKind::kOnBoxes;
}

namespace {

bool IsRecordedIn(RunKind kind, const schema::Series& series) {
  using enum schema::OnTraces;
  const schema::OnTraces on_traces = series.on_traces;
  switch (kind) {
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
  return std::ranges::any_of(scene.world.Words("record"), [&](const std::string& word) {
    return schema::ListsWord(series.records, word);
  });
}

}  // namespace cdb::analysis
