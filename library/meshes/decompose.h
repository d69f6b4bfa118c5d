// Convex decomposition of a mesh into a few pieces, for engines that collide only convex shapes.
//
// The mesh is simplified (or subdivided, where it is coarse), cut by HACD, and the corners of each
// cluster of faces become a convex hull; pieces overlap a little and fill small hollows. Lengths in
// the mesh's unit. Deterministic to the byte on one machine and build of the libraries. Errors:
// SceneError that begins with `name`. Threads: any, one at a time inside (HACD has a global). Takes
// seconds, and tens of MiB. Sources: Mamou & Ghorbel, "A simple and efficient approach for 3D mesh
// approximate convex decomposition", ICIP 2009, by HACD 0.0 (Debian's libbullet-extras-dev);
// Garland & Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997, by
// meshoptimizer (0.18 in Debian 12; 0.22 in Debian 13 gives other hulls).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "library/meshes/convex_hull.h"
#include "library/meshes/mesh.h"

namespace cdb::meshes {

struct DecomposeOptions {
  std::size_t faces = 4000;  ///< what the mesh is simplified to first
  double concavity = 100;    ///< how hollow a piece may be, in 1/1000 of HACD's scale
  double compacity = 0.1;    ///< how much round pieces are preferred
  std::size_t least_pieces = 2;
  std::size_t vertices_per_hull = 64;
  double least_volume = 1e-5;  ///< of the mesh's; smaller pieces are dropped
  /// Below this, two more cuts are tried, with a tenth and a hundredth of the compacity, and the
  /// one with the largest IoU is taken.
  double good_iou = 0.9;
};

struct Decomposition {
  std::vector<Hull> hulls;
  /// |volume of the hulls' union - volume of the mesh| / volume of the mesh, along the same rays
  /// (library/meshes/overlap_volume.h); of the mesh as it was, not as it was simplified to.
  double volume_error = 0;
  double iou = 0;  ///< common volume of the two over the volume of their union
  bool operator==(const Decomposition&) const = default;
};

/// `mesh` is one that Watertight gave. A mesh that is convex up to 1e-4 of its volume is one hull.
Decomposition Decompose(const Mesh& mesh, std::string_view name,
                        const DecomposeOptions& options = {});

/// The hulls with how well they stand for the mesh.
Decomposition Assessed(std::vector<Hull> hulls, const Mesh& mesh);

/// What the pieces depend on besides the mesh: the libraries, this code and its default options.
std::string DecomposerVersion();

}  // namespace cdb::meshes
