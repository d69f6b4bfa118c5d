// Solids, the shapes of objects: closed forms and compounds of convex pieces, in double, without
// any physics engine.
//
// A body's origin is its centre of mass and its axes are the principal ones, so that the inertia is
// diagonal. Lengths in m.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <string_view>

#include "library/objects/compound.h"

namespace cdb::objects {

enum class Shape {
  kEllipsoid,  ///< a sphere where the sides are equal
  kCuboid,
  kCylinder,     ///< stands along y on an ellipse
  kCone,         ///< stands along y on an ellipse, the tip up
  kCapsule,      ///< stands along y: a cylinder between the halves of an ellipsoid
  kTetrahedron,  ///< on every other corner of its box; regular where the sides are equal
  kCompound,     ///< of a mesh (library/objects/solid_maker.h)
};

/// Of a type that has a closed form; any other is our own bug.
Shape ShapeOf(std::string_view object_type);

struct Box {
  Eigen::Vector3d lower, upper;
};

struct Solid {
  Shape shape = Shape::kEllipsoid;
  /// Full extents along x, y, z; a compound's along the axes of its mesh, which need not be the
  /// body's.
  Eigen::Vector3d sides = Eigen::Vector3d::Ones();
  std::shared_ptr<const Compound> compound = nullptr;  ///< null but for kCompound

  /// Equal solids of one SolidMaker.
  bool operator==(const Solid&) const = default;

  Eigen::Vector3d HalfExtents() const { return sides / 2; }
  /// Half height of a capsule's straight part; its caps are as high as they are wide, so that it is
  /// an ellipsoid (and this 0) where it is no higher than wide.
  double StraightHalf() const;
  /// y of the box's centre above the centre of mass: a cone's centre of mass lies a quarter of its
  /// height above the base; 0 for the other closed forms.
  double BoxCentre() const { return shape == Shape::kCone ? sides.y() / 4 : 0; }
  /// m^3.
  double Volume() const;
  /// Principal moments of the homogeneous solid about its centre of mass for a mass of 1 kg, m^2.
  Eigen::Vector3d InertiaPerMass() const;
  /// The point of the solid farthest along `direction`, which need not be a unit vector. Any
  /// farthest point where there are several.
  Eigen::Vector3d Support(const Eigen::Vector3d& direction) const;
  /// The convex pieces that it is the union of: 1 but for compounds.
  std::size_t PieceCount() const { return compound ? compound->form().pieces.size() : 1; }
  /// As Support, of one piece.
  Eigen::Vector3d PieceSupport(std::size_t piece, const Eigen::Vector3d& direction) const {
    return compound ? compound->Support(piece, direction) : Support(direction);
  }
  /// Radius of the largest ball about the centre of mass inside the solid (for an elliptic cone, of
  /// the circular one in it; for a compound, inside one piece: 0 where the centre is in none).
  double InnerRadius() const;
  /// Radius of the smallest ball about the centre of mass that holds the solid.
  double OuterRadius() const;
  /// m: the least of what the convex pieces extend to each side of their middle.
  double LeastHalfExtent() const {
    return compound ? compound->least_half_extent() : HalfExtents().minCoeff();
  }
  /// The triangles of a mesh, without an inside.
  bool IsSurface() const { return compound != nullptr && compound->form().IsSurface(); }
  bool IsBall() const {
    return shape == Shape::kEllipsoid && sides.x() == sides.y() && sides.y() == sides.z();
  }
};

struct Pose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();               ///< of the centre of mass
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< unit
};

/// The tightest box with the world's axes around the solid, its centre of mass at the origin.
Box Bounds(const Solid& solid, const Eigen::Quaterniond& orientation);

}  // namespace cdb::objects
