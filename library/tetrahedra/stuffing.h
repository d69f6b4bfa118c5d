// Tetrahedra that fill a closed mesh, by isosurface stuffing: those of a body-centred cubic
// lattice, with corners near the surface moved onto it, and cut where the surface still crosses an
// edge.
//
// Lengths in the unit of the mesh, u. A point is inside if the winding number of the mesh is at
// least 1, so that overlapping parts are one. Features smaller than a cell may vanish, and edges of
// the mesh are cut by up to a cell. The same mesh gives the same tetrahedra to the last bit.
// Errors: SceneError that begins with `name`, if nothing is left, or several pieces, or more than
// kMostNodes. The mesh must come from Watertight. Threads: any. Takes a second for 300,000
// triangles. Source: Labelle & Shewchuk, "Isosurface stuffing: fast tetrahedral meshes with good
// dihedral angles", ACM Transactions on Graphics 26(3), 2007.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::tetrahedra {

/// As of blocks: Bullet takes 7 kB for each.
inline constexpr std::size_t kMostNodes = 1'000'000;

struct Tetrahedra {
  /// Its lattice has a corner at the middle of the box around the mesh, or half a cell beside it,
  /// so that a box with whole cells along each side is filled exactly.
  std::vector<Eigen::Vector3d> nodes;
  std::vector<std::array<std::uint32_t, 4>> corners;  ///< their volumes are positive
  double cell = 0;                                    ///< u: side of a cube of the lattice
};

/// `cells`, at least 2: along the longest side of the box around the mesh. The surface of the
/// tetrahedra is closed; each edge of it has two triangles, which are connected around each node.
Tetrahedra Stuff(const meshes::Mesh& mesh, std::size_t cells, std::string_view name);

/// In degrees, the least and the largest angle between two faces of a tetrahedron.
struct DihedralAngles {
  double least = 180, most = 0;
};
DihedralAngles DihedralAnglesOf(const Tetrahedra& tetrahedra);

}  // namespace cdb::tetrahedra
