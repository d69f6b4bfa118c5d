// Solids with closed forms, as meshes and as convex pieces. They stand along y about the origin, as
// the cylinders of library/objects/solid.h do. Lengths in m, or any unit.
// Errors: SceneError for sizes that give no solid. Threads: any.
#pragma once

#include <cstddef>

#include "library/meshes/decompose.h"
#include "library/meshes/mesh.h"

namespace cdb::meshes {

/// `major`: from the centre to the middle of the tube; `minor`: the radius of the tube, less than
/// `major`; `around` and `across`, at least 3: the numbers of corners round the axis and round the
/// tube. All vertices are on the torus.
Mesh TorusMesh(double major, double minor, std::size_t around, std::size_t across);

/// Regular, with this edge; the centre of mass is the origin, one corner is up.
Mesh TetrahedronMesh(double edge);

/// The torus in `segments` convex pieces, at least 3, each between two cross-sections of
/// kTorusCorners corners on the torus. Neighbours share a cross-section. Its errors are relative to
/// a torus with kTorusFineness corners round, whose volume differs from 2 pi^2 R r^2 by less than
/// 1e-3.
Decomposition TorusHulls(double major, double minor, std::size_t segments);

inline constexpr std::size_t kTorusCorners = 16, kTorusFineness = 128;

}  // namespace cdb::meshes
