// Support functions of the convex pieces of a body, in the form that collision libraries need.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "library/detectors/detector.h"

namespace cdb::third_party {

inline Eigen::Vector3d ToEigen(const Vec3& v) { return {v.x, v.y, v.z}; }
inline Vec3 FromEigen(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// The body's axes as columns.
Eigen::Matrix3d AxesOf(const Pose& pose);

/// 1 except for compounds.
std::size_t PieceCount(const Shape& shape);

/// The point of the piece, in the body's frame, that is farthest along `direction`, of any length.
/// Not for planes.
Eigen::Vector3d PieceSupport(const Shape& shape, std::size_t piece,
                             const Eigen::Vector3d& direction);

/// A point inside the piece, in the body's frame.
Eigen::Vector3d PieceCentre(const Shape& shape, std::size_t piece);

/// m: half height of the straight part of a capsule. Its caps are as tall as they are wide; if the
/// capsule is no taller than wide, it is an ellipsoid and this is 0.
double StraightHalf(const Shape& shape);

/// A piece in world coordinates.
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

/// The contact point of two pieces whose minimum distance or penetration is along `normal` (unit,
/// from b to a): a point common to the facing features, halfway between them. For libraries that
/// return only depth and normal.
Eigen::Vector3d MeetingPoint(const PlacedPiece& a, const PlacedPiece& b,
                             const Eigen::Vector3d& normal);

}  // namespace cdb::third_party
