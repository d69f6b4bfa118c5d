// The volume of the intersection of two solids.
//
// Measured along a square grid of rays, kRays in each direction, over the box around both: the
// lengths inside along a ray are exact; across the rays, the midpoint rule is of second order. A
// point is inside a solid if the winding number of the surface is at least 1, so that overlapping
// parts of a mesh count once. Lengths in the unit of the meshes, u; volumes u^3.
// Errors: none; both meshes must be closed. Threads: any. Deterministic.
#pragma once

#include "library/meshes/mesh.h"

namespace cdb::meshes {

struct OverlapVolume {
  double first = 0, second = 0;  ///< of each separately
  double common = 0;
  /// 1 if the solids are equal.
  double IntersectionOverUnion() const { return common / (first + second - common); }
};

/// Along the longest axis of the box, so that the rays are close.
OverlapVolume OverlapVolumeOf(const Mesh& first, const Mesh& second);

inline constexpr int kRays = 256;

}  // namespace cdb::meshes
