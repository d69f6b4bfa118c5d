// A convex piece of a body as collision libraries ask for it: the point that is farthest in a
// direction.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "library/detectors/detector.h"

namespace cdb::third_party {

inline Eigen::Vector3d ToEigen(const Vec3& v) { return {v.x, v.y, v.z}; }
inline Vec3 FromEigen(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// The body's axes as columns.
Eigen::Matrix3d AxesOf(const Pose& pose);

/// 1 but for compounds.
std::size_t PieceCount(const Shape& shape);

/// The point of the piece, in the body's frame, that is farthest along `direction`, of any length.
/// Not for planes.
Eigen::Vector3d PieceSupport(const Shape& shape, std::size_t piece,
                             const Eigen::Vector3d& direction);

/// A point inside the piece, in the body's frame.
Eigen::Vector3d PieceCentre(const Shape& shape, std::size_t piece);

/// m: of the straight half of a capsule; its caps are as high as they are wide, and it is an
/// ellipsoid, and this 0, where it is no higher than wide.
double StraightHalf(const Shape& shape);

/// A piece in the world.
struct PlacedPiece {
  const Shape* shape;
  std::size_t piece;
  Eigen::Vector3d at;
  Eigen::Matrix3d axes;

  PlacedPiece(const Scene& scene, Id body, std::size_t of);
  Eigen::Vector3d Support(const Eigen::Vector3d& direction) const {
    return at + axes * PieceSupport(*shape, piece, axes.transpose() * direction);
  }
  Eigen::Vector3d Centre() const { return at + axes * PieceCentre(*shape, piece); }
};

/// Where two pieces meet that are nearest, or overlap the least, along `normal` (unit, from b to
/// a): a point on both of the faces, edges or corners that they turn to each other, halfway between
/// them. For libraries that say how deep and which way, but not where.
Eigen::Vector3d MeetingPoint(const PlacedPiece& a, const PlacedPiece& b,
                             const Eigen::Vector3d& normal);

}  // namespace cdb::third_party
