// The series that a plan records, found in one pass over its runs.
#pragma once

#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/measure/series.h"

namespace cdb::measure {

/// The series that some run records (Series::IsRecordedBy), in the order of AllSeries.
std::vector<const Series*> RecordedSeries(const plan::Plan& plan);

/// The same for one run after the other. Computed again only if a run records other series than the
/// one before. Not thread-safe.
class RecordedSeriesOf {
 public:
  const std::vector<const Series*>& Find(const plan::Scene& scene);

 private:
  bool is_begun_ = false, is_of_trace_ = false;
  schema::Value record_;
  std::vector<const Series*> series_;
};

}  // namespace cdb::measure
