// Convex decomposition of a mesh into a few pieces, for engines that collide only convex shapes.
//
// The solid is cut by planes, always the piece whose convex hull is too large by most; then pieces
// are joined whose common hull adds little. A hull is that of the surface within its piece, so that
// the hulls cover the mesh, and overlap little. Lengths in the unit of the mesh. The same mesh
// gives the same bytes on any machine. Errors: SceneError that begins with `name`. Threads: any.
// Takes seconds, and tens of MiB. Sources: Mamou, "Volumetric hierarchical approximate convex
// decomposition", Game Engine Gems 3, 2016; Wei et al., "Approximate convex decomposition for 3D
// meshes with collision-aware concavity and tree search", ACM TOG 41(4), 2022.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "library/meshes/convex_hull.h"
#include "library/meshes/mesh.h"
#include "library/meshes/overlap_volume.h"

namespace cdb::meshes {

struct DecomposeOptions {
  std::size_t hulls = 40;  ///< the largest number of them
  double error = 0.04;     ///< admissible volume of all hulls outside the mesh, relative to it
  std::size_t vertices_per_hull = 64;
  double least_volume = 1e-5;  ///< as a fraction of that of the mesh; smaller pieces are dropped
  std::size_t most_triangles = 3'000'000;  ///< more take longer than a minute, and are refused
  /// Called before each cut, with the number of pieces so far.
  std::function<void(std::size_t pieces)> progress = {};
};

struct Decomposition {
  std::vector<Hull> hulls;
  /// |volume of the hulls' union - volume of the mesh| / volume of the mesh, along the same rays
  /// (library/meshes/overlap_volume.h).
  double volume_error = 0;
  double iou = 0;  ///< common volume of the two divided by the volume of their union
  /// The volume within several parts of the mesh, which its mass and inertia count more than once,
  /// divided by the volume of the mesh.
  double overlap = 0;
  /// The volume within several hulls, counted once for each further one, divided by that of their
  /// union.
  double hull_overlap = 0;
  bool operator==(const Decomposition&) const = default;
};

/// `mesh` must come from Watertight. A mesh that is convex up to 1e-4 of its volume is one hull.
Decomposition Decompose(const Mesh& mesh, std::string_view name,
                        const DecomposeOptions& options = {});

/// The hulls, with the errors by which they differ from the mesh.
Decomposition Assessed(std::vector<Hull> hulls, const Mesh& mesh);

/// The mesh of all parts, each of which must be closed and convex. Adds their convex hulls to
/// `hulls`.
Mesh JoinConvexParts(std::span<const Mesh> parts, std::string_view name, std::vector<Hull>& hulls);

/// The inputs of the pieces other than the mesh: the libraries, this code and its default options.
std::string DecomposerVersion();

}  // namespace cdb::meshes
