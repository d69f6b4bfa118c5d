// Surfaces: the triangles of a mesh as they are, open or closed, without an inside.
//
// A surface is a form whose pieces are the flat triangles, with a tree to find those near a box. It
// has no volume and no mass; its origin is the middle of its box, its axes those of the mesh.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "library/meshes/mesh.h"
#include "library/objects/compound.h"
#include "library/terrain/height_grid.h"

namespace cdb::objects {

/// More are rejected: Bullet cannot number them. Height fields have no such limit.
inline constexpr std::size_t kMaxSurfaceTriangles = 2'000'000;

/// Triangles without area are dropped. Throws SceneError that begins with `name` if none is left or
/// there are too many.
ConvexDecomposition MakeSurface(std::string name, const meshes::Mesh& mesh);
/// The same for a height field.
ConvexDecomposition MakeSurface(std::string name, std::shared_ptr<const terrain::HeightGrid> grid);

/// Whether the straight path between two points, in the axes of the surface, crosses it. Of two
/// paths that share an end point on the surface, exactly one does.
bool Crosses(const Compound& surface, const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace cdb::objects
