// Finds objects that passed through one another: within a cycle, the path of one's centre of mass
// runs through the other solid, or leaves it on another side than it entered. The same is checked
// for the ball about the centre with half the inner radius, if it is clear of the solid before and
// after.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/engine/probes/body_states.h"

namespace cdb::probes {

/// Paths are straight, as Bullet moves bodies; a rotation of the other solid is followed in steps
/// of a tenth of a radian. A surface is passed if the path of a centre of mass crosses it, at any
/// speed. For solids, only objects that moved by at least half their inner radius in the cycle are
/// compared with others, along the axis on which the objects are spread most: near linear in their
/// number. Not checked: linked objects, which do not collide; objects whose centre of mass lies
/// outside their solid, such as a torus; walls. The engine must outlive it. Not thread-safe.
class PassWatch {
 public:
  explicit PassWatch(const world::Engine& engine);

  /// Call after each cycle, with the states at its start and end. Returns the number of passes that
  /// ended.
  std::int32_t After(const BodyStates& before, const BodyStates& now);

 private:
  struct Size {
    double inner, outer;  ///< m: radii about the centre of mass
    double fast_way;      ///< m per cycle, half the inner radius
    double turn_radius;   ///< m: `outer`, or 0 for a ball
  };
  /// The space swept in a cycle, as balls about the centre of mass.
  struct Swept {
    Eigen::Vector3d lower, upper;
    std::uint32_t object;
    bool is_fast;
  };
  /// The centre of `object` entered `other`; `entry`: its position before, in the other's axes.
  struct Entry {
    std::uint32_t object, other;
    Eigen::Vector3d entry;
  };

  bool IsFast(std::size_t object, const BodyState& before, const BodyState& now) const;
  bool AnyIsFast(const BodyStates& before, const BodyStates& now) const;
  void SweepAll(const BodyStates& before, const BodyStates& now);
  std::int32_t CrossSurfaces(const BodyStates& before, const BodyStates& now) const;
  bool Passed(const BodyStates& before, std::uint32_t object, std::uint32_t other);
  std::int32_t FollowEntries();
  std::int32_t ComparePaths(const BodyStates& before);

  const world::Engine& engine_;
  std::vector<Size> sizes_;  ///< by object
  std::vector<std::uint32_t> surfaces_;
  std::vector<Swept> swept_;    ///< of this cycle
  std::vector<Entry> entries_;  ///< centres that are inside another object
};

}  // namespace cdb::probes
