// The signed distance of two bodies, with a proof: the referee of contacts. In double, without any
// physics engine.
//
// The signed distance of two convex parts is their distance, or minus the length of the shortest
// translation that separates them. That of compounds and surfaces is the least of two of their
// convex parts, as contacts are. Two surfaces have none. Lengths in m. Threads: any.
#pragma once

#include <Eigen/Core>
#include <limits>

#include "library/objects/solid.h"

namespace cdb::exact {

struct SignedDistance {
  /// It is in [lower, upper]. Lower: the gap along `normal`, which is negative if they overlap
  /// along it, less the rounding errors, and less by a tolerance if other parts are equally close.
  /// Upper: if positive, the distance of the points on_a and on_b; otherwise no shorter translation
  /// separates the parts (least_height.h), and the points are the same.
  double lower = 0, upper = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, from b to a
  Eigen::Vector3d on_a = Eigen::Vector3d::Zero(), on_b = Eigen::Vector3d::Zero();
  std::size_t piece_a = 0, piece_b = 0;  ///< the convex parts; 0 with a half space
  /// The least of two other parts with another normal, if it is an overlap at least nine tenths as
  /// deep.
  double rival = std::numeric_limits<double>::infinity();

  /// True if one of the two is a surface around solid cells, and a part of the other is in these
  /// without meeting a triangle. The bodies then overlap by an unknown depth; the distance is that
  /// of the triangles.
  bool is_inside = false;

  /// m: the gap along `normal` as computed, which is the best estimate; its negative is the depth.
  double gap = 0;

  double Depth() const { return -gap; }
  /// True if it is known to a billionth of `size`.
  bool IsTight(double size) const { return upper - lower <= 1e-9 * size; }
};

/// If the two are farther apart than `reach`, only that is known: lower is at least `reach`.
SignedDistance DistanceOf(const objects::Solid& a, const objects::Pose& pose_a,
                          const objects::Solid& b, const objects::Pose& pose_b,
                          double reach = std::numeric_limits<double>::infinity());

/// {x : normal . x <= offset}, its normal unit.
struct HalfSpace {
  Eigen::Vector3d normal;
  double offset;
};

SignedDistance DistanceOf(const objects::Solid& a, const objects::Pose& pose_a, const HalfSpace& b);

/// Whether only translations along about the same normal separate the two if none may be longer
/// than their depth by more than this fraction, which is at most a tenth if one has several pieces.
/// `distance`: theirs.
bool HasOneNormal(const objects::Solid& a, const objects::Pose& pose_a, const objects::Solid& b,
                  const objects::Pose& pose_b, const SignedDistance& distance, double fraction);

// A convex part of a solid, for the search for signed distances: a core and a ball that rolls
// around it.
//
// A ball is a point and its radius, a round capsule a segment and its radius; any ellipsoid is the
// Minkowski sum of a smaller body and a ball of its least radius of curvature. Distances of cores
// differ from those of the bodies by exactly the sum of the radii, and the flatter or the smaller
// the core, the fewer directions have to be searched.

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
