// Soft bodies: ropes, cloths and blocks, whose nodes move.
//
// A run with soft bodies has its own world (runtime/engine/soft), in which the other objects are
// rigid and convex.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "compiler/analysis/setting_fault.h"
#include "compiler/plan/plan.h"

namespace cdb::analysis {

inline constexpr std::string_view kRopeCall = "rope";
inline constexpr std::string_view kClothCall = "cloth";
inline constexpr std::string_view kBlockCall = "block";

/// Nodes are numbered along x, then z, then y.
///
/// A rope has links along x. A cloth has triangles over x and z: two for each rectangle, with its
/// diagonals in alternating directions. A block has five tetrahedra for each cell, one of which
/// joins four corners that are no neighbours; cells are mirror images of their neighbours, so that
/// they share the diagonals of their faces. Links are the edges of triangles and tetrahedra;
/// the triangles of a block are those of its surface, seen counterclockwise from outside.
struct SoftMesh {
  /// Cells along x, z and y; a rope has no rows, and only a block has layers.
  std::size_t columns = 1, rows = 0, layers = 0;
  std::vector<std::array<std::uint32_t, 2>> links;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  /// Their volumes, (b - a) x (c - a) . (d - a) / 6, are positive.
  std::vector<std::array<std::uint32_t, 4>> tetrahedra;

  std::size_t NodeCount() const { return (columns + 1) * (rows + 1) * (layers + 1); }
  /// Place of a node along x, y and z, from 0 to 1; 0.5 along an axis without cells.
  Eigen::Vector3d PlaceOf(std::size_t node) const;
};

/// `type`: that of a soft body.
SoftMesh MeshOf(const schema::Value& type);
/// The same with its nodes alone.
SoftMesh LatticeOf(const schema::Value& type);
SoftMesh BlockOf(std::size_t columns, std::size_t rows, std::size_t layers);

/// The edges of a tetrahedron from its first corner to the others, or differences of another vector
/// that `value_of` gives for each node.
template <typename ValueOf>
Eigen::Matrix3d EdgesOf(const std::array<std::uint32_t, 4>& corners, const ValueOf& value_of) {
  Eigen::Matrix3d edges;
  for (int i = 0; i < 3; ++i)
    edges.col(i) = value_of(corners[static_cast<std::size_t>(i) + 1]) - value_of(corners[0]);
  return edges;
}

/// Of each node, in the mass of its body, which it has if it is not pinned: of a rope, that of the
/// halves of its links; of a cloth, a third of each triangle; of a block, a quarter of each
/// tetrahedron.
std::vector<double> MassShares(const SoftMesh& mesh);

/// True for a constant type `rope( )`, `cloth( )` or `block( )`.
bool IsSoft(const schema::Value& type);
/// True if the objects of the group may be soft.
bool IsSoft(const plan::Group& group);
/// True if the scene has a soft body.
bool HasSoft(const plan::Scene& scene);
/// True if the objects of the group are blocks.
bool HasBlocks(const plan::Group& group);
/// Of one soft body of this type, and of all those of a scene.
std::uint64_t NodeCount(const schema::Value& type);
std::uint64_t NodeCount(const plan::Scene& scene);
/// Objects beside the soft ones that contacts move.
std::uint64_t FreeRigidCount(const plan::Scene& scene);

/// The nodes of a mesh on the sides that the group pins, ascending.
std::vector<std::uint32_t> PinnedNodes(const plan::Group& group, const SoftMesh& mesh);

/// Pa: the constants of Hooke's law, stress = 2 mu strain + lambda trace(strain).
struct LameConstants {
  double mu = 0, lambda = 0;
};
LameConstants LameConstantsOf(double young_modulus, double poisson_ratio);

/// What in the scene soft bodies cannot have, or only they; nullopt if there is nothing.
std::optional<SettingFault> FindSoftFault(const plan::Scene& scene);

}  // namespace cdb::analysis
