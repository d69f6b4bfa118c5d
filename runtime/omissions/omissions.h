// The omissions of a run, decided from its initial state. Independent of the physics engine, so
// that the worker and `cdb plan --why` make the same decisions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compiler/analysis/engine_constants.h"
#include "compiler/analysis/pruning.h"
#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::omissions {

using analysis::kWallCount;
using analysis::kWallThickness;
/// Bits of the walls, in the order in which the engine adds them.
inline constexpr const char* kWallNames[kWallCount] = {"-x", "+x", "-y", "+y", "-z", "+z"};
/// The bits of the walls that are present in `scene`.
std::uint8_t StandingWalls(const plan::Scene& scene);

struct Omissions {
  std::vector<analysis::PruningDecision> decisions;  ///< one for each component; none is undecided
  /// By object: the bits of the walls that it keeps. If empty, every object keeps all walls.
  std::vector<std::uint8_t> walls;
  /// If the pools are omitted: the number of pairs that they hold; further ones come from the heap.
  int pool_size = 0;

  bool Omits(schema::Component component) const;
  /// Keeps the component after all: the run showed that it is needed, or must match another run.
  void Keep(schema::Component component, std::string why);
};

/// Throws library::SceneError if `omit` names a component that the scene needs.
Omissions DecideOmissions(const plan::Scene& scene, const layouts::InitialState& state);

/// Keeps every component, as `omit none` does, regardless of the scene.
Omissions KeepEverything(const plan::Scene& scene);

}  // namespace cdb::omissions
