// Whether a mesh is the boundary of a solid: closed, and with one outside.
//
// Errors: SceneError, that begins with the mesh's name. Threads: any.
// Source: an oriented closed surface has each edge twice, once in each direction.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

/// The mesh as the boundary of a solid. Vertices that no triangle has are dropped; equal vertices
/// are merged where edges are open (exporters split them along seams); a mesh that is inside out as
/// a whole is turned round. Refuses: edges that are open, in more than two faces or run twice in
/// the same direction; triangles that have a vertex twice; no volume; a part that is inside out and
/// no cavity, for no box of a part around it holds its own.
Mesh Watertight(Mesh mesh, std::string_view name);

/// Closes each hole, a loop of open edges, with a fan about the mean of its corners; where the hole
/// is flat and convex the cap is too. For models that are known to have such holes; a user's model
/// may mean something else. Merges equal vertices first. Refuses holes that touch one another.
Mesh CloseHoles(const Mesh& mesh, std::string_view name);

/// By triangle, which of the connected parts it is in, from 0; triangles are connected by vertices.
std::vector<std::uint32_t> PartsOf(const Mesh& mesh);

}  // namespace cdb::meshes
