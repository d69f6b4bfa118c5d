// The convex solids that objects are: closed forms, in double, without any physics engine.
//
// A body's origin is its centre of mass and its axes are the principal ones, so that the inertia is
// diagonal. Lengths in m.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string_view>

namespace cdb::library {

enum class Shape {
  kEllipsoid,  ///< a sphere where the sides are equal
  kCuboid,
  kCylinder,     ///< stands along y on an ellipse
  kCone,         ///< stands along y on an ellipse, the tip up
  kCapsule,      ///< stands along y: a cylinder between the halves of an ellipsoid
  kTetrahedron,  ///< on every other corner of its box; regular where the sides are equal
};

/// Null words are our own bug; throws SceneError with the catalogue's refusal for a type that this
/// build has not got.
Shape ShapeOf(std::string_view object_type);

struct Box {
  Eigen::Vector3d lower, upper;
};

struct Solid {
  Shape shape = Shape::kEllipsoid;
  Eigen::Vector3d sides = Eigen::Vector3d::Ones();  ///< full extents along x, y, z

  Eigen::Vector3d HalfExtents() const { return sides / 2; }
  /// Half height of a capsule's straight part; its caps are as high as they are wide, so that it is
  /// an ellipsoid (and this 0) where it is no higher than wide.
  double StraightHalf() const;
  /// y of the box's centre above the centre of mass: a cone's centre of mass lies a quarter of its
  /// height above the base; 0 for the others.
  double BoxCentre() const { return shape == Shape::kCone ? sides.y() / 4 : 0; }
  /// m^3.
  double Volume() const;
  /// Principal moments of the homogeneous solid about its centre of mass for a mass of 1 kg, m^2.
  Eigen::Vector3d InertiaPerMass() const;
  /// The point of the solid farthest along `direction`, which need not be a unit vector. Any
  /// farthest point where there are several.
  Eigen::Vector3d Support(const Eigen::Vector3d& direction) const;
  /// Radius of the largest ball about the centre of mass inside the solid (for an elliptic cone, of
  /// the circular one in it).
  double InnerRadius() const;
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

}  // namespace cdb::library
