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
#pragma once

#include <btBulletDynamicsCommon.h>

#include "runtime/engine/detection/scene_view.h"
#include "runtime/omissions/omissions.h"

namespace cdb::world {

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
};

/// True if the body keeps its orientation to the bit while nothing touches it: it does not spin,
/// and Bullet's conversion from matrix to quaternion and back reproduces the matrix.
bool MayOmitRotation(btRigidBody& body, btScalar timestep);

}  // namespace cdb::world
