// What a run leaves out, settled with the objects drawn and placed. Knows no physics engine, so
// that the worker and `cdb plan --why` decide alike.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "compiler/plan/pruning.h"
#include "library/layouts/initial_state.h"

namespace cdb::pruning {

/// A wall that is a box is so much of the cube's side thick.
inline constexpr double kWallThickness = 0.1;
/// Walls by their bit, in the order in which the engine adds them.
inline constexpr int kWallCount = 6;
inline constexpr const char* kWallNames[kWallCount] = {"-x", "+x", "-y", "+y", "-z", "+z"};
/// The bits of the walls that stand in `scene`.
std::uint8_t StandingWalls(const plan::Scene& scene);

struct Omissions {
  std::vector<plan::PruningDecision> needs;  ///< one for each component, none of them open
  /// By object: the bits of the walls that it keeps. Empty: every object keeps all that stand.
  std::vector<std::uint8_t> walls;
  /// Where the pools are left out: room for so many pairs at once; what is more comes from the
  /// heap.
  int pool_size = 0;

  bool Omits(schema::Component component) const;
  /// Why the component is kept after all: the worker found out when it ran (`tripped`).
  void Keep(schema::Component component, std::string why);
};

/// Throws library::SceneError where `omit` names a component that the scene needs.
Omissions DecideOmissions(const plan::Scene& scene, const layouts::InitialState& state);

/// Everything kept: what `omit none` gives, whatever the scene says.
Omissions KeepEverything(const plan::Scene& scene);

}  // namespace cdb::pruning
