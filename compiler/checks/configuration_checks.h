// Scenes that are checked in configurations of their joints (compiler/analysis/configurations.h),
// and the settings that still apply to them.
#pragma once

#include <vector>

#include "compiler/checks/scene_checks.h"
#include "compiler/plan/plan.h"
#include "compiler/scenario/layers.h"

namespace cdb::checks {

/// Gives `scene` what follows from its configurations, unless `layers` sets otherwise: a cycle for
/// each line of a list, no walls, and everything is recorded that can be. Returns the settings of
/// `layers` that have no meaning without a simulation.
std::vector<LaidFault> LayConfigurations(const scenario::Scenario& scenario,
                                         const scenario::Layers& layers, plan::Scene& scene);

/// Faults of a scene after LayConfigurations: of its joints, objects and list.
std::vector<LaidFault> FindFaultsOfConfigurations(const plan::Scene& scene);

}  // namespace cdb::checks
