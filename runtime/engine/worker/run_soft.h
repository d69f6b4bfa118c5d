// Executes one run with soft bodies, from its plan to its recording.
#pragma once

#include "compiler/plan/plan.h"
#include "runtime/protocol/recording.h"

namespace cdb::worker {

/// As RunScene, for a scene with soft bodies (compiler/analysis/soft.h), which omits nothing and
/// has no second pass.
void RunSoft(const plan::Run& run, protocol::Recording& recording);

}  // namespace cdb::worker
