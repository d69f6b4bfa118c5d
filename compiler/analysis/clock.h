// The unit of the times that a run records.
#pragma once

#include <algorithm>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

/// True if the times of the run are numbers of instructions, and not nanoseconds.
inline bool CountsInstructions(const plan::Scene& scene) {
  return scene.world.WordOr("clock") == "instructions";
}
/// The same of all runs of a plan, which have one clock.
inline bool CountsInstructions(const plan::Plan& plan) {
  return std::ranges::any_of(plan.Bounds(),
                             [](const plan::Run& run) { return CountsInstructions(run.scene); });
}

}  // namespace cdb::analysis
