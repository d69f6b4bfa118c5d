#include "runtime/document/time_steps.h"

#include "runtime/statistics/cells.h"
#include "runtime/statistics/numbers.h"

namespace cdb::document {

TimeSteps::TimeSteps(const store::ResultFile& file)
    : file_(file), is_stated_(file.Has("accuracy/timestep")) {
  if (is_stated_) return;
  const auto plan = statistics::ReadPlan(file);
  if (!plan) return;
  for (const plan::Run& run : plan->runs) by_run_.emplace(run.id, run.scene.world.Real("timestep"));
}

double TimeSteps::Of(const store::ResultFile::Cell& cell) const {
  if (is_stated_) return file_.ReadReal("accuracy/timestep", cell);
  const auto found = by_run_.find(file_.ReadText("run_id", cell));
  return found == by_run_.end() ? statistics::kNone : found->second;
}

}  // namespace cdb::document
