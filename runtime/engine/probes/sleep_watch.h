// Finds objects that Bullet put to sleep where nothing holds them: on a slope that is steeper than
// friction bears or that they roll down, or in the air.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "runtime/engine/probes/body_states.h"

namespace cdb::probes {

/// An object is judged in the cycle in which it falls asleep, or in the first one, by its contacts.
/// It is held where forces inside the cones of friction balance its weight; one that still moved
/// must be balanced against turning too, unless rolling friction acts. Objects that a link holds
/// are left out. Static equilibrium as a problem of non-negative least squares, solved by
/// coordinate descent. The engine must outlive it. Not for several threads.
class SleepWatch {
 public:
  explicit SleepWatch(world::Engine& engine);

  /// Call after each cycle, with the states at its start and end. Returns how many objects sleep
  /// that nothing holds.
  std::int32_t After(const BodyStates& before, const BodyStates& now);

  using Wrench = Eigen::Matrix<double, 6, 1>;  ///< force, and torque over the least half extent
  /// The forces that contacts can put on an object.
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
