// A hash of the state of all bodies, to test whether two runs are identical to the last bit.
#pragma once

#include <string>

#include "runtime/engine/world/engine.h"

namespace cdb::probes {

/// 16 hex digits over the position, the orientation's matrix and both velocities of every object,
/// in their order and in the bits of Bullet's own precision (FNV-1a, 64 bits). Walls are left out.
std::string StateHash(const world::Engine& engine);

/// The same over any bodies, for a world that was not built by Engine.
std::string StateHash(const btRigidBody* const* bodies, std::size_t count);

}  // namespace cdb::probes
