// Finds objects that Bullet put to sleep although nothing holds them: in the air, or on a slope
// that is too steep for friction or down which they would roll.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "runtime/engine/probes/body_states.h"

namespace cdb::probes {

/// An object is judged by its contacts in the cycle in which it falls asleep, or in the first one.
/// It is held if forces inside the friction cones balance its weight; if it still moved, torques
/// must be balanced too, unless rolling friction acts. Objects held by a link are left out. Static
/// equilibrium is a non-negative least squares problem, solved by coordinate descent. The engine
/// must outlive it. Not thread-safe.
class SleepWatch {
 public:
  explicit SleepWatch(world::Engine& engine);

  /// Call after each cycle, with the states at its start and end. Returns the number of sleeping
  /// objects that nothing holds.
  std::int32_t After(const BodyStates& before, const BodyStates& now);

  using Wrench = Eigen::Matrix<double, 6, 1>;  ///< force, and torque over the least half extent
  /// The forces that contacts can exert on an object.
  struct Support {
    std::vector<Wrench> normals, cones;
  };

 private:
  void CollectSupports();
  double HalfOf(std::size_t object) const;
  bool IsHeld(std::size_t object, const BodyState& before, const Support& support) const;

  world::Engine& engine_;
  bool is_first_ = true;
  std::vector<char> linked_, unheld_;        ///< by object
  std::map<std::size_t, Support> supports_;  ///< of objects that fell asleep in this cycle
};

}  // namespace cdb::probes
