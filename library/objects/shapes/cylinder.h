// `cylinder`: along y, with an elliptic base.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "compiler/schema/catalogue_table.h"
#include "library/detectors/detector.h"
#include "library/objects/shapes/support.h"
#include "library/objects/shapes/triangles.h"

namespace cdb::shapes {

struct Cylinder {
  static constexpr schema::ObjectTypeRef kType = "cylinder";

  static double Volume(const Eigen::Vector3d& sides) { return sides.prod() * std::numbers::pi / 4; }
  static Eigen::Vector3d SecondMoments(const Eigen::Vector3d& sides) {
    const Eigen::Vector3d square = sides.cwiseAbs2();
    return {square.x() / 16, square.y() / 12, square.z() / 16};
  }
  template <typename Points, typename Vector, typename Real>
  static Vector Support(const Points& points, const Vector& half, Real /*offset*/,
                        const Vector& direction) {
    const Vector rim = points.Ellipse(half, direction);
    return Vector(rim.x(), points.Corner(half, direction).y(), rim.z());
  }
  static double InnerRadius(const Eigen::Vector3d& sides) { return (sides / 2).minCoeff(); }
  static double OuterRadius(const Eigen::Vector3d& sides) {
    const Eigen::Vector3d half = sides / 2;
    return std::hypot(std::max(half.x(), half.z()), half.y());
  }
  static bool Contains(const Eigen::Vector3d& sides, const Eigen::Vector3d& point) {
    return std::abs(point.y()) <= sides.y() / 2 && SquareAcross(point, sides / 2) <= 1;
  }
  static ShapeKind KindOf(const Eigen::Vector3d& /*sides*/) { return ShapeKind::kCylinder; }
  static Profile Side() { return {{0.5, -0.5, 1, 0}, {0.5, 0.5, 1, 0}}; }
  static std::vector<Profile> Profiles(int /*segments*/) {
    return {Side(), {{0, -0.5, 0, -1}, {0.5, -0.5, 0, -1}}, {{0.5, 0.5, 0, 1}, {0, 0.5, 0, 1}}};
  }
};

}  // namespace cdb::shapes
