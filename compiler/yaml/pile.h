// Identifies the runs of a sweep that begin with the same pile.
#pragma once

#include <string>

#include "compiler/plan/plan.h"

namespace cdb::yaml {

/// True if the group has objects and `location pile`.
bool HasPile(const plan::Group& group);
bool HasPile(const plan::Scene& scene);

/// The scene in which its piles settle: in double precision, with a fixed detector and solver,
/// recording nothing. What piles ignore is at its default (schema::Parameter::ignored_by).
plan::Scene SettlingScene(const plan::Scene& scene);

/// Everything that determines the piles of a scene, as text: scenes with the same text have the
/// same piles. It also determines the time step of settling.
std::string PileText(const plan::Scene& scene);

}  // namespace cdb::yaml
