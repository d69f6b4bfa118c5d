// Convex decomposition of a mesh into a few pieces, for engines that collide only convex shapes.
//
// The mesh is simplified (or subdivided if it is coarse) and cut by HACD, and the corners of each
// cluster of faces become a convex hull; pieces overlap slightly and fill small hollows. Lengths in
// the unit of the mesh. Deterministic to the byte on one machine and build of the libraries.
// Errors: SceneError that begins with `name`. Threads: any, one at a time inside (HACD has a
// global). Takes seconds, and tens of MiB. Sources: Mamou & Ghorbel, "A simple and efficient
// approach for 3D mesh approximate convex decomposition", ICIP 2009, by HACD 0.0 (Debian's
// libbullet-extras-dev); Garland & Heckbert, "Surface simplification using quadric error metrics",
// SIGGRAPH 1997, by meshoptimizer (0.18 in Debian 12; 0.22 in Debian 13 gives different hulls).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "library/meshes/convex_hull.h"
#include "library/meshes/mesh.h"

namespace cdb::meshes {

struct DecomposeOptions {
  std::size_t faces = 4000;  ///< number of faces to which the mesh is first simplified
  double concavity = 100;    ///< maximum concavity of a piece, in 1/1000 of HACD's scale
  double compacity = 0.1;    ///< weight of the preference for round pieces
  std::size_t least_pieces = 2;
  std::size_t vertices_per_hull = 64;
  double least_volume = 1e-5;  ///< as a fraction of that of the mesh; smaller pieces are dropped
  /// Below this, two more cuts are tried, with a tenth and a hundredth of the compacity, and the
  /// one with the largest IoU is used.
  double good_iou = 0.9;
};

struct Decomposition {
  std::vector<Hull> hulls;
  /// |volume of the hulls' union - volume of the mesh| / volume of the mesh, along the same rays
  /// (library/meshes/decompose.h); relative to the original mesh, not the simplified one.
  double volume_error = 0;
  double iou = 0;  ///< common volume of the two divided by the volume of their union
  /// The volume within several parts of the mesh, which its mass and inertia count more than once,
  /// divided by the volume of the mesh.
  double overlap = 0;
  bool operator==(const Decomposition&) const = default;
};

/// `mesh` must come from Watertight. A mesh that is convex up to 1e-4 of its volume is one hull.
Decomposition Decompose(const Mesh& mesh, std::string_view name,
                        const DecomposeOptions& options = {});

/// The hulls, with the errors by which they differ from the mesh.
Decomposition Assessed(std::vector<Hull> hulls, const Mesh& mesh);

/// The inputs of the pieces other than the mesh: the libraries, this code and its default options.
std::string DecomposerVersion();

// The volume of the intersection of two solids.
//
// Measured along a square grid of rays, kRays in each direction, over the box around both: the
// lengths inside along a ray are exact; across the rays, the midpoint rule is of second order. A
// point is inside a solid if the winding number of the surface is at least 1, so that overlapping
// parts of a mesh count once. Lengths in the unit of the meshes, u; volumes u^3.
// Errors: none; both meshes must be closed. Threads: any. Deterministic.

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
