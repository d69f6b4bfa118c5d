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
  if (!solid.compound)
    return objects::Visit(solid.shape,
                          [&](auto form) { return form.Contains(solid.sides, point); });
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
