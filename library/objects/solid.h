// Solids, the shapes of objects: closed forms and compounds of convex pieces, in double, without
// any physics engine.
//
// The origin of a body is its centre of mass and its axes are the principal ones, so that the
// inertia is diagonal. Lengths in m.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <string_view>

#include "library/objects/compound.h"
#include "library/objects/shapes.h"

namespace cdb::objects {

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
  std::shared_ptr<const Compound> compound = nullptr;  ///< null except for kCompound

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
  std::size_t PieceCount() const { return compound ? compound->form().pieces.size() : 1; }
  /// As Support, for one piece.
  Eigen::Vector3d PieceSupport(std::size_t piece, const Eigen::Vector3d& direction) const {
    return compound ? compound->Support(piece, direction) : Support(direction);
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
  bool IsBall() const {
    return shape == Shape::kEllipsoid && sides.x() == sides.y() && sides.y() == sides.z();
  }
};

struct Pose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();               ///< of the centre of mass
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< unit
};

/// The smallest box in world axes around the solid, with the centre of mass at the origin.
Box Bounds(const Solid& solid, const Eigen::Quaterniond& orientation);

}  // namespace cdb::objects
