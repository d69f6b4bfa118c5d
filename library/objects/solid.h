// Solids, the shapes of objects: closed forms and compounds of convex pieces, in double, without
// any physics engine.
//
// The origin of a body is its centre of mass and its axes are the principal ones, so that the
// inertia is diagonal. Lengths in m.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <memory>
#include <string_view>

#include "dsl/text/check.h"
#include "library/objects/compound.h"
#include "library/objects/shapes/capsule.h"
#include "library/objects/shapes/cone.h"
#include "library/objects/shapes/cuboid.h"
#include "library/objects/shapes/cylinder.h"
#include "library/objects/shapes/ellipsoid.h"
#include "library/objects/shapes/superellipsoid.h"
#include "library/objects/shapes/tetrahedron.h"

namespace cdb::objects {

// THE list of the shapes with a closed form. Each is a file in library/objects/shapes: a struct of
// functions of the full extents (m) along its principal axes, with the centre of mass as origin. A
// superellipsoid also has exponents.
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

enum class Shape {
  kEllipsoid,
  kCuboid,
  kCylinder,
  kCone,
  kCapsule,
  kTetrahedron,
  kSuperellipsoid,
  kCompound,  ///< of a mesh (library/objects/solid_factory.h), without a closed form
};

/// Calls `visitor` with the struct of the shape. `exponents`: e1 and e2 of a superellipsoid.
template <typename Visitor>
decltype(auto) Visit(Shape shape, const Visitor& visitor,
                     const Eigen::Vector2d& exponents = Eigen::Vector2d::Ones()) {
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
    case Shape::kSuperellipsoid:
      return visitor(shapes::Superellipsoid{exponents.x(), exponents.y()});
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

/// The shape of a type with a closed form; any other is an internal error.
Shape ShapeOf(std::string_view object_type);

struct Box {
  Eigen::Vector3d lower, upper;
};

struct Solid {
  Shape shape = Shape::kEllipsoid;
  /// Full extents along x, y, z; for a compound along the axes of its mesh, which may differ from
  /// those of the body.
  Eigen::Vector3d sides = Eigen::Vector3d::Ones();
  std::shared_ptr<const Compound> compound = nullptr;   ///< null except for kCompound
  Eigen::Vector2d exponents = Eigen::Vector2d::Ones();  ///< e1, e2 of a superellipsoid

  /// Compares by value; compounds are equal only if one SolidFactory made both.
  bool operator==(const Solid&) const = default;

  Eigen::Vector3d HalfExtents() const { return sides / 2; }
  /// Height of the box's centre above the centre of mass along y.
  double BoxCentre() const;
  /// m^3.
  double Volume() const;
  /// Principal moments of the homogeneous solid about its centre of mass for a mass of 1 kg, m^2.
  Eigen::Vector3d InertiaPerMass() const;
  /// The point of the solid farthest along `direction`, which need not be a unit vector. If there
  /// are several, any of them.
  Eigen::Vector3d Support(const Eigen::Vector3d& direction) const;
  /// The number of convex pieces whose union it is: 1 except for compounds.
  std::size_t PieceCount() const { return compound ? compound->form().PieceCount() : 1; }
  /// As Support, for one piece.
  Eigen::Vector3d PieceSupport(std::size_t piece, const Eigen::Vector3d& direction) const {
    return compound ? compound->Support(piece, direction) : Support(direction);
  }
  /// Whether a point, in the axes of the body, is in a piece.
  bool PieceContains(std::size_t piece, const Eigen::Vector3d& point) const {
    if (compound) return compound->PieceContains(piece, point);
    return Visit(
        shape, [&](auto form) { return form.Contains(sides, point); }, exponents);
  }
  /// Radius of the largest ball about the centre of mass inside the solid (for an elliptic cone, of
  /// the circular one in it; for a compound, inside one piece: 0 if the centre is in none).
  double InnerRadius() const;
  /// Radius of the smallest ball about the centre of mass that contains the solid.
  double OuterRadius() const;
  /// m: the smallest half extent of the convex pieces.
  double LeastHalfExtent() const {
    return compound ? compound->least_half_extent() : HalfExtents().minCoeff();
  }
  /// True for the triangles of a mesh, without an inside.
  bool IsSurface() const { return compound != nullptr && compound->form().IsSurface(); }
  bool IsRoundCapsule() const {
    return shape == Shape::kCapsule && sides.x() == sides.z() && sides.y() >= sides.x();
  }
  /// False for Bullet's sphere and capsule, which consist of margin only, and for surfaces.
  bool HasMargin() const { return !IsBall() && !IsRoundCapsule() && !IsSurface(); }
  bool IsBall() const {
    return shape == Shape::kEllipsoid && sides.x() == sides.y() && sides.y() == sides.z();
  }
};

/// Calls `visitor` with the struct of its shape, with its exponents.
template <typename Visitor>
decltype(auto) Visit(const Solid& solid, const Visitor& visitor) {
  return Visit(solid.shape, visitor, solid.exponents);
}

struct Pose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();               ///< of the centre of mass
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< unit
};

/// The same place by the point of the solid that a user places, and the axes along which its sides
/// are: those of the file of a mesh. The argument is the pose of its centre of mass and of its
/// principal axes, which differ from these only for compounds.
Pose OriginOf(const Solid& solid, const Pose& body);
/// The inverse.
Pose BodyOf(const Solid& solid, const Pose& origin);

/// The smallest box in world axes around the solid, with the centre of mass at the origin.
Box Bounds(const Solid& solid, const Eigen::Quaterniond& orientation);

}  // namespace cdb::objects
