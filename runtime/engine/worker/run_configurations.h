// A run that checks configurations of joints for collisions (compiler/analysis/configurations.h).
#pragma once

#include "compiler/plan/plan.h"
#include "runtime/engine/worker/run_scene.h"
#include "runtime/protocol/recording.h"

namespace cdb::worker {

/// Moves the bodies of the robot to one configuration after the other, and finds and records the
/// contacts of each; a cycle is a configuration. Nothing is simulated, and no contact is kept from
/// one configuration to the next. A failure is reported in the recording.
void RunConfigurations(const plan::Run& run, protocol::Recording& recording, Streams streams);

}  // namespace cdb::worker
