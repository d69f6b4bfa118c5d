#include "runtime/measure/recorded_series.h"

#include <algorithm>

#include "compiler/analysis/trace.h"

namespace cdb::measure {

const std::vector<const Series*>& RecordedSeriesOf::Find(const plan::Scene& scene) {
  const bool is_of_trace = analysis::TraceOf(scene).has_value();
  const schema::Value& record = scene.world.Get("record");
  if (is_begun_ && is_of_trace == is_of_trace_ && record == record_) return series_;
  is_begun_ = true;
  is_of_trace_ = is_of_trace;
  record_ = record;
  series_.clear();
  for (const Series& series : AllSeries())
    if (series.IsRecordedBy(scene)) series_.push_back(&series);
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

}  // namespace cdb::measure
