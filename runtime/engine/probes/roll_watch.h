// Finds objects that roll faster or slower than they can: Bullet may push a cylinder that rolls at
// points behind its axis, so that it speeds up.
#pragma once

#include <vector>

#include "runtime/engine/probes/body_states.h"
#include "runtime/engine/probes/supports.h"

namespace cdb::probes {

/// Judged are balls, and cylinders and capsules on their round side, on one wall or fixed cuboid,
/// which touch nothing else. The ground pushes towards the axis, and friction acts where they
/// touch, a radius r away. So neither changes the angular momentum about the line of contact,
/// m (r v + k^2 w), with the velocity v along the ground, the rolling w and the radius of gyration
/// k: it changes by gravity alone, whether the object rolls or slips, and whatever the friction.
/// From velocities; Bullet's contacts only tell what touches. Not judged: objects with damping,
/// rolling friction or links. The engine must outlive it. Not thread-safe.
class RollWatch {
 public:
  explicit RollWatch(world::Engine& engine);

  /// Call after each cycle, with the states at its start and end: the deviation of the
  /// speed at which an object rolls or will roll, by its angular momentum, relative to its largest
  /// speed so far, at least 0.5 sqrt(g S) with its least side S. NaN if nothing was judged.
  double After(const BodyStates& before, const BodyStates& now, const Supports& supports);

 private:
  struct Round {
    bool is_judged = false;
    bool is_ball = false;
    double radius = 0;       ///< m
    double gyration = 0;     ///< m^2: k^2
    double least_speed = 0;  ///< m/s
    // While it rolls.
    Eigen::Vector3d error = Eigen::Vector3d::Zero();  ///< m/s, of its speed
    double fastest = 0;                               ///< m/s
    bool has_rolled = false;
  };
  void Judge(Round& round, const BodyState& before, const BodyState& now, const Support& support);

  world::Engine& engine_;
  const Eigen::Vector3d pull_;  ///< m/s: velocity that gravity gives in a cycle
  std::vector<Round> objects_;  ///< by object
};

}  // namespace cdb::probes
