// Measurement overhead.
#pragma once

#include "runtime/engine/world/engine.h"

namespace cdb::worker {

/// Measurement overhead of a cycle in nanoseconds: the time stamps of a TimedWorld, and the calls
/// of a detector that does nothing. The median of 101 measurements; does not change the engine's
/// world.
double HarnessNs(const plan::Scene& scene, const world::Engine& engine);

}  // namespace cdb::worker
