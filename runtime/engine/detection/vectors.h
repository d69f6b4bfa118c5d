// Bullet's vectors as the detector interface has them.
#pragma once

#include <btBulletDynamicsCommon.h>

#include "library/detectors/detector.h"

namespace cdb::detection {

/// Exact: a float is a double too.
inline Vec3 ToVec3(const btVector3& v) {
  return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
}

}  // namespace cdb::detection
