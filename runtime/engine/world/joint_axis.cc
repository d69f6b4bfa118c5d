#include "runtime/engine/world/joint_axis.h"

#include <cmath>

namespace cdb::world {

JointAxis::JointAxis(btRigidBody& first, btRigidBody& second, bool turns,
                     const btVector3& axis_in_first, const btVector3& pivot_in_first,
                     const btVector3& pivot_in_second)
    : first_(first),
      second_(second),
      turns_(turns),
      axis_in_first_(axis_in_first),
      pivot_in_first_(pivot_in_first),
      pivot_in_second_(pivot_in_second) {
  btVector3 other;
  btPlaneSpace1(axis_in_first_, across_in_first_, other);
  across_in_second_ = first.getWorldTransform().getBasis() * across_in_first_ *
                      second.getWorldTransform().getBasis();
}

btScalar JointAxis::Position() const {
  const btTransform &first = first_.getWorldTransform(), &second = second_.getWorldTransform();
  const btVector3 axis = first.getBasis() * axis_in_first_;
  if (!turns_) return axis.dot(second * pivot_in_second_ - first * pivot_in_first_);
  const btVector3 from = first.getBasis() * across_in_first_;
  const btVector3 to = second.getBasis() * across_in_second_;
  const btScalar angle = btAtan2(axis.dot(from.cross(to)), from.dot(to));
  return angle + SIMD_2_PI * std::round((last_ - angle) / SIMD_2_PI);
}

std::array<JointAxis::Share, 2> JointAxis::Shares() const {
  const btTransform &first = first_.getWorldTransform(), &second = second_.getWorldTransform();
  const btVector3 axis = first.getBasis() * axis_in_first_, none(0, 0, 0);
  if (turns_) return {Share{&first_, none, -axis}, Share{&second_, none, axis}};
  const btVector3 point = second * pivot_in_second_;
  return {Share{&first_, -axis, -(point - first.getOrigin()).cross(axis)},
          Share{&second_, axis, (point - second.getOrigin()).cross(axis)}};
}

}  // namespace cdb::world
