// `cone`: along y, apex up, with an elliptic base. Its centre of mass is a quarter of its height
// above the base.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "compiler/schema/catalogue_table.h"
#include "library/detectors/detector.h"
#include "library/objects/shapes/support.h"
#include "library/objects/shapes/triangles.h"

namespace cdb::shapes {

struct Cone {
  static constexpr schema::ObjectTypeRef kType = "cone";

  static double BoxCentre(const Eigen::Vector3d& sides) { return sides.y() / 4; }
  static double Volume(const Eigen::Vector3d& sides) {
    return sides.prod() * std::numbers::pi / 12;
  }
  static Eigen::Vector3d SecondMoments(const Eigen::Vector3d& sides) {
    // 3/20 r^2 across; 3/80 h^2 along the axis, about the centre of mass.
    const Eigen::Vector3d square = sides.cwiseAbs2();
    return {square.x() * 3 / 80, square.y() * 3 / 80, square.z() * 3 / 80};
  }
  static double Offset(const Eigen::Vector3d& sides) { return BoxCentre(sides); }
  template <typename Points, typename Vector, typename Real>
  static Vector Support(const Points& points, const Vector& half, Real centre,
                        const Vector& direction) {
    const Vector tip(0, centre + half.y(), 0);
    const Vector on_base = points.Ellipse(half, direction);
    const Vector rim(on_base.x(), centre - half.y(), on_base.z());
    return direction.dot(tip) > direction.dot(rim) ? tip : rim;
  }
  template <typename Points, typename Vector, typename Real>
  static std::pair<Real, Real> Extent(const Points& points, const Vector& half, Real centre,
                                      const Vector& direction) {
    const Real tip = direction.y() * (centre + half.y());
    const Real base = direction.y() * (centre - half.y());
    const Vector rim = points.Ellipse(half, direction);
    const Real x = direction.x() * rim.x(), z = direction.z() * rim.z();
    return {std::min(-x + base - z, tip), std::max(x + base + z, tip)};
  }
  /// Of the circular cone in it.
  static double InnerRadius(const Eigen::Vector3d& sides) {
    const double radius = std::min(sides.x(), sides.z()) / 2;
    const double height = sides.y();
    const double to_side = 0.75 * height * radius / std::hypot(radius, height);
    return std::min(height / 4, to_side);
  }
  static double OuterRadius(const Eigen::Vector3d& sides) {
    const Eigen::Vector3d half = sides / 2;
    return std::max(0.75 * sides.y(), std::hypot(std::max(half.x(), half.z()), sides.y() / 4));
  }
  static bool Contains(const Eigen::Vector3d& sides, const Eigen::Vector3d& point) {
    const double left = 0.75 - point.y() / sides.y();  // distance to the tip over the height
    return left >= 0 && left <= 1 && SquareAcross(point, sides / 2) <= left * left;
  }
  static ShapeKind KindOf(const Eigen::Vector3d& /*sides*/) { return ShapeKind::kCone; }
  static std::vector<Profile> Profiles(int /*segments*/) {
    const double slope = 1 / std::sqrt(5.0);  // the side rises by 2 per unit of radius
    return {{{0, -0.25, 0, -1}, {0.5, -0.25, 0, -1}},
            {{0.5, -0.25, 2 * slope, slope}, {0, 0.75, 2 * slope, slope}}};
  }
};

}  // namespace cdb::shapes
