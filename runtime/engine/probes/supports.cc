#include "runtime/engine/probes/supports.h"

#include <algorithm>
#include <cmath>

#include "runtime/engine/world/manifolds.h"

namespace cdb::probes {

Supports::Supports(world::Engine& engine)
    : engine_(engine),
      has_ground_(!engine.walls().empty() ||
                  std::ranges::any_of(engine.initial_state().objects,
                                      [](const layouts::ObjectState& object) {
                                        return object.IsFixed() && !object.is_kinematic;
                                      })),
      supports_(engine.objects().size()) {}

void Supports::Find() {
  if (!has_ground_) return;
  std::ranges::fill(supports_, Support{});
  const auto add = [&](const btCollisionObject& body, const btCollisionObject& other,
                       const btVector3& normal) {
    const auto index = static_cast<std::size_t>(body.getUserIndex());
    if (index >= supports_.size()) return;
    Support& support = supports_[index];
    if (support.ground == nullptr) {
      support = {&other, normal};
    } else if (support.ground != &other || support.normal.dot(normal) < std::cos(kSameNormal)) {
      support.is_single = false;
    }
  };
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world())) {
    const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
    for (int j = 0; j < manifold.getNumContacts(); ++j) {
      const btManifoldPoint& point = manifold.getContactPoint(j);
      if (!world::HasImpulse(manifold, point)) continue;
      add(a, b, point.m_normalWorldOnB);
      add(b, a, -point.m_normalWorldOnB);
    }
  }
}

}  // namespace cdb::probes
