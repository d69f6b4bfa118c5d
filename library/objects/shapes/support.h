// Support points that several shapes share. A shape's support is a template of such a class, so
// that the engine has its own in its own precision.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace cdb::shapes {

/// In double. `half`: half extents along the axes.
struct ExactPoints {
  using Vector3d = Eigen::Vector3d;

  /// The point of an ellipsoid that is farthest along `direction`.
  static Vector3d Ellipsoid(const Vector3d& half, const Vector3d& direction) {
    const Vector3d scaled = half.cwiseProduct(direction);
    const double length = scaled.stableNorm();
    if (length == 0) return {half.x(), 0, 0};
    return half.cwiseProduct(scaled) / length;
  }
  /// The same of an ellipse in the x-z plane.
  static Vector3d Ellipse(const Vector3d& half, const Vector3d& direction) {
    const double x = half.x() * direction.x();
    const double z = half.z() * direction.z();
    const double length = std::hypot(x, z);
    if (length == 0) return {half.x(), 0, 0};
    return {half.x() * x / length, 0, half.z() * z / length};
  }
  /// The same of a box.
  static Vector3d Corner(const Vector3d& half, const Vector3d& direction) {
    return {std::copysign(half.x(), direction.x()), std::copysign(half.y(), direction.y()),
            std::copysign(half.z(), direction.z())};
  }
};

/// The squared distance of a point from the y axis, in half axes of an elliptic section.
inline double SquareAcross(const Eigen::Vector3d& point, const Eigen::Vector3d& half) {
  return std::pow(point.x() / half.x(), 2) + std::pow(point.z() / half.z(), 2);
}

}  // namespace cdb::shapes
