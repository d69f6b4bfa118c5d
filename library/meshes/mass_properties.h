// Volume, centre of mass and inertia of the homogeneous solid within a closed mesh.
//
// Lengths in the unit of the mesh, u: u^3 and u^2. The integrals are exact up to rounding: they are
// of polynomials over the tetrahedra from a common apex to each face. If a mesh overlaps itself,
// the overlap counts twice. Errors: none; the mesh must come from Watertight. Threads: any.
// Sources: Lien & Kajiya, "A symbolic method for calculating the integral properties of arbitrary
// nonconvex polyhedra", IEEE CG&A 4(10), 1984; Tonon, "Explicit exact formulas for the 3-D
// tetrahedron inertia tensor in terms of its vertex coordinates", J. Math. Stat. 1(1), 2005.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

struct MassProperties {
  double volume = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  /// About the centre of mass, for a mass of 1, along the axes of the mesh.
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
};

MassProperties MassPropertiesOf(const Mesh& mesh);
/// Negative if the mesh is inside out.
double SignedVolume(const Mesh& mesh);

struct PrincipalAxes {
  Eigen::Vector3d moments = Eigen::Vector3d::Zero();  ///< about the columns of `rotation`
  /// The rotation from the principal axes to those of the mesh: its columns are the axes,
  /// right-handed.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
};

/// The principal axes of a symmetric tensor. Of all possible axes, those closest to the axes of the
/// mesh: a tensor that is diagonal up to 1e-9 of its trace gives the identity.
PrincipalAxes PrincipalAxesOf(const Eigen::Matrix3d& inertia);

}  // namespace cdb::meshes
