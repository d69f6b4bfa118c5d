#include "runtime/protocol/series.h"

#include <algorithm>

#include "compiler/analysis/queries.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/schema/schema.h"

namespace cdb::protocol {

RunExtents ExtentsOf(const plan::Scene& scene) {
  return {scene.world.Count("cycles"), scene.ObjectCount(), analysis::BodyCount(scene),
          scene.QueryCount(), analysis::NodeCount(scene)};
}

bool IsRecordedBy(const Series& series, const plan::Plan& plan) {
  return std::ranges::any_of(plan.Bounds(),
                             [&](const plan::Run& run) { return IsRecordedBy(series, run.scene); });
}

const std::vector<const Series*>& RecordedSeriesOf::Find(const plan::Scene& scene) {
  const int kind = static_cast<int>(analysis::KindOf(scene));
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
