// `superellipsoid`: |y/b|^(2/e1) + (|x/a|^(2/e2) + |z/c|^(2/e2))^(e2/e1) <= 1, with the axis along
// y. The exponents are the e1 and e2 of Barr, Superquadrics and Angle-Preserving Transformations,
// IEEE Computer Graphics and Applications 1 (1981); it is convex for 0 < e <= 2.
//
// It is the unit ball of a norm: that of x and z with 2/e2, and of this and y with 2/e1. Its
// heights are the dual norm, with the exponents 2/(2 - e). Volume and moments: Jaklič, Leonardis,
// Solina, Segmentation and Recovery of Superquadrics, 2000, section 2.4.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "compiler/schema/catalogue_table.h"
#include "library/detectors/detector.h"
#include "library/objects/shapes/super_norm.h"
#include "library/objects/shapes/support.h"
#include "library/objects/shapes/triangles.h"

namespace cdb::shapes {

struct Superellipsoid {
  static constexpr schema::ObjectTypeRef kType = "superellipsoid";

  double e1 = 1, e2 = 1;

  double Volume(const Eigen::Vector3d& sides) const {
    return sides.prod() * schema::SuperellipsoidFill(e1, e2);
  }
  Eigen::Vector3d SecondMoments(const Eigen::Vector3d& sides) const {
    // Beta functions, with the poles at 0 taken out.
    const auto gamma = [](double x) { return std::tgamma(x + 1); };
    const double part = 1 / (12 * schema::SuperellipsoidFill(e1, e2));
    const double across = part * gamma(1.5 * e2) * gamma(e2 / 2) / gamma(2 * e2) * gamma(e1 / 2) *
                          gamma(2 * e1) / gamma(2.5 * e1);
    const double along = part * gamma(e2 / 2) * gamma(e2 / 2) / gamma(e2) * gamma(1.5 * e1) *
                         gamma(e1) / gamma(2.5 * e1);
    return sides.cwiseAbs2().cwiseProduct(Eigen::Vector3d(across, along, across));
  }
  template <typename Points, typename Vector, typename Real>
  Vector Support(const Points& /*points*/, const Vector& half, Real /*offset*/,
                 const Vector& direction) const {
    const auto [x, y, z] = FarthestOfSuperNorm<Real>(
        half.x() * direction.x(), half.y() * direction.y(), half.z() * direction.z(),
        static_cast<Real>(e1), static_cast<Real>(e2));
    return Vector(half.x() * x, half.y() * y, half.z() * z);
  }
  double InnerRadius(const Eigen::Vector3d& sides) const {
    const Eigen::Vector3d half = sides / 2;
    return Nearest(Nearest(half.x(), half.z(), e2), half.y(), e1);
  }
  double OuterRadius(const Eigen::Vector3d& sides) const {
    const Eigen::Vector3d half = sides / 2;
    return Farthest(Farthest(half.x(), half.z(), e2), half.y(), e1);
  }
  /// The norm whose unit ball it is.
  double NormOf(const Eigen::Vector3d& sides, const Eigen::Vector3d& point) const {
    const Eigen::Vector3d scaled = point.cwiseQuotient(sides / 2);
    return SuperNorm(scaled.x(), scaled.y(), scaled.z(), e1, e2);
  }
  bool Contains(const Eigen::Vector3d& sides, const Eigen::Vector3d& point) const {
    return NormOf(sides, point) <= 1;
  }
  static ShapeKind KindOf(const Eigen::Vector3d& /*sides*/) { return ShapeKind::kSuperellipsoid; }

  /// Points of |u|^(2/e) + |v|^(2/e) = 1 from (1, 0) to (0, 1), with their normals: at even angles,
  /// and where the normals are at even angles.
  static Profile Quadrant(double e, int steps) {
    std::vector<std::array<double, 2>> points;
    for (int i = 0; i <= steps; ++i) {
      const double angle = std::numbers::pi / 2 * i / steps;
      const double u = i == steps ? 0 : std::cos(angle), v = i == 0 ? 0 : std::sin(angle);
      const double norm = SuperNorm(u, v, e);
      points.push_back({u / norm, v / norm});
      const auto [far_u, far_v] = FarthestOfSuperNorm(u, v, e);
      points.push_back({far_u, far_v});
    }
    std::ranges::sort(points,
                      [](const auto& a, const auto& b) { return a[1] * b[0] < b[1] * a[0]; });
    Profile profile;
    for (const auto& [u, v] : points) {
      if (!profile.empty() && std::hypot(u - profile.back().x, v - profile.back().y) < 1e-3)
        continue;
      const double out_u = std::pow(u, 2 / e - 1), out_v = std::pow(v, 2 / e - 1),
                   length = std::hypot(out_u, out_v);
      profile.push_back({u, v, out_u / length, out_v / length});
    }
    return profile;
  }

 private:
  /// (a^k + b^k)^(1/k) for k = 2/(1 - e): by Hölder's inequality the greatest distance of its
  /// section from the centre if k is positive, and the least one otherwise.
  static double Extreme(double a, double b, double e) {
    const double k = 2 / (1 - e), by = k > 0 ? std::max(a, b) : std::min(a, b);
    return by * std::pow(std::pow(a / by, k) + std::pow(b / by, k), 1 / k);
  }
  static double Nearest(double a, double b, double e) {
    return e > 1 ? Extreme(a, b, e) : std::min(a, b);
  }
  static double Farthest(double a, double b, double e) {
    return e < 1 ? Extreme(a, b, e) : std::max(a, b);
  }
};

}  // namespace cdb::shapes
