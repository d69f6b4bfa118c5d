// Reuse of contacts between bodies that hardly move.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <vector>

#include "runtime/engine/world/engine.h"

namespace cdb::worker {

/// How far any point within `radius` of the origin moves at most from one pose to the other; m.
double Displacement(const btTransform& from, const btTransform& to, double radius);

/// Bullet's narrow phase runs for a pair only after one of its bodies has moved by more than a
/// tolerance; until then the contacts of the pair are kept, and follow the bodies as Bullet lets
/// the contacts of a manifold do. What contacts are based on is out of date by four tolerances at
/// most. Not thread-safe.
class ContactReuse {
 public:
  struct Body {
    double radius;     ///< about the centre of mass, m
    double tolerance;  ///< m
  };
  /// `bodies`: the engine's objects. The engine must outlive it and have Bullet's narrow phase; its
  /// fixed and kinematic objects may not move.
  ContactReuse(world::Engine& engine, std::vector<Body> bodies);

  /// To be called before each step.
  void BeforeStep();

 private:
  world::Engine& engine_;
  const std::vector<Body> bodies_;
  std::vector<btTransform> counted_;  ///< of each object: the pose when it last counted as moved
};

}  // namespace cdb::worker
