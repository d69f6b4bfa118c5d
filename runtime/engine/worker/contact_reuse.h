// Reuses contacts between bodies that hardly move.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <vector>

#include "runtime/engine/world/engine.h"

namespace cdb::worker {

/// Bound of the displacement, m, of any point within `radius` of the origin from one pose to the
/// other.
double Displacement(const btTransform& from, const btTransform& to, double radius);

/// Bullet's narrow phase runs for a pair only after one of its bodies has moved by more than a
/// tolerance. Until then the contacts of the pair are kept, and follow the bodies as Bullet moves
/// the contacts of a manifold. The poses on which contacts are based are out of date by at most
/// four tolerances. Not thread-safe.
class ContactReuse {
 public:
  struct Body {
    double radius;     ///< about the centre of mass, m
    double tolerance;  ///< m
  };
  /// `bodies`: the engine's objects. The engine must outlive it and have Bullet's narrow phase; its
  /// fixed and kinematic objects must not move.
  ContactReuse(world::Engine& engine, std::vector<Body> bodies);

  /// Call before each step.
  void BeforeStep();

 private:
  world::Engine& engine_;
  const std::vector<Body> bodies_;
  std::vector<btTransform> counted_;  ///< of each object: the pose when it last counted as moved
};

}  // namespace cdb::worker
