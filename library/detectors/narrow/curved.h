// Support points of pieces with curved surfaces: ellipsoids, cylinders, cones and capsules on an
// ellipse.
#pragma once

#include <algorithm>
#include <cmath>

#include "library/detectors/narrow/pieces.h"

namespace cdb::narrow {

/// The half axes of an ellipse or ellipsoid and a direction.
struct Scaled {
  Vec3 half, scaled;
  double length;  ///< how far the ellipse extends along the direction

  Scaled(const Vec3& axes, const Vec3& direction)
      : half(axes),
        scaled{axes.x * direction.x, axes.y * direction.y, axes.z * direction.z},
        length(Norm(scaled)) {}
  /// The farthest point.
  Vec3 Farthest() const {
    if (!(length > 1e-150)) return {half.x, 0, 0};
    const double part = 1 / length;
    return {part * half.x * scaled.x, part * half.y * scaled.y, part * half.z * scaled.z};
  }
};

/// Of the base of a cylinder or cone, about the axis.
inline Scaled RimOf(const Piece& piece, const Vec3& direction) {
  return {{piece.half.x, 0, piece.half.z}, direction};
}

/// The point of a curved piece that is farthest along `direction`.
inline Vec3 FarthestOnCurved(const Piece& piece, const Vec3& direction) {
  if (piece.kind == Kind::kRound) {
    const Vec3 point = Scaled(piece.half, direction).Farthest();
    return {point.x, point.y + std::copysign(piece.straight, direction.y), point.z};
  }
  const Scaled rim = RimOf(piece, direction);
  const double height = piece.half.y, middle = piece.centre.y;
  if (piece.kind == Kind::kCone && 2 * height * direction.y > rim.length)
    return {0, middle + height, 0};
  Vec3 point = rim.Farthest();
  point.y = piece.kind == Kind::kCone ? middle - height : std::copysign(height, direction.y);
  return point;
}

/// How far a curved piece extends along `direction`.
inline double ExtentOfCurved(const Piece& piece, const Vec3& direction) {
  if (piece.kind == Kind::kRound)
    return Scaled(piece.half, direction).length + piece.straight * std::abs(direction.y);
  const double rim = RimOf(piece, direction).length, height = piece.half.y;
  if (piece.kind == Kind::kCylinder) return rim + height * std::abs(direction.y);
  return direction.y * piece.centre.y + std::max(rim - height * direction.y, height * direction.y);
}

}  // namespace cdb::narrow
