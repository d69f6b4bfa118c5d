// Finds objects that went through one another, in one cycle or in several.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "library/exact/passage.h"
#include "runtime/engine/probes/body_states.h"

namespace cdb::probes {

/// Sweeps the solids of each pair of objects through each cycle (library/exact/passage.h); paths
/// are straight and spins constant, as Bullet moves bodies. A surface is passed if the path of a
/// centre of mass crosses it. Pairs are found by sorting boxes around the paths along the axis on
/// which the objects are spread most, and skipped until they have moved far enough to change
/// anything. Not checked: linked objects, which do not collide; surfaces against objects whose
/// centre of mass lies outside their solid, such as a torus; walls. The engine must outlive it. Not
/// thread-safe.
class PassWatch {
 public:
  explicit PassWatch(const world::Engine& engine);

  /// Call after each cycle, with the states at its start and end. Returns the number of objects
  /// that passed through a surface, or through another object; of two that are free to move, the
  /// smaller one counts.
  std::int32_t After(const BodyStates& before, const BodyStates& now);

 private:
  /// An object, and the space it sweeps in the cycle.
  struct Path {
    exact::Motion motion;
    Eigen::Vector3d lower, upper;
    std::uint32_t object;
    bool moves;
  };
  /// Two objects with overlapping paths.
  struct Pair {
    exact::Passage passage;
    bool collide;         ///< they may touch and are not linked
    std::uint64_t cycle;  ///< the last one in which their paths overlapped
  };

  Path PathOf(std::uint32_t object, const BodyStates& before, const BodyStates& now) const;
  void CrossSurfaces(const BodyStates& before, const BodyStates& now);
  void SortPaths();
  void ComparePaths();
  void Follow(const Path& first, const Path& second);
  bool MayCollide(std::uint32_t object, std::uint32_t other) const;
  std::uint32_t Passer(std::uint32_t object, std::uint32_t other) const;

  const world::Engine& engine_;
  std::vector<std::uint32_t> surfaces_;
  std::uint64_t cycle_ = 0;
  std::vector<Path> paths_;                        ///< of this cycle
  int axis_ = 0;                                   ///< along which they are sorted
  std::unordered_map<std::uint64_t, Pair> pairs_;  ///< by both indices, the smaller first
  std::vector<char> passed_;                       ///< by object: in this cycle
};

}  // namespace cdb::probes
