// A convex part of a solid, for the search for signed distances: a core and a ball that rolls
// around it.
//
// A ball is a point and its radius, a round capsule a segment and its radius; any ellipsoid is the
// Minkowski sum of a smaller body and a ball of its least radius of curvature. Distances of cores
// differ from those of the bodies by exactly the sum of the radii, and the flatter or the smaller
// the core, the fewer directions have to be searched.
#pragma once

#include <Eigen/Core>

#include "library/objects/solid.h"

namespace cdb::exact {

/// Refers to the solid, which must outlive it. Threads: any.
class ConvexPart {
 public:
  /// `piece`: of a compound or a surface, 0 for other solids.
  ConvexPart(const objects::Solid& solid, std::size_t piece, const Eigen::Matrix3d& turn,
             const Eigen::Vector3d& position);

  /// m: of the ball.
  double radius() const { return radius_; }
  /// The point of the core farthest along the unit vector.
  Eigen::Vector3d CoreSupport(const Eigen::Vector3d& direction) const {
    const Eigen::Vector3d local = turn_.transpose() * direction;
    return position_ + turn_ * (solid_.PieceSupport(piece_, local) - radius_ * local);
  }

 private:
  const objects::Solid& solid_;
  const std::size_t piece_;
  const Eigen::Matrix3d& turn_;
  const Eigen::Vector3d position_;
  const double radius_;
};

}  // namespace cdb::exact
