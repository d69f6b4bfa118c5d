// Soft bodies: ropes, cloths, blocks and solids made of meshes, whose nodes move.
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

#include "compiler/analysis/scene_fault.h"
#include "compiler/plan/plan.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::analysis {

inline constexpr std::string_view kRopeCall = "rope";
inline constexpr std::string_view kClothCall = "cloth";
inline constexpr std::string_view kBlockCall = "block";
using schema::kSoftCall;

/// Nodes are numbered along x, then z, then y; those of soft( ) as library/tetrahedra/stuffing.h
/// does.
///
/// A rope has links along x. A cloth has triangles over x and z: two for each rectangle, with its
/// diagonals in alternating directions. A block has five tetrahedra for each cell, one of which
/// joins four corners that are no neighbours; cells are mirror images of their neighbours, so that
/// they share the diagonals of their faces. Links are the edges of triangles and tetrahedra;
/// the triangles of a block and of soft( ) are those of its surface, seen counterclockwise from
/// outside.
struct SoftMesh {
  /// Cells along x, z and y; a rope has no rows, and only a block has layers.
  std::size_t columns = 1, rows = 0, layers = 0;
  std::vector<Eigen::Vector3d> places = {};  ///< of soft( ), as PlaceOf gives them
  /// Of soft( ): a node is at a side if it is closer to the outermost one, in parts of the sides.
  Eigen::Vector3d side_depth = Eigen::Vector3d::Zero();
  std::vector<std::array<std::uint32_t, 2>> links;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  /// Their volumes, (b - a) x (c - a) . (d - a) / 6, are positive.
  std::vector<std::array<std::uint32_t, 4>> tetrahedra;

  std::size_t NodeCount() const {
    return places.empty() ? (columns + 1) * (rows + 1) * (layers + 1) : places.size();
  }
  /// Place of a node along x, y and z, from 0 to 1; 0.5 along an axis without cells.
  Eigen::Vector3d PlaceOf(std::size_t node) const;
};

/// `type`: that of a soft body that is not made of a file (library/objects/soft_form.h).
SoftMesh MeshOf(const schema::Value& type);
/// The same with its nodes alone.
SoftMesh LatticeOf(const schema::Value& type);
/// A mesh with its tetrahedra, and the links and triangles that follow from them.
void AddLinksAndTriangles(SoftMesh& mesh);
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
/// halves of its links; of a cloth, a third of each triangle; of a block or soft( ), a quarter of
/// each tetrahedron.
std::vector<double> MassShares(const SoftMesh& mesh);

/// True for a constant type `rope( )`, `cloth( )`, `block( )` or `soft( )`.
bool IsSoft(const schema::Value& type);
/// True if the objects of the group may be soft.
bool IsSoft(const plan::Group& group);
/// True if the scene has a soft body.
bool HasSoft(const plan::Scene& scene);
/// True for a constant type of soft bodies that are solids of tetrahedra.
bool IsSoftSolid(const schema::Value& type);
/// True if the objects of the group are such solids.
bool HasSoftSolids(const plan::Group& group);
/// True for a constant type `soft( )`.
bool IsOfFile(const schema::Value& type);
/// Of one soft body of this type, and of all those of a scene. Of soft( ), the number that the plan
/// states; 0 if its file could not be read.
std::uint64_t NodeCount(const schema::Value& type);
std::uint64_t NodeCount(const plan::Scene& scene);
/// Objects beside the soft ones that contacts move.
std::uint64_t FreeRigidCount(const plan::Scene& scene);

/// The nodes of a mesh on the sides that the group pins, ascending.
std::vector<std::uint32_t> PinnedNodes(const plan::Group& group, const SoftMesh& mesh);
/// Those that the group moves together, ascending; none of the pinned ones.
std::vector<std::uint32_t> DrivenNodes(const plan::Group& group, const SoftMesh& mesh);
/// True if the group has soft bodies with pins that move.
bool HasDrivenPins(const plan::Group& group);

/// Pa: the constants of Hooke's law, stress = 2 mu strain + lambda trace(strain).
struct LameConstants {
  double mu = 0, lambda = 0;
};
LameConstants LameConstantsOf(double young_modulus, double poisson_ratio);

/// What in the scene soft bodies cannot have, or only they; nullopt if there is nothing.
std::optional<SettingFault> FindSoftFault(const plan::Scene& scene);

}  // namespace cdb::analysis
