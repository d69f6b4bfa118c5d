// Checks that a mesh is the boundary of a solid: closed, and with a consistent outside.
//
// Errors: SceneError that begins with the name of the mesh. Threads: any.
// Source: each edge of a closed surface has an even number of faces.
#pragma once

#include <string_view>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

/// The mesh as the boundary of a solid. Triangles that have a vertex twice or are there twice are
/// dropped, and unused vertices; if edges are open, equal vertices are merged (exporters split them
/// along seams), then those on open edges that are closer than 1e-8 of the size. Faces are turned
/// so that they agree and point outwards (library/meshes/orientation.h). Rejects edges of an odd
/// number of faces, one-sided surfaces and meshes without volume, and says which types take them.
Mesh Watertight(Mesh mesh, std::string_view name);

/// Closes each hole, a loop of open edges, with a fan about the mean of its corners; if the hole is
/// flat and convex, so is the cap. For models known to have such holes; in a user's model a hole
/// may be intended. Merges equal vertices first. Rejects holes that touch one another.
Mesh CloseHoles(const Mesh& mesh, std::string_view name);

}  // namespace cdb::meshes
