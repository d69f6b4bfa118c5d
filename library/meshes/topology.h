// Checks that a mesh is the boundary of a solid: closed, and with a consistent outside.
//
// Errors: SceneError that begins with the name of the mesh. Threads: any.
// Source: each edge of an oriented closed surface occurs twice, once in each direction.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

/// The mesh as the boundary of a solid. Unused vertices are dropped; equal vertices are merged if
/// edges are open (exporters split them along seams); a mesh that is entirely inside out is
/// reversed. Rejects edges that are open, in more than two faces, or twice in the same direction;
/// triangles that have a vertex twice; meshes without volume; and a part that is inside out but not
/// a cavity, since no box of a larger part contains its box.
Mesh Watertight(Mesh mesh, std::string_view name);

/// Closes each hole, a loop of open edges, with a fan about the mean of its corners; if the hole is
/// flat and convex, so is the cap. For models known to have such holes; in a user's model a hole
/// may be intended. Merges equal vertices first. Rejects holes that touch one another.
Mesh CloseHoles(const Mesh& mesh, std::string_view name);

/// By triangle, the number of its connected part, from 0; triangles are connected by vertices.
std::vector<std::uint32_t> PartsOf(const Mesh& mesh);

}  // namespace cdb::meshes
