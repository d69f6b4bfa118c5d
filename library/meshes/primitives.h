// Solids with closed forms, as meshes and as convex pieces. They stand along y, as the cylinders of
// library/objects/solid.h do, about the origin. Lengths in m, or any unit.
// Errors: SceneError for sizes that are no solid's. Threads: any.
#pragma once

#include <cstddef>

#include "library/meshes/decompose.h"
#include "library/meshes/mesh.h"

namespace cdb::meshes {

/// `major` from the middle to the middle of the tube, `minor` the tube's radius, less than `major`;
/// `around` and `across`, 3 or more, the numbers of corners round the axis and round the tube. All
/// vertices are on the torus.
Mesh TorusMesh(double major, double minor, std::size_t around, std::size_t across);

/// Regular, with this edge; the centre of mass is the origin, one corner is up.
Mesh TetrahedronMesh(double edge);

/// The torus in `segments` convex pieces, 3 or more, each between two cross-sections of
/// kTorusCorners corners on the torus. Neighbours share a cross-section. Assessed against a torus
/// of kTorusFineness corners round, whose own volume is short of 2 pi^2 R r^2 by less than 1e-3.
Decomposition TorusHulls(double major, double minor, std::size_t segments);

inline constexpr std::size_t kTorusCorners = 16, kTorusFineness = 128;

}  // namespace cdb::meshes
