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

#include <btBulletDynamicsCommon.h>

#include <array>
#include <cstdint>
#include <functional>
#include <utility>

#include "runtime/engine/detection/scene_view.h"
#include "runtime/engine/world/clock.h"
#include "runtime/engine/world/multibodies.h"
#include "runtime/omissions/omissions.h"
#include "runtime/protocol/series.h"

namespace cdb::world {

// Bullet's discrete world without the passes that a scene does not need.
//
// An omitted pass would have had no effect, or is replaced by its result, so that every body moves
// as in Bullet's own world, to the last bit (Bullet 3.24):
//   detection       not called; no pair, no manifold
//   solver          calculateSimulationIslands is not called, and in solveConstraints velocities
//                   become (v + 0) + (F m^-1) dt and the same of the spin with the gyroscopic
//                   impulse, as btSequentialImpulseConstraintSolver does to bodies without contact
//   sleeping        updateActivationState is not called: all stay active
//   swept_contacts  createPredictiveContacts is not called
//   gravity         applyGravity is not called: it would add 0
//   damping         applyDamping is not called: it would multiply by 1
//   rotation        only places move; turning by 0 must give the same orientation (MayOmitRotation)
//   motion_states   synchronizeMotionStates is not called: no body has one
//   static_boxes    from the second cycle on only the boxes of active bodies are updated

/// Not thread-safe.
class LeanWorld : public btDiscreteDynamicsWorld {
 public:
  /// The objects behind the arguments must outlive it. `solver` is never called if it is omitted.
  LeanWorld(btDispatcher* dispatcher, btBroadphaseInterface* broad_phase,
            btConstraintSolver* solver, btCollisionConfiguration* configuration,
            const omissions::Omissions& omissions);

  /// From the next step on, boxes are computed by `view`, which must outlive it and contain all
  /// bodies of the world.
  void ComputeBoxesBy(detection::SceneView& view) { view_ = &view; }
  /// From the next step on, `bodies`, which must outlive it, solve the contacts and move. The
  /// solver that the world was made with is not called.
  void SolveBy(Multibodies& bodies) { multibodies_ = &bodies; }
  /// From the next step on, calls `visit` between broad and narrow phase. A TimedWorld does not.
  void BeforeNarrowPhase(std::function<void()> visit) { before_narrow_ = std::move(visit); }

  void updateAabbs() override;
  void performDiscreteCollisionDetection() override;
  void solveConstraints(btContactSolverInfo& info) override;
  void applyGravity() override;
  void synchronizeMotionStates() override;

 protected:
  bool Omits(schema::Component component) const {
    return (omitted_ >> static_cast<int>(component) & 1) != 0;
  }

  /// Kinematic objects keep the velocities that Kinematics gave them. Bullet would compute others
  /// from the last two poses, in its own precision.
  void saveKinematicState(btScalar) override {
    btDiscreteDynamicsWorld::saveKinematicState(btScalar(0));
  }
  void predictUnconstraintMotion(btScalar timestep) override;
  void createPredictiveContacts(btScalar timestep) override;
  void calculateSimulationIslands() override;
  void updateActivationState(btScalar timestep) override;
  void integrateTransforms(btScalar timestep) override;

 private:
  void ApplyForces(btRigidBody& body, btScalar timestep);

  unsigned omitted_ = 0;  ///< bit by component
  detection::SceneView* view_ = nullptr;
  Multibodies* multibodies_ = nullptr;
  std::function<void()> before_narrow_;  ///< may be empty
};

/// True if the body keeps its orientation to the bit while nothing touches it: it does not spin,
/// and Bullet's conversion from matrix to quaternion and back reproduces the matrix.
bool MayOmitRotation(btRigidBody& body, btScalar timestep);

/// Takes a fixed number of time stamps per step; stores nothing else. Not thread-safe.
class TimedWorld final : public LeanWorld {
 public:
  static constexpr std::size_t kStamps = 9;
  using LeanWorld::LeanWorld;

  /// One internal step of `timestep` s, with time stamps.
  void TimedStep(btScalar timestep);
  /// Broad and narrow phase alone, with time stamps; `step` is the time of both.
  void TimedDetection();
  /// What each phase of the last TimedStep took, the difference of its two stamps.
  PhaseStamps Phases() const;
  /// Its times.
  std::array<double, protocol::kPhaseCount> Durations() const;

  void performDiscreteCollisionDetection() override;
  void solveConstraints(btContactSolverInfo& info) override;

 protected:
  void integrateTransforms(btScalar timestep) override;

 private:
  /// Adjacent phases share a stamp: broad ends where narrow begins.
  struct Stamps {
    Stamp step_begin, detect_begin, broad_end, detect_end;
    Stamp solve_begin, solve_end, integrate_begin, integrate_end, step_end;
  };
  static_assert(sizeof(Stamps) == kStamps * sizeof(Stamp));
  Stamps stamps_ = {};
};

}  // namespace cdb::world
