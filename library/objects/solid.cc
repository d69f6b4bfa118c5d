#include "library/objects/solid.h"

#include <algorithm>

namespace cdb::objects {

using Eigen::Vector3d;

Shape ShapeOf(std::string_view object_type) {
  const auto shape = std::ranges::find(kClosedShapes, object_type, TypeOf);
  CDB_CHECK(shape != kClosedShapes.end());
  return *shape;
}

double Solid::BoxCentre() const {
  if (compound) return 0;
  return Visit(*this, [&](auto form) {
    if constexpr (requires { form.BoxCentre(sides); }) return form.BoxCentre(sides);
    return 0.0;
  });
}

double Solid::Volume() const {
  if (compound) return compound->Volume();
  return Visit(*this, [&](auto form) { return form.Volume(sides); });
}

Vector3d Solid::InertiaPerMass() const {
  if (compound) return compound->InertiaPerMass();
  // A moment of inertia is the sum of the second moments along the other two axes.
  const Vector3d moment =
      Visit(*this, [&](auto form) -> Vector3d { return form.SecondMoments(sides); });
  return {moment.y() + moment.z(), moment.x() + moment.z(), moment.x() + moment.y()};
}

Vector3d Solid::Support(const Vector3d& direction) const {
  if (compound) return compound->Support(direction);
  const double offset = OffsetOf(shape, sides);
  return Visit(*this, [&](auto form) -> Vector3d {
    return form.Support(shapes::ExactPoints(), HalfExtents(), offset, direction);
  });
}

double Solid::InnerRadius() const {
  if (compound) return compound->inner_radius();
  return Visit(*this, [&](auto form) { return form.InnerRadius(sides); });
}

double Solid::OuterRadius() const {
  if (compound) return compound->outer_radius();
  return Visit(*this, [&](auto form) { return form.OuterRadius(sides); });
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

Pose OriginOf(const Solid& solid, const Pose& body) {
  if (solid.compound == nullptr) return body;
  const Compound& compound = *solid.compound;
  Pose origin = body;
  const Eigen::Vector3d way = compound.OriginToCentre();
  if (!way.isZero(0)) origin.position -= body.orientation * way;
  if (!compound.from_mesh().isIdentity(0))
    origin.orientation = body.orientation * Eigen::Quaterniond(compound.from_mesh());
  return origin;
}

Pose BodyOf(const Solid& solid, const Pose& origin) {
  if (solid.compound == nullptr) return origin;
  const Compound& compound = *solid.compound;
  Pose body = origin;
  const Eigen::Matrix3d to_mesh = compound.from_mesh().transpose();
  body.orientation = origin.orientation * Eigen::Quaterniond(to_mesh);
  const Eigen::Vector3d way = compound.OriginToCentre();
  if (!way.isZero(0)) body.position += body.orientation * way;
  return body;
}

}  // namespace cdb::objects
