// Joints and springs between the objects of a group.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::world {

/// The links of a scene, in its world for as long as this lives. Each holds an object to the next
/// of its group, and with `links.anchor` the first to a point of the world, as if one more object
/// stood before it: as far from it as the second (one alone hangs from half its height above its
/// centre of mass). Two fixed objects are not linked. Linked objects do not collide.
///
///   ball, hinge, fixed  btPoint2PointConstraint, btHingeConstraint about the world's z,
///                       btFixedConstraint; the pivot is in the middle between the centres of mass
///   spring              between the centres of mass, along a line that turns with the first of the
///                       two: the force is k x + c dx/dt with the state at the start of the step,
///                       neither limited nor softened, so that it explodes where w dt passes 2; the
///                       other object is held on the line by Bullet's
///                       btGeneric6DofSpring2Constraint and turns freely
/// Not for several threads.
class Links {
 public:
  /// `objects` are those of `state`, where they start. World and objects must outlive it. Throws
  /// library::SceneError where a spring has no length, and so no line.
  Links(const plan::Scene& scene, const layouts::InitialState& state,
        const std::vector<std::unique_ptr<btRigidBody>>& objects, btDiscreteDynamicsWorld& world);
  ~Links();
  Links(const Links&) = delete;
  Links& operator=(const Links&) = delete;

  bool HasJoints() const { return joints_; }
  /// Sets the marks of the objects that a link pulls at to `mark`: their motion is not their own.
  void MarkHeld(std::vector<char>& marks, char mark) const;
  /// m: the largest distance of the two pivots of a joint; 0 without joints.
  double LargestGap() const;
  /// J: k x^2 / 2 of all springs, with the integrator's own term, dt F.v / 2.
  double SpringEnergy(double timestep) const;

 private:
  struct Link {
    std::unique_ptr<btTypedConstraint> constraint;
    const btRigidBody *first, *second;
    btVector3 pivot_in_first, pivot_in_second;  ///< m; of a spring its ends
    btVector3 line_in_first;                    ///< unit vector of a spring; 0 of a joint
    double length = 0;                          ///< m, at rest
    double stiffness = 0;                       ///< N/m; 0 of a joint
  };

  /// `from` is where the first of the two stands, or would.
  void Add(const plan::GroupSettings& settings, btRigidBody& first, btRigidBody& second,
           const btVector3& from);

  btDiscreteDynamicsWorld& world_;
  std::vector<Link> links_;
  bool joints_ = false;
};

}  // namespace cdb::world
