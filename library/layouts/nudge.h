// The small push that makes a reference run's twin.
#pragma once

#include "compiler/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::library {

/// Moves every object that is not fixed by kNudge (compiler/reference.h) of its largest side, each
/// in a direction of its own, drawn from the scene's stream `nudge`.
void Nudge(const compiler::Scene& scene, InitialState& state);

}  // namespace cdb::library
