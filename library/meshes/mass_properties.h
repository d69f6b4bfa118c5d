// Volume, centre of mass and inertia of the homogeneous solid within a closed mesh.
//
// Lengths in the mesh's unit, u: u^3 and u^2. The integrals are exact but for rounding: of
// polynomials over the tetrahedra from a common apex to each face. Where a mesh overlaps itself,
// what is inside twice counts twice. Errors: none; the mesh is one that Watertight gave.
// Threads: any. Sources: Lien & Kajiya, "A symbolic method for calculating the integral properties
// of arbitrary nonconvex polyhedra", IEEE CG&A 4(10), 1984; Tonon, "Explicit exact formulas for
// the 3-D tetrahedron inertia tensor in terms of its vertex coordinates", J. Math. Stat. 1(1),
// 2005.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

struct MassProperties {
  double volume = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  /// About the centre of mass, for a mass of 1, along the mesh's own axes.
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
};

MassProperties MassPropertiesOf(const Mesh& mesh);
/// Below 0 where the mesh is inside out.
double SignedVolume(const Mesh& mesh);

struct PrincipalAxes {
  Eigen::Vector3d moments = Eigen::Vector3d::Zero();  ///< about the columns of `rotation`
  /// From the principal axes to the mesh's own: its columns are the axes, right-handed.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
};

/// Of a symmetric tensor. Of all the axes that would do, those closest to the mesh's own: a tensor
/// that is diagonal up to 1e-9 of its trace gives the identity.
PrincipalAxes PrincipalAxesOf(const Eigen::Matrix3d& inertia);

}  // namespace cdb::meshes
