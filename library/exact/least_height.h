// The least height of a convex set over all directions: the search behind every signed distance.
//
// The height of a set along a unit vector is that of its support plane above the origin. For the
// differences of the points of two bodies, the least height over all directions is minus their
// distance if they are apart, and the depth of their overlap otherwise.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>

namespace cdb::exact {

/// A point of the set: the difference of a point of each of two bodies.
struct Difference {
  Eigen::Vector3d on_a, on_b;
  Eigen::Vector3d Value() const { return on_a - on_b; }
};

/// The point of the set farthest along a unit vector.
using SupportFunction = std::function<Difference(const Eigen::Vector3d&)>;

struct HeightGoal {
  double scale = 1;      ///< the largest coordinate; bounds are widened by its rounding errors
  double tolerance = 0;  ///< the search ends with bounds this close to each other
  double enough = std::numeric_limits<double>::infinity();  ///< or once the height is below -enough
  /// Directions with a greater scalar product with `avoided`, a unit vector, do not count.
  Eigen::Vector3d avoided = Eigen::Vector3d::Zero();
  double largest_cosine = 1;  ///< at least 0
  /// The first direction that is tried, a unit vector.
  Eigen::Vector3d guess = -Eigen::Vector3d::UnitX();
  /// If the origin is inside: by the expanding polytope instead of by branch and bound, which takes
  /// 40,000 points where a body is long. `nearest` is not found then; where rounding errors or its
  /// 200 steps end it, the bounds are farther apart than the tolerance.
  bool by_polytope = false;
};

struct LeastHeight {
  double lower = 0, upper = 0;
  /// Unit: its height, as computed, is the upper bound but for rounding errors.
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
  double height = 0;
  /// The nearest point of the set to the origin that was found; within rounding the origin itself
  /// if the height is positive.
  Difference nearest;
};

/// Both bounds are proven: the upper one by a support plane; the lower one by a point of the set at
/// that distance if it is negative, otherwise by branch and bound: a spherical triangle of
/// directions is divided until the support points at its corners, which belong to the set, are high
/// enough along every direction in it. The bounds are farther apart than the tolerance only if
/// tens of thousands of triangles were not enough: if a ring of directions has equal heights, they
/// reach about 1e-7 of the size. Threads: any. Source: GJK for the distance, as in
/// library/objects/solid_pair.cc; the planes of three support points are those of EPA, G. van den
/// Bergen, Collision Detection in Interactive 3D Environments, 2003, 4.3.8.
LeastHeight FindLeastHeight(const SupportFunction& support, const HeightGoal& goal);

}  // namespace cdb::exact
