// Soft bodies: ropes and cloths, whose nodes move.
//
// A run with soft bodies has its own world (runtime/engine/soft), in which the other objects are
// rigid and convex.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/analysis/setting_fault.h"
#include "compiler/plan/plan.h"

namespace cdb::analysis {

inline constexpr std::string_view kRopeCall = "rope";
inline constexpr std::string_view kClothCall = "cloth";

/// True for a constant type `rope( )` or `cloth( )`.
bool IsSoft(const schema::Value& type);
/// True if the objects of the group may be soft.
bool IsSoft(const plan::Group& group);
/// True if the scene has a soft body.
bool HasSoft(const plan::Scene& scene);
/// Of all soft bodies.
std::uint64_t NodeCount(const plan::Scene& scene);
/// Objects beside the soft ones that contacts move.
std::uint64_t FreeRigidCount(const plan::Scene& scene);

/// Nodes on a lattice over x and z, with links along its lines and, in a cloth, one diagonal of
/// each rectangle, in alternating directions. Nodes are numbered along x, then z.
struct SoftMesh {
  std::size_t columns = 1, rows = 0;  ///< rectangles along x and z; a rope has no rows
  std::vector<std::array<std::uint32_t, 2>> links;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  std::size_t NodeCount() const { return (columns + 1) * (rows + 1); }
  /// Place of a node along x and z, from 0 to 1.
  std::pair<double, double> PlaceOf(std::size_t node) const;
};
/// `type`: a soft one.
SoftMesh MeshOf(const schema::Value& type);
/// Of each node, in the mass of its body, which it has if it is not pinned: of a rope, that of the
/// halves of its links; of a cloth, a third of each triangle.
std::vector<double> MassShares(const SoftMesh& mesh);
/// The pinned nodes of each object of the group, ascending.
std::vector<std::uint32_t> PinnedNodes(const plan::Group& group);

/// What in the scene soft bodies cannot have, or only they; nullopt if there is nothing.
std::optional<SettingFault> FindSoftFault(const plan::Scene& scene);

}  // namespace cdb::analysis
