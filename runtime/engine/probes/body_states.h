// The state of every object between two cycles.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <vector>

#include "runtime/engine/world/engine.h"

namespace cdb::probes {

struct BodyState {
  btTransform pose;
  btVector3 velocity;  ///< m/s, of the centre of mass
  btVector3 spin;      ///< rad/s
  bool is_asleep;      ///< false for fixed bodies, which Bullet marks as asleep too
};

/// By object index.
using BodyStates = std::vector<BodyState>;

/// Not thread-safe with respect to the engine.
inline void ReadStates(const world::Engine& engine, BodyStates& states) {
  states.resize(engine.objects().size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    const btRigidBody& body = *engine.objects()[i];
    states[i] = {body.getWorldTransform(), body.getLinearVelocity(), body.getAngularVelocity(),
                 body.getActivationState() == ISLAND_SLEEPING && !body.isStaticOrKinematicObject()};
  }
}

}  // namespace cdb::probes
