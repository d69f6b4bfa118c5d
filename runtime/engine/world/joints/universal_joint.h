// A universal joint: a cross between two bodies.
#pragma once

#include <btBulletDynamicsCommon.h>

namespace cdb::joints {

/// Holds two points together, and an axis of the first body perpendicular to one of the second: the
/// second turns about both. Bullet's btUniversalConstraint divides the turn into Euler's angles,
/// and is bound to less than a right angle about one axis; this one to neither. Not thread-safe.
class UniversalJoint final : public btPoint2PointConstraint {
 public:
  /// Pivot and axis, a unit vector, in the frame of the body named.
  UniversalJoint(btRigidBody& first, btRigidBody& second, const btVector3& pivot_in_first,
                 const btVector3& pivot_in_second, const btVector3& axis_in_first,
                 const btVector3& axis_in_second);

  btVector3 AxisOfFirst() const { return m_rbA.getWorldTransform().getBasis() * axis_in_first_; }
  btVector3 AxisOfSecond() const { return m_rbB.getWorldTransform().getBasis() * axis_in_second_; }

  void getInfo1(btConstraintInfo1* info) override;
  void getInfo2(btConstraintInfo2* info) override;

 private:
  const btVector3 axis_in_first_, axis_in_second_;
};

}  // namespace cdb::joints
