// The distance subalgorithm of GJK: the part of a simplex nearest to the origin.
#pragma once

#include <Eigen/Core>
#include <array>

namespace cdb::objects {

/// One to four points.
struct Simplex {
  std::array<Eigen::Vector3d, 4> points;
  int size = 0;
};

/// The point of the convex hull of the simplex nearest to the origin; reduces the simplex to the
/// corners whose hull contains it. Zero, and all four corners, if the origin is inside a
/// tetrahedron. `noise`: the error of each coordinate; a flatter tetrahedron has no inside. Any
/// unit. Source: Voronoi regions as in C. Ericson, Real-Time Collision Detection, 5.1, decided at
/// the projected point, where little is lost in rounding.
Eigen::Vector3d ReduceToNearest(Simplex& simplex, double noise);

}  // namespace cdb::objects
