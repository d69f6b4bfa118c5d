// `sphere`: an ellipsoid, a ball if the sides are equal.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "compiler/schema/catalogue_table.h"
#include "library/detectors/detector.h"
#include "library/objects/shapes/support.h"
#include "library/objects/shapes/triangles.h"

namespace cdb::shapes {

struct Ellipsoid {
  static constexpr schema::ObjectTypeRef kType = "sphere";

  static double Volume(const Eigen::Vector3d& sides) { return sides.prod() * std::numbers::pi / 6; }
  static Eigen::Vector3d SecondMoments(const Eigen::Vector3d& sides) {
    return sides.cwiseAbs2() / 20;
  }
  template <typename Points, typename Vector, typename Real>
  static Vector Support(const Points& points, const Vector& half, Real /*offset*/,
                        const Vector& direction) {
    return points.Ellipsoid(half, direction);
  }
  static double InnerRadius(const Eigen::Vector3d& sides) { return (sides / 2).minCoeff(); }
  static double OuterRadius(const Eigen::Vector3d& sides) { return (sides / 2).maxCoeff(); }
  static double LeastRadiusOfCurvature(const Eigen::Vector3d& sides) {
    const double least = sides.minCoeff() / 2, most = sides.maxCoeff() / 2;
    return least == most ? most : least / most * least;
  }
  static bool Contains(const Eigen::Vector3d& sides, const Eigen::Vector3d& point) {
    return point.cwiseQuotient(sides / 2).squaredNorm() <= 1;
  }
  static ShapeKind KindOf(const Eigen::Vector3d& /*sides*/) { return ShapeKind::kEllipsoid; }
  static std::vector<Profile> Profiles(int segments) {
    return {Arc(-std::numbers::pi / 2, std::numbers::pi / 2, segments)};
  }

  /// The ball of diameter 1 between two latitudes, rad.
  static Profile Arc(double from, double to, int segments) {
    const int rows = std::max(2, static_cast<int>(std::lround(segments * (to - from) / 6.28)));
    Profile profile;
    for (int i = 0; i <= rows; ++i) {
      const double latitude = from + (to - from) * i / rows;
      const bool is_pole = std::abs(latitude) > 1.5707;
      const double x = is_pole ? 0 : std::cos(latitude), y = std::sin(latitude);
      profile.push_back({x / 2, y / 2, x, y});
    }
    return profile;
  }
};

}  // namespace cdb::shapes
