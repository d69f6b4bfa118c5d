// THE list of the shapes with a closed form. Each is a file in library/objects/shapes: a struct of
// functions of the full extents (m) along its principal axes, with the centre of mass as origin.
//
//   kType                     its row in the table of types
//   Volume, SecondMoments     m^3; the mean of x^2, y^2, z^2 over the volume
//   Support                   the point farthest along a direction; any of them if there are
//   several.
//                             For a body of half extents `half` whose margin is taken off (the
//                             engine's core), in the engine's precision too
//   Offset                    optional: the number that Support gets beside `half`
//   Extent                    optional: the least and greatest product of a direction with its
//                             points, equal to those of the support points to the bit
//   BoxCentre                 optional: height of its box's centre above the centre of mass
//   InnerRadius, OuterRadius  of the balls about the centre of mass inside and around it
//   LeastRadiusOfCurvature    optional: of a surface without edges or corners
//   Contains                  whether a point is inside
//   KindOf                    its kind for detectors; with flat faces, kHull will do
//   Faces, Profiles           its surface with extents of 1: flat faces, or profiles to turn about
//   y
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "dsl/text/check.h"
#include "library/objects/shapes/capsule.h"
#include "library/objects/shapes/cone.h"
#include "library/objects/shapes/cuboid.h"
#include "library/objects/shapes/cylinder.h"
#include "library/objects/shapes/ellipsoid.h"
#include "library/objects/shapes/tetrahedron.h"

namespace cdb::objects {

enum class Shape {
  kEllipsoid,
  kCuboid,
  kCylinder,
  kCone,
  kCapsule,
  kTetrahedron,
  kCompound,  ///< of a mesh (library/objects/solid_factory.h), without a closed form
};

/// Calls `visitor` with the struct of the shape.
template <typename Visitor>
decltype(auto) Visit(Shape shape, const Visitor& visitor) {
  switch (shape) {
    case Shape::kEllipsoid:
      return visitor(shapes::Ellipsoid());
    case Shape::kCuboid:
      return visitor(shapes::Cuboid());
    case Shape::kCylinder:
      return visitor(shapes::Cylinder());
    case Shape::kCone:
      return visitor(shapes::Cone());
    case Shape::kCapsule:
      return visitor(shapes::Capsule());
    case Shape::kTetrahedron:
      return visitor(shapes::Tetrahedron());
    case Shape::kCompound:
      break;
  }
  CDB_CHECK(false);
}

/// All with a closed form.
inline constexpr auto kClosedShapes = [] {
  std::array<Shape, static_cast<std::size_t>(Shape::kCompound)> all = {};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Shape>(i);
  return all;
}();

/// The name of its type.
inline std::string_view TypeOf(Shape shape) {
  return Visit(shape, [](auto form) { return form.kType.name(); });
}

/// The number that Support gets beside the half extents.
inline double OffsetOf(Shape shape, const Eigen::Vector3d& sides) {
  return Visit(shape, [&](auto form) {
    if constexpr (requires { form.Offset(sides); }) return form.Offset(sides);
    return 0.0;
  });
}

}  // namespace cdb::objects
