// Sweeps objects along their paths: finds those that went through one another, in one cycle or in
// several, and those that may have met in a cycle.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "library/exact/passage.h"
#include "runtime/engine/probes/body_states.h"

namespace cdb::probes {

/// Two bodies that may have touched in a cycle, and their motions in it.
struct Meeting {
  std::uint32_t a, b;  ///< user indices, the smaller first; b may be a wall
  exact::Motion motion_a, motion_b;
};

/// Sweeps the solids of each pair of objects through each cycle (library/exact/passage.h); paths
/// are straight and spins constant, as Bullet moves bodies. A surface is passed if the path of a
/// centre of mass crosses it. Pairs are found by sorting boxes around the paths along the axis on
/// which the objects are spread most; pairs that moved too little for an overlap to begin are left
/// out. Not checked: linked objects, which do not collide; surfaces against objects whose centre of
/// mass lies outside their solid, such as a torus; walls. The engine must outlive it. Not
/// thread-safe.
class PassWatch {
 public:
  explicit PassWatch(const world::Engine& engine);

  struct Seen {
    /// Objects that have passed through a surface, or through another object, since the beginning;
    /// of two that are free to move, the smaller one counts.
    std::int32_t passed = 0;
    /// Pairs of which it is not known whether they passed through each other in this cycle.
    std::int32_t unfollowed = 0;
  };
  /// Call after each cycle, with the states at its start and end.
  Seen After(const BodyStates& before, const BodyStates& now);

  /// In the last cycle, of all that moved by kMeets of the lesser least side or more relative to
  /// each other: slower ones are close enough before or afterwards for Bullet to find them. With
  /// walls, only those that turn: others do not leave them in the cycle in which they touch them.
  std::span<const Meeting> meetings() const { return meetings_; }
  static constexpr double kMeets = 0.1;

 private:
  /// m; of the object in its own axes.
  struct Size {
    Eigen::Vector3d far;  ///< the farthest coordinates
    double outer, turn_radius, side;
  };
  /// The box that an object sweeps in the cycle.
  struct Path {
    Eigen::Vector3d lower, upper;
    double most = 0;  ///< m: no point moves farther
  };
  /// The lower end of a path along the axis of sorting.
  struct End {
    double lower;
    std::uint32_t object;
  };
  struct Pair {
    exact::Passage passage;
    std::uint64_t cycle;  ///< the last one in which it was followed
  };

  void CrossSurfaces(const BodyStates& before, const BodyStates& now);
  bool ReadPaths(const BodyStates& before, const BodyStates& now);
  Path PathOf(std::uint32_t object, const BodyState& before, const BodyState& now) const;
  void MeetWalls(const BodyStates& before, const BodyStates& now);
  void SortPaths();
  void ComparePaths(const BodyStates& before, const BodyStates& now);
  void Follow(std::uint32_t first, std::uint32_t second, const BodyStates& before,
              const BodyStates& now);
  exact::Motion MotionOf(std::uint32_t object, const BodyStates& before,
                         const BodyStates& now) const;
  bool MayCollide(std::uint32_t object, std::uint32_t other) const;
  std::uint32_t Passer(std::uint32_t object, std::uint32_t other) const;

  const world::Engine& engine_;
  std::vector<Size> sizes_;  ///< by object
  std::vector<std::uint32_t> surfaces_;
  std::uint64_t cycle_ = 0;
  std::vector<Path> paths_;                                           ///< by object: of this cycle
  std::vector<End> ends_;                                             ///< sorted, without surfaces
  int axis_ = 0;                                                      ///< of sorting
  std::map<std::pair<std::uint32_t, std::uint32_t>, Pair> overlaps_;  ///< the smaller index first
  std::vector<Meeting> meetings_;
  std::vector<char> passed_;     ///< by object
  std::int32_t unfollowed_ = 0;  ///< in this cycle
};

}  // namespace cdb::probes
