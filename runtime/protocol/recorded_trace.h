// The boxes of a recorded run as a trace.
#pragma once

#include "compiler/plan/plan.h"
#include "runtime/protocol/recording.h"
#include "runtime/protocol/trace_memory.h"

namespace cdb::protocol {

/// The trace of a finished run of `scene` that records `boxes`. Walls that the run omitted are not
/// in the trace. Throws std::runtime_error if no body is left or a side is NaN, and
/// std::system_error.
TraceMemory TraceOf(const plan::Scene& scene, const Recording& recording);

}  // namespace cdb::protocol
