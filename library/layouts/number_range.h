// Whether Bullet can hold the numbers of a scene in its precision: it divides by masses and moments
// of inertia, and does not report overflow.
#pragma once

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::layouts {

/// Throws SceneError, which names the group and the setting, if a number of an object, the
/// acceleration or `world.side`, rounded to the scene's `precision`, overflows, or vanishes where
/// Bullet divides by it; or if a layout puts the two objects of a spring at one position, so that
/// the spring has no direction. O(N). Threads: any.
void CheckRange(const plan::Scene& scene, const InitialState& state);

}  // namespace cdb::layouts
