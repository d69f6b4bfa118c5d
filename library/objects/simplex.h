// The distance subalgorithm of GJK: the part of a simplex that is nearest to the origin.
#pragma once

#include <Eigen/Core>
#include <array>

namespace cdb::objects {

/// Up to four points, not none.
struct Simplex {
  std::array<Eigen::Vector3d, 4> points;
  int size = 0;
};

/// The point of the simplex's hull nearest the origin; the simplex becomes the corners that hold
/// it. Zero, and all four corners, where a tetrahedron has the origin inside. `noise`: by how much
/// each coordinate may be wrong; what is flatter has no inside. Any unit. Source: Voronoi regions
/// as in C. Ericson, Real-Time Collision Detection, 5.1, decided at the projected point, where
/// little is lost in rounding.
Eigen::Vector3d ReduceToNearest(Simplex& simplex, double noise);

}  // namespace cdb::objects
