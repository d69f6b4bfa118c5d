#include "runtime/engine/probes/solid_core.h"

#include <algorithm>
#include <cmath>

#include "library/objects/overlap.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;
using objects::Shape;
using objects::Solid;

/// Thickness of a path or of a point, relative to the length beside it.
constexpr double kThin = 1e-6;

/// Squared distance from the axis, in half axes of the elliptic section.
double SquareAcross(const Vector3d& point, const Vector3d& half) {
  return std::pow(point.x() / half.x(), 2) + std::pow(point.z() / half.z(), 2);
}

/// The shortest rotation of the y axis to `direction`. The same formula as in Eigen's
/// FromTwoVectors, which takes seconds to compile because it decomposes singular values where the
/// vectors are opposite.
Eigen::Quaterniond FromYAxisTo(const Vector3d& direction) {
  constexpr double kOpposite = 1e-12;
  const Vector3d to = direction.normalized();
  if (to.y() < -1 + kOpposite) return {0, 1, 0, 0};
  const double s = std::sqrt((1 + to.y()) * 2);
  Eigen::Quaterniond rotation;
  rotation.vec() = Vector3d::UnitY().cross(to) * (1 / s);
  rotation.w() = s * 0.5;
  return rotation;
}

}  // namespace

bool Contains(const Solid& solid, const Vector3d& point) {
  const Vector3d half = solid.HalfExtents();
  switch (solid.shape) {
    case Shape::kEllipsoid:
      return point.cwiseQuotient(half).squaredNorm() <= 1;
    case Shape::kCuboid:
      return (point.cwiseAbs().array() <= half.array()).all();
    case Shape::kCylinder:
      return std::abs(point.y()) <= half.y() && SquareAcross(point, half) <= 1;
    case Shape::kCone: {
      const double left = 0.75 - point.y() / solid.sides.y();  // distance to the tip over the
                                                               // height
      return left >= 0 && left <= 1 && SquareAcross(point, half) <= left * left;
    }
    case Shape::kCapsule: {
      const double straight = solid.StraightHalf();
      const double beyond = std::max(0.0, std::abs(point.y()) - straight) / (half.y() - straight);
      return SquareAcross(point, half) + beyond * beyond <= 1;
    }
    case Shape::kTetrahedron:
    case Shape::kCompound:
      break;
  }
  if (point.norm() > solid.OuterRadius()) return false;
  const Solid dot{Shape::kEllipsoid, Vector3d::Constant(kThin * 2 * solid.LeastHalfExtent())};
  return objects::Overlap(solid, {}, dot, {point, Eigen::Quaterniond::Identity()});
}

bool MeetsPath(const Solid& solid, const Vector3d& from, const Vector3d& to, double radius) {
  const double length = (to - from).norm();
  const double width = 2 * std::max(radius, kThin * length);
  if (!(width > 0)) return Contains(solid, from);
  const Solid path{Shape::kCapsule, {width, length + 2 * radius, width}};
  const Eigen::Quaterniond along =
      length > 0 ? FromYAxisTo(to - from) : Eigen::Quaterniond::Identity();
  return objects::Overlap(solid, {}, path, {(from + to) / 2, along});
}

Solid CoreOf(const Solid& solid, double part) {
  Solid core = solid;
  if (solid.shape != Shape::kCompound) core.sides.array() -= part * solid.sides.minCoeff();
  return core;
}

}  // namespace cdb::probes
