// The perturbation of the initial state for the perturbed run of a reference.
#pragma once

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::layouts {

/// Moves every object that is not fixed by kNudge (compiler/reference.h) of its largest side, each
/// in a direction of its own, drawn from the scene's stream `nudge`.
void Perturb(const plan::Scene& scene, InitialState& state);

}  // namespace cdb::layouts
