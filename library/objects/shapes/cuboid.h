// `cuboid`: a box.
#pragma once

#include "compiler/schema/catalogue_table.h"
#include "library/detectors/detector.h"
#include "library/objects/shapes/support.h"
#include "library/objects/shapes/triangles.h"

namespace cdb::shapes {

struct Cuboid {
  static constexpr schema::ObjectTypeRef kType = "cuboid";

  static double Volume(const Eigen::Vector3d& sides) { return sides.prod(); }
  static Eigen::Vector3d SecondMoments(const Eigen::Vector3d& sides) {
    return sides.cwiseAbs2() / 12;
  }
  template <typename Points, typename Vector, typename Real>
  static Vector Support(const Points& points, const Vector& half, Real /*offset*/,
                        const Vector& direction) {
    return points.Corner(half, direction);
  }
  static double InnerRadius(const Eigen::Vector3d& sides) { return (sides / 2).minCoeff(); }
  static double OuterRadius(const Eigen::Vector3d& sides) { return (sides / 2).stableNorm(); }
  static bool Contains(const Eigen::Vector3d& sides, const Eigen::Vector3d& point) {
    return (point.cwiseAbs().array() <= (sides / 2).array()).all();
  }
  static ShapeKind KindOf(const Eigen::Vector3d& /*sides*/) { return ShapeKind::kBox; }
  /// Of the box with sides 1.
  static std::vector<FlatFace> Faces() {
    using Eigen::Vector3d;
    std::vector<FlatFace> faces;
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-0.5, 0.5}) {
        const Vector3d out = sign * Vector3d::Unit(axis);
        const Vector3d u = 0.5 * Vector3d::Unit((axis + 1) % 3);
        const Vector3d v = 2 * sign * 0.5 * Vector3d::Unit((axis + 2) % 3);
        faces.push_back({out - u - v, out + u - v, out + u + v, out - u + v});
      }
    return faces;
  }
};

}  // namespace cdb::shapes
