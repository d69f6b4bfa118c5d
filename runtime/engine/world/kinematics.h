// Moves the kinematic objects of an engine.
//
// During the step from t to t + dt, a kinematic object is where its motion (layouts::PoseAt) has it
// at t, as all other objects are, and has the velocity that takes it to its pose at t + dt; after
// the step it is there. So contacts are found between poses of one time. Velocities are worked out
// in double and given to Bullet's solver; nothing accumulates. t counts from the start, warm-up
// included. Not for several threads.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/engine/world/engine.h"

namespace cdb::world {

class Kinematics {
 public:
  /// The engine must outlive it.
  Kinematics(const plan::Scene& scene, Engine& engine);

  /// Call before and after each step, which is the `step`-th, from 0.
  void BeforeStep(std::uint64_t step) const;
  void AfterStep(std::uint64_t step) const;

 private:
  double TimeOf(std::uint64_t step) const { return static_cast<double>(step) * timestep_; }

  Engine& engine_;
  const double timestep_;             ///< s, as the scene has it, not rounded
  std::vector<std::size_t> objects_;  ///< the kinematic ones
};

}  // namespace cdb::world
