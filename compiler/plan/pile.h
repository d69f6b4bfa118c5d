// Which runs of a sweep begin with the same pile.
#pragma once

#include <string>

#include "compiler/plan/plan.h"

namespace cdb::plan {

/// A group with objects has `location pile`.
bool HasPile(const Group& group);
bool HasPile(const Scene& scene);

/// The scene as its piles settle: in double precision, with a fixed detector and solver, and
/// nothing recorded. The time step is that of `scene`.
Scene SettlingScene(const Scene& scene);

/// What decides the piles of a scene, as text: scenes with the same text have the same piles. The
/// time step of settling follows from it.
std::string PileText(const Scene& scene);

}  // namespace cdb::plan
