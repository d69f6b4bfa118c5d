// The perturbation of the initial state for the perturbed run of a reference.
#pragma once

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::layouts {

/// Moves every object with mass by kPerturbation (compiler/analysis/reference.h) of its largest
/// side, each in a separate direction drawn from the scene's stream `nudge`.
void Perturb(const plan::Scene& scene, InitialState& state);

}  // namespace cdb::layouts
