// Moves the kinematic objects of an engine.
//
// During the step from t to t + dt, a kinematic object is at the pose of its motion
// (layouts::PoseAt) at t, as all other objects are, and has the velocity that takes it to its pose
// at t + dt; after the step it is at that pose. Contacts are therefore found between poses of the
// same time. Velocities are computed in double and passed to Bullet's solver; no error accumulates.
// t counts from the start, including the warm-up. Not thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/engine/world/engine.h"

namespace cdb::world {

class Kinematics {
 public:
  /// The engine must outlive it.
  Kinematics(const plan::Scene& scene, Engine& engine);

  /// Call before and after each step. `step` counts from 0.
  void BeforeStep(std::uint64_t step) const;
  void AfterStep(std::uint64_t step) const;

 private:
  double TimeOf(std::uint64_t step) const { return static_cast<double>(step) * timestep_; }

  Engine& engine_;
  const double timestep_;             ///< s, as in the scene, not rounded
  std::vector<std::size_t> objects_;  ///< the kinematic ones
};

}  // namespace cdb::world
