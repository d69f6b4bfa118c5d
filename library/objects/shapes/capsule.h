// `capsule`: along y: a cylinder between two halves of an ellipsoid, which are as high as they are
// wide. If it is no higher than wide, it is an ellipsoid.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "compiler/schema/catalogue_table.h"
#include "library/detectors/detector.h"
#include "library/objects/shapes/ellipsoid.h"
#include "library/objects/shapes/support.h"
#include "library/objects/shapes/triangles.h"

namespace cdb::shapes {

struct Capsule {
  static constexpr schema::ObjectTypeRef kType = "capsule";

  /// Half height of the straight part.
  static double StraightHalf(const Eigen::Vector3d& sides) {
    const Eigen::Vector3d half = sides / 2;
    return half.y() - std::min(half.y(), std::sqrt(half.x() * half.z()));
  }

  static double Volume(const Eigen::Vector3d& sides) {
    const double straight = StraightHalf(sides) / sides.y() * 2;  // as a fraction of the height
    return sides.prod() * std::numbers::pi * (straight / 4 + (1 - straight) / 6);
  }
  static Eigen::Vector3d SecondMoments(const Eigen::Vector3d& sides) {
    // Per area of the middle cross-section: the straight part, and both caps, whose centres of
    // mass are 3/8 of their height above the ends of the straight part.
    const double straight = StraightHalf(sides), cap = sides.y() / 2 - straight;
    const double middle = 2 * straight, caps = 4 * cap / 3;
    const double along = middle * straight * straight / 3 +
                         caps * (cap * cap / 5 + 3 * cap * straight / 4 + straight * straight);
    Eigen::Vector3d moment = sides.cwiseAbs2() * (middle / 16 + caps / 20) / (middle + caps);
    moment.y() = along / (middle + caps);
    return moment;
  }
  static double Offset(const Eigen::Vector3d& sides) { return StraightHalf(sides); }
  template <typename Points, typename Vector, typename Real>
  static Vector Support(const Points& points, const Vector& half, Real straight,
                        const Vector& direction) {
    const Vector caps(half.x(), half.y() - straight, half.z());
    const Vector point = points.Ellipsoid(caps, direction);
    const Vector end = points.Corner(Vector(0, straight, 0), direction);
    return Vector(point.x(), point.y() + end.y(), point.z());
  }
  static double InnerRadius(const Eigen::Vector3d& sides) { return (sides / 2).minCoeff(); }
  static double OuterRadius(const Eigen::Vector3d& sides) {
    // The support of (across sin t, straight + cap cos t), if the tip is not the farthest point.
    const Eigen::Vector3d half = sides / 2;
    const double across = std::max(half.x(), half.z());
    const double straight = StraightHalf(sides), cap = half.y() - straight;
    const double cosine = cap * straight / (across * across - cap * cap);
    if (!(across > cap) || cosine >= 1) return half.y();
    return std::hypot(across * std::sqrt(1 - cosine * cosine), straight + cap * cosine);
  }
  static double LeastRadiusOfCurvature(const Eigen::Vector3d& sides) {
    return Ellipsoid::LeastRadiusOfCurvature(
        {sides.x(), sides.y() - 2 * StraightHalf(sides), sides.z()});
  }
  static bool Contains(const Eigen::Vector3d& sides, const Eigen::Vector3d& point) {
    const Eigen::Vector3d half = sides / 2;
    const double straight = StraightHalf(sides);
    const double beyond = std::max(0.0, std::abs(point.y()) - straight) / (half.y() - straight);
    return SquareAcross(point, half) + beyond * beyond <= 1;
  }
  static ShapeKind KindOf(const Eigen::Vector3d& sides) {
    return StraightHalf(sides) > 0 ? ShapeKind::kCapsule : ShapeKind::kEllipsoid;
  }
};

}  // namespace cdb::shapes
