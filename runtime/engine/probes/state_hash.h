// A hash of the state of all bodies, to test whether two runs are identical to the last bit.
#pragma once

#include <string>

#include "runtime/engine/world/engine.h"

namespace cdb::probes {

/// 16 hex digits: FNV-1a (64 bits) over the position, the orientation matrix and both velocities of
/// every object, in order and in the bits of Bullet's own precision. Walls are left out.
std::string StateHash(const world::Engine& engine);

/// The same for any bodies, for a world that was not built by Engine.
std::string StateHash(const btRigidBody* const* bodies, std::size_t count);

}  // namespace cdb::probes
