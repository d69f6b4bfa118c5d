// What measuring costs.
#pragma once

#include "runtime/engine/world/engine.h"

namespace cdb::worker {

/// Nanoseconds that a timed cycle pays for being measured: as many clock stamps as a TimedWorld
/// sets, and the calls of a detector that does nothing. The median of 101; the engine's world stays
/// as it is.
double HarnessNs(const plan::Scene& scene, const world::Engine& engine);

}  // namespace cdb::worker
