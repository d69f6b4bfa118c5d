// The series that a plan records, found in one pass over its runs.
#pragma once

#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/measure/series.h"

namespace cdb::measure {

/// Those that Series::IsRecordedBy of some run, in the order of AllSeries.
std::vector<const Series*> RecordedSeries(const plan::Plan& plan);

/// The same of one run after the other: found anew only where a run records something else than the
/// one before. Not for several threads.
class RecordedSeriesOf {
 public:
  const std::vector<const Series*>& Find(const plan::Scene& scene);

 private:
  bool is_begun_ = false, is_of_trace_ = false;
  schema::Value record_;
  std::vector<const Series*> series_;
};

}  // namespace cdb::measure
