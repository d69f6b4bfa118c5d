// The unit of the times that a run records.
#pragma once

#include <algorithm>

#include "compiler/plan/plan.h"

namespace cdb::plan {

/// True if the times of the run are numbers of instructions, and not nanoseconds.
inline bool CountsInstructions(const Scene& scene) {
  return scene.world.WordOr("clock") == "instructions";
}
/// The same of all runs of a plan, which have one clock.
inline bool CountsInstructions(const Plan& plan) {
  return std::ranges::any_of(plan.Bounds(),
                             [](const Run& run) { return CountsInstructions(run.scene); });
}

}  // namespace cdb::plan
