// The one position of a hinge or a slider, and the motion of two bodies that changes it.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <array>

namespace cdb::world {

/// The position q of the second body relative to the first, along (slider) or about (hinge) an axis
/// that turns with the first: a way in m, or an angle in rad of any number of turns; 0 at the
/// start. Not thread-safe.
class JointAxis {
 public:
  /// The axis, a unit vector, and the pivot are in the frame of the body named; their bodies are at
  /// their initial poses and must outlive it.
  JointAxis(btRigidBody& first, btRigidBody& second, bool turns, const btVector3& axis_in_first,
            const btVector3& pivot_in_first, const btVector3& pivot_in_second);

  bool turns() const { return turns_; }
  btRigidBody& first() const { return first_; }
  btRigidBody& second() const { return second_; }

  /// q by the poses of the bodies, less than half a turn from that of the last BeginStep.
  btScalar Position() const;
  /// Call at the start of each step, at least once; returns q.
  btScalar BeginStep() { return last_ = Position(); }

  /// The part of a body in dq/dt: linear . v + angular . w, with the velocity of its centre of mass
  /// and its spin.
  struct Share {
    btRigidBody* body;
    btVector3 linear, angular;
    btScalar Rate() const {
      return linear.dot(body->getLinearVelocity()) + angular.dot(body->getAngularVelocity());
    }
    /// What it adds to the velocity that a unit impulse gives.
    btScalar Mobility() const {
      return linear.length2() * body->getInvMass() +
             angular.dot(body->getInvInertiaTensorWorld() * angular);
    }
  };
  /// Of the first, and of the second.
  std::array<Share, 2> Shares() const;

 private:
  btRigidBody &first_, &second_;
  const bool turns_;
  const btVector3 axis_in_first_, pivot_in_first_, pivot_in_second_;
  btVector3 across_in_first_, across_in_second_;  ///< equal at the start, perpendicular to the axis
  btScalar last_ = 0;                             ///< q before the last step
};

}  // namespace cdb::world
