// The volume of the intersection of two solids.
//
// Measured along a square grid of rays, kRays in each direction, over the box around both: along a
// ray the lengths inside are exact, across them the midpoint rule is of second order. A solid is
// where the surface winds round a point once or more, so that parts of a mesh that overlap one
// another count once. Lengths in the meshes' unit, u; volumes u^3.
// Errors: none; both meshes are closed. Threads: any. Deterministic.
#pragma once

#include "library/meshes/mesh.h"

namespace cdb::meshes {

struct OverlapVolume {
  double first = 0, second = 0;  ///< of each by itself
  double common = 0;
  /// Of what is in one or the other; 1 where they are the same.
  double IntersectionOverUnion() const { return common / (first + second - common); }
};

/// Along the longest axis of the box, so that the rays are close.
OverlapVolume OverlapVolumeOf(const Mesh& first, const Mesh& second);

inline constexpr int kRays = 256;

}  // namespace cdb::meshes
