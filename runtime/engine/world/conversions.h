// Conversions between vectors and rotations of Bullet, in the precision of this worker, and of
// Eigen, in double.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <LinearMath/btTransform.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "library/objects/solid.h"

namespace cdb::world {

inline btVector3 ToBullet(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

inline btMatrix3x3 BasisOf(const Eigen::Matrix3d& m) {
  btMatrix3x3 basis;
  for (int row = 0; row < 3; ++row) basis[row] = ToBullet(Eigen::Vector3d(m.row(row)));
  return basis;
}

inline Eigen::Vector3d ToEigen(const btVector3& v) {
  return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
}

inline Eigen::Matrix3d ToEigen(const btMatrix3x3& m) {
  Eigen::Matrix3d matrix;
  for (int row = 0; row < 3; ++row) matrix.row(row) = ToEigen(m[row]);
  return matrix;
}

inline Eigen::Quaterniond ToEigen(const btQuaternion& q) {
  return Eigen::Quaterniond(static_cast<double>(q.w()), static_cast<double>(q.x()),
                            static_cast<double>(q.y()), static_cast<double>(q.z()));
}

inline objects::Pose ToPose(const btTransform& pose) {
  return {ToEigen(pose.getOrigin()), ToEigen(pose.getRotation()).normalized()};
}

/// The pose of a body, converted to a quaternion in double precision.
inline objects::Pose ExactPose(const btCollisionObject& body) {
  const btTransform& pose = body.getWorldTransform();
  return {ToEigen(pose.getOrigin()), Eigen::Quaterniond(ToEigen(pose.getBasis())).normalized()};
}

inline bool IsFinite(const btVector3& v) {
  return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z());
}

/// `v` rounded to Bullet's precision. Goes through memory, because GCC 12 at -O2 replaces
/// ToEigen(ToBullet(v)) by v: its vectorizer drops the rounding.
inline Eigen::Vector3d RoundedForBullet(const Eigen::Vector3d& v) {
  Eigen::Vector3d rounded;
  for (int axis = 0; axis < 3; ++axis) {
    const volatile btScalar component = static_cast<btScalar>(v[axis]);
    rounded[axis] = static_cast<double>(component);
  }
  return rounded;
}

/// A frame at `origin` with x along `line`, a unit vector; that of the world if it is 0.
inline btTransform FrameAlong(const btVector3& line, const btVector3& origin) {
  if (line.isZero()) return btTransform(btMatrix3x3::getIdentity(), origin);
  btVector3 y, z;
  btPlaneSpace1(line, y, z);
  return btTransform(
      btMatrix3x3(line.x(), y.x(), z.x(), line.y(), y.y(), z.y(), line.z(), y.z(), z.z()), origin);
}

}  // namespace cdb::world
