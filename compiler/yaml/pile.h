// Which runs of a sweep begin with the same pile.
#pragma once

#include <string>

#include "compiler/plan/plan.h"

namespace cdb::yaml {

/// A group with objects has `location pile`.
bool HasPile(const plan::Group& group);
bool HasPile(const plan::Scene& scene);

/// The scene as its piles settle: in double precision, with a fixed detector and solver, and
/// nothing recorded. The time step is that of `scene`.
plan::Scene SettlingScene(const plan::Scene& scene);

/// What decides the piles of a scene, as text: scenes with the same text have the same piles. The
/// time step of settling follows from it.
std::string PileText(const plan::Scene& scene);

}  // namespace cdb::yaml
