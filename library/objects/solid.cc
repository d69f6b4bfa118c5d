#include "library/objects/solid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dsl/text/check.h"

namespace cdb::objects {
namespace {

using Eigen::Vector3d;

/// The point farthest along (x, z) of the ellipse in the x-z plane with these half axes.
Vector3d EllipsePoint(double half_x, double half_z, const Vector3d& direction) {
  const double x = half_x * direction.x();
  const double z = half_z * direction.z();
  const double length = std::hypot(x, z);
  if (length == 0) return {half_x, 0, 0};
  return {half_x * x / length, 0, half_z * z / length};
}

/// The corner farthest along `direction` of the tetrahedron in the cube of side 2.
Vector3d FarthestCorner(const Vector3d& direction) {
  Vector3d farthest = Vector3d::Ones();
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d corner = 2 * Vector3d::Unit(axis) - Vector3d::Ones();
    if (direction.dot(corner) > direction.dot(farthest)) farthest = corner;
  }
  return farthest;
}

}  // namespace

Shape ShapeOf(std::string_view object_type) {
  if (object_type == "sphere") return Shape::kEllipsoid;
  if (object_type == "cuboid") return Shape::kCuboid;
  if (object_type == "cylinder") return Shape::kCylinder;
  if (object_type == "cone") return Shape::kCone;
  if (object_type == "capsule") return Shape::kCapsule;
  if (object_type == "tetrahedron") return Shape::kTetrahedron;
  CDB_CHECK(false);
}

double Solid::StraightHalf() const {
  const Vector3d half = HalfExtents();
  return half.y() - std::min(half.y(), std::sqrt(half.x() * half.z()));
}

double Solid::Volume() const {
  const double box = sides.prod();
  switch (shape) {
    case Shape::kEllipsoid:
      return box * std::numbers::pi / 6;
    case Shape::kCuboid:
      return box;
    case Shape::kCylinder:
      return box * std::numbers::pi / 4;
    case Shape::kCone:
      return box * std::numbers::pi / 12;
    case Shape::kCapsule: {
      const double straight = StraightHalf() / sides.y() * 2;  // as a fraction of the height
      return box * std::numbers::pi * (straight / 4 + (1 - straight) / 6);
    }
    case Shape::kTetrahedron:
      return box / 3;
    case Shape::kCompound:
      return compound->Volume();
  }
  return 0;
}

Vector3d Solid::InertiaPerMass() const {
  // Second moments along each axis, the integral of x^2 over the volume; a moment of inertia is the
  // sum of those along the other two axes.
  const Vector3d square = sides.cwiseAbs2();
  Vector3d moment = Vector3d::Zero();
  switch (shape) {
    case Shape::kEllipsoid:
    case Shape::kTetrahedron:  // the sum of the squared corners divided by 20
      moment = square / 20;
      break;
    case Shape::kCuboid:
      moment = square / 12;
      break;
    case Shape::kCapsule: {
      // Per area of the middle cross-section: the straight part, and both caps, whose centres of
      // mass are 3/8 of their height above the ends of the straight part.
      const double straight = StraightHalf(), cap = sides.y() / 2 - straight;
      const double middle = 2 * straight, caps = 4 * cap / 3;
      const double along = middle * straight * straight / 3 +
                           caps * (cap * cap / 5 + 3 * cap * straight / 4 + straight * straight);
      moment = square * (middle / 16 + caps / 20) / (middle + caps);
      moment.y() = along / (middle + caps);
      break;
    }
    case Shape::kCylinder:
      moment = {square.x() / 16, square.y() / 12, square.z() / 16};
      break;
    case Shape::kCone:
      // 3/20 r^2 across; 3/80 h^2 along the axis, about the centre of mass.
      moment = {square.x() * 3 / 80, square.y() * 3 / 80, square.z() * 3 / 80};
      break;
    case Shape::kCompound:
      return compound->InertiaPerMass();
  }
  return {moment.y() + moment.z(), moment.x() + moment.z(), moment.x() + moment.y()};
}

Vector3d Solid::Support(const Vector3d& direction) const {
  const Vector3d half = HalfExtents();
  switch (shape) {
    case Shape::kEllipsoid: {
      const Vector3d scaled = half.cwiseProduct(direction);
      const double length = scaled.stableNorm();
      if (length == 0) return {half.x(), 0, 0};
      return half.cwiseProduct(scaled) / length;
    }
    case Shape::kCuboid:
      return {std::copysign(half.x(), direction.x()), std::copysign(half.y(), direction.y()),
              std::copysign(half.z(), direction.z())};
    case Shape::kCylinder: {
      Vector3d point = EllipsePoint(half.x(), half.z(), direction);
      point.y() = std::copysign(half.y(), direction.y());
      return point;
    }
    case Shape::kCone: {
      const Vector3d tip(0, 0.75 * sides.y(), 0);
      Vector3d rim = EllipsePoint(half.x(), half.z(), direction);
      rim.y() = -0.25 * sides.y();
      return direction.dot(tip) > direction.dot(rim) ? tip : rim;
    }
    case Shape::kCapsule: {
      const double straight = StraightHalf();
      const Solid caps{Shape::kEllipsoid, sides - Vector3d(0, 2 * straight, 0)};
      return caps.Support(direction) + Vector3d(0, std::copysign(straight, direction.y()), 0);
    }
    case Shape::kTetrahedron:
      return half.cwiseProduct(FarthestCorner(half.cwiseProduct(direction)));
    case Shape::kCompound:
      return compound->Support(direction);
  }
  return Vector3d::Zero();
}

double Solid::InnerRadius() const {
  if (shape == Shape::kCompound) return compound->inner_radius();
  if (shape == Shape::kTetrahedron) return 1 / HalfExtents().cwiseInverse().norm();
  if (shape != Shape::kCone) return HalfExtents().minCoeff();
  const double radius = std::min(sides.x(), sides.z()) / 2;
  const double height = sides.y();
  const double to_side = 0.75 * height * radius / std::hypot(radius, height);
  return std::min(height / 4, to_side);
}

double Solid::OuterRadius() const {
  const Vector3d half = HalfExtents();
  const double across = std::max(half.x(), half.z());
  switch (shape) {
    case Shape::kEllipsoid:
      return half.maxCoeff();
    case Shape::kCuboid:
    case Shape::kTetrahedron:
      return half.stableNorm();
    case Shape::kCylinder:
      return std::hypot(across, half.y());
    case Shape::kCone:
      return std::max(0.75 * sides.y(), std::hypot(across, sides.y() / 4));
    case Shape::kCapsule: {
      // The support of (across sin t, straight + cap cos t), if the tip is not the farthest point.
      const double straight = StraightHalf(), cap = half.y() - straight;
      const double cosine = cap * straight / (across * across - cap * cap);
      if (!(across > cap) || cosine >= 1) return half.y();
      return std::hypot(across * std::sqrt(1 - cosine * cosine), straight + cap * cosine);
    }
    case Shape::kCompound:
      return compound->outer_radius();
  }
  return 0;
}

Box Bounds(const Solid& solid, const Eigen::Quaterniond& orientation) {
  if (solid.IsBall()) return {-solid.HalfExtents(), solid.HalfExtents()};
  const Eigen::Matrix3d turn = orientation.toRotationMatrix();
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d direction = turn.row(axis);
    box.upper[axis] = direction.dot(solid.Support(direction));
    box.lower[axis] = direction.dot(solid.Support(-direction));
  }
  return box;
}

}  // namespace cdb::objects
