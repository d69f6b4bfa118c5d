// A Bullet world with time stamps at the boundaries of its phases.
//
// Contents of each phase (Bullet 3.24, one call of stepSimulation with one internal step):
//   detect     performDiscreteCollisionDetection, that is broad and narrow, nothing between them
//     broad    updateAabbs and computeOverlappingPairs: boxes moved, pairs found and lost
//     narrow   dispatchAllCollisionPairs: contacts of the pairs, manifolds refreshed
//   solve      solveConstraints: islands built from the manifolds, contacts set up and solved;
//   gravity,
//              applied forces and gyroscopic torque become velocity here
//   integrate  integrateTransforms: positions and orientations moved; sweeps of `ccd`
//   step       all of stepSimulation
// Included in step, but in none of the first five: gravity as a force, predictUnconstraintMotion
// (damping and the predicted poses), createPredictiveContacts (the first sweep of `ccd`),
// calculateSimulationIslands (which bodies are joined and which islands sleep),
// updateActivationState, clearing the forces.
#pragma once

#include <array>
#include <cstdint>

#include "runtime/engine/world/lean_world.h"
#include "runtime/protocol/series.h"

namespace cdb::world {

/// Monotonic time in ns.
std::int64_t Now();

/// Takes a fixed number of time stamps per step; stores nothing else. Not thread-safe.
class TimedWorld final : public LeanWorld {
 public:
  static constexpr std::size_t kStamps = 9;
  using LeanWorld::LeanWorld;

  /// One internal step of `timestep` s, with time stamps.
  void TimedStep(btScalar timestep);
  /// Nanoseconds of each phase of the last TimedStep, each the difference of its two stamps.
  std::array<double, protocol::kPhaseCount> Durations() const;

  void performDiscreteCollisionDetection() override;
  void solveConstraints(btContactSolverInfo& info) override;

 protected:
  void integrateTransforms(btScalar timestep) override;

 private:
  /// Adjacent phases share a stamp: broad ends where narrow begins.
  struct Stamps {
    std::int64_t step_begin, detect_begin, broad_end, detect_end;
    std::int64_t solve_begin, solve_end, integrate_begin, integrate_end, step_end;
  };
  static_assert(sizeof(Stamps) == kStamps * sizeof(std::int64_t));
  Stamps stamps_ = {};
};

}  // namespace cdb::world
