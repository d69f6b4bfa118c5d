// The forces and torques that a scene puts on its objects.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <memory>
#include <vector>

#include "compiler/analysis/time_table.h"
#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "runtime/engine/world/multibodies.h"

namespace cdb::world {

/// The table over time that a setting names. Throws library::SceneError.
analysis::TimeTable ReadTable(const schema::Call& call, const plan::GroupSettings& settings,
                              const schema::Parameter& parameter);

/// A force at the centre of mass, N, and a torque, N m, along and about the axes of the world. They
/// act for the whole of a step, as Bullet's gravity does; objects that have one, at least at times,
/// do not sleep. Not thread-safe.
class Pushes {
 public:
  /// Those at the start. The bodies must outlive it.
  Pushes(const plan::Scene& scene, const layouts::InitialState& state,
         const std::vector<std::unique_ptr<btRigidBody>>& objects);

  /// No object has one, at any time.
  bool IsEmpty() const { return pushes_.empty(); }
  /// Whether it has one, at least at times.
  bool IsPushed(std::size_t object) const { return std::ranges::binary_search(pushed_, object); }
  struct Push {
    Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  };
  /// By the object's index: that of the step that comes next, or is done.
  Push Of(std::size_t object) const { return IsEmpty() ? Push{} : pushes_[object]; }
  /// N: of a force, and of one at half of this side that has the torque.
  double Strength(std::size_t object, double side) const {
    const Push push = Of(object);
    return push.force.norm() + push.torque.norm() / (side / 2);
  }
  void SetForce(std::size_t object, const Eigen::Vector3d& force) { pushes_[object].force = force; }
  void SetTorque(std::size_t object, const Eigen::Vector3d& torque) {
    pushes_[object].torque = torque;
  }
  /// Call before and after each step. `multibodies` may be null.
  void BeforeStep(Multibodies* multibodies);
  void AfterStep(double timestep);
  /// J, since the start: F.(v + v')/2 dt, with the velocities before and after a step, which is
  /// exact for a force, and of a torque but for the turn of the body in a step.
  double Work() const { return work_; }

 private:
  struct Motion {
    Eigen::Vector3d velocity, spin;
  };
  Motion MotionOf(std::size_t object) const;

  const std::vector<std::unique_ptr<btRigidBody>>& objects_;
  std::vector<Push> pushes_;         ///< by object; empty if there are none
  std::vector<std::size_t> pushed_;  ///< the objects of groups that have one, in order
  std::vector<Motion> before_;       ///< by index in `pushed_`
  double work_ = 0;
};

}  // namespace cdb::world
