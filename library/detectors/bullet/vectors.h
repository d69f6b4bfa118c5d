// Conversion of vectors between the detector interface and Bullet.
#pragma once

#include <LinearMath/btVector3.h>

#include "library/detectors/detector.h"

namespace cdb::bullet {

/// Rounds if Bullet is in single precision.
inline btVector3 ToBullet(const Vec3& v) {
  return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}

/// Exact.
inline Vec3 ToVec3(const btVector3& v) {
  return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
}

}  // namespace cdb::bullet
