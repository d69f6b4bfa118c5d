// Friction and restitution as the scene states them. What Bullet's contacts hold may differ: if
// `ccd` has foreseen a contact, it has no restitution.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::world {

/// Bodies by user index; walls follow the objects. Threads: any.
class Coefficients {
 public:
  Coefficients(const plan::Scene& scene, const layouts::InitialState& state)
      : wall_{scene.world.Real("world.wall_friction"), scene.world.Real("world.wall_restitution")} {
    for (const layouts::ObjectState& object : state.objects)
      objects_.push_back({object.numbers["friction"], object.numbers["restitution"]});
  }

  /// Of a contact of the two.
  double Friction(std::size_t a, std::size_t b) const {
    return std::min(kMostFriction, Of(a).friction * Of(b).friction);
  }
  double Restitution(std::size_t a, std::size_t b) const {
    return Of(a).restitution * Of(b).restitution;
  }

 private:
  struct One {
    double friction, restitution;
  };
  const One& Of(std::size_t body) const { return body < objects_.size() ? objects_[body] : wall_; }

  const One wall_;
  std::vector<One> objects_;
};

}  // namespace cdb::world
