// The same scene written by hand against Bullet, the baseline of the runner's cycle: a plain
// btDiscreteDynamicsWorld and one pair of clock calls around stepSimulation.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

#include "library/layouts/initial_state.h"

namespace cdb::bench {

/// Spheres, cuboids and circular cylinders; `dbvt`, six planes, everything else Bullet's default.
class HandWritten {
 public:
  HandWritten(const layouts::InitialState& state, double side);
  ~HandWritten();
  HandWritten(const HandWritten&) = delete;
  HandWritten& operator=(const HandWritten&) = delete;

  /// Nanoseconds of one step.
  double Step(double timestep);
  const std::vector<btRigidBody*>& objects() const { return objects_; }

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broad_phase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broad_phase_, &solver_, &configuration_};
  std::vector<btCollisionShape*> shapes_;
  std::vector<btRigidBody*> objects_, walls_;
};

}  // namespace cdb::bench
