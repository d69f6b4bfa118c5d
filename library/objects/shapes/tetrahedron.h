// `tetrahedron`: at every other corner of its box; regular if the sides are equal.
#pragma once

#include <algorithm>
#include <array>
#include <utility>

#include "compiler/schema/catalogue_table.h"
#include "library/detectors/detector.h"
#include "library/objects/shapes/support.h"
#include "library/objects/shapes/triangles.h"

namespace cdb::shapes {

struct Tetrahedron {
  static constexpr schema::ObjectTypeRef kType = "tetrahedron";

  static double Volume(const Eigen::Vector3d& sides) { return sides.prod() / 3; }
  static Eigen::Vector3d SecondMoments(const Eigen::Vector3d& sides) {
    return sides.cwiseAbs2() / 20;  // the sum of the squared corners divided by 20
  }

  /// The scalar products of a direction with the corners: with the one in the octant of all
  /// positive coordinates, and with those of which only one coordinate is positive.
  template <typename Vector>
  static auto CornerDots(const Vector& half, const Vector& direction) {
    const Vector at(half.x() * direction.x(), half.y() * direction.y(), half.z() * direction.z());
    return std::array{at.dot(Vector(1, 1, 1)), at.dot(Vector(1, -1, -1)), at.dot(Vector(-1, 1, -1)),
                      at.dot(Vector(-1, -1, 1))};
  }
  /// The first corner that is farthest. Looked up, as branches could not be predicted.
  template <typename Points, typename Vector, typename Real>
  static Vector Support(const Points& /*points*/, const Vector& half, Real /*offset*/,
                        const Vector& direction) {
    static constexpr Real kAll[] = {1, 1, 1}, kX[] = {1, -1, -1}, kY[] = {-1, 1, -1},
                          kZ[] = {-1, -1, 1};
    /// By whether the product of x, of y and of z exceeds those before it.
    static constexpr const Real* kCorners[] = {kAll, kX, kY, kY, kZ, kZ, kZ, kZ};
    const auto [all, x, y, z] = CornerDots(half, direction);
    const Real most = std::max(all, x);
    const unsigned exceeding =
        unsigned{x > all} | unsigned{y > most} << 1 | unsigned{z > std::max(most, y)} << 2;
    const Real* sign = kCorners[exceeding];
    return Vector(sign[0] * half.x(), sign[1] * half.y(), sign[2] * half.z());
  }
  template <typename Points, typename Vector, typename Real>
  static std::pair<Real, Real> Extent(const Points& /*points*/, const Vector& half, Real /*offset*/,
                                      const Vector& direction) {
    const auto [all, x, y, z] = CornerDots(half, direction);
    return std::minmax({all, x, y, z});
  }
  static double InnerRadius(const Eigen::Vector3d& sides) {
    return 1 / (sides / 2).cwiseInverse().norm();
  }
  static double OuterRadius(const Eigen::Vector3d& sides) { return (sides / 2).stableNorm(); }
  static bool Contains(const Eigen::Vector3d& sides, const Eigen::Vector3d& point) {
    const Eigen::Vector3d p = point.cwiseQuotient(sides / 2);
    return p.x() + p.y() - p.z() <= 1 && p.x() - p.y() + p.z() <= 1 &&
           -p.x() + p.y() + p.z() <= 1 && -p.sum() <= 1;
  }
  static ShapeKind KindOf(const Eigen::Vector3d& /*sides*/) { return ShapeKind::kHull; }
  /// Of the tetrahedron in the box with sides 1.
  static std::vector<FlatFace> Faces() {
    const Eigen::Vector3d all(0.5, 0.5, 0.5), x(0.5, -0.5, -0.5), y(-0.5, 0.5, -0.5),
        z(-0.5, -0.5, 0.5);
    return {{all, x, y}, {all, y, z}, {all, z, x}, {x, z, y}};
  }
};

}  // namespace cdb::shapes
