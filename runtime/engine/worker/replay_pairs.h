// Runs a narrow phase on the recorded poses and pairs of a trace, so that all narrow phases are
// timed on the same motion, without physics.
#pragma once

#include "compiler/plan/plan.h"
#include "runtime/protocol/recording.h"

namespace cdb::worker {

/// Runs the scene's narrow phase on the trace of pairs behind `trace_fd`, first the warm-up cycles
/// and then the recorded ones, and fills `recording`. The bodies are those of the recorded run, in
/// a world that is never stepped: each cycle they are put where they were, and get the pairs that
/// they had. `narrow`, `detect` and `step` alike are the time of FindContacts; of Bullet, that of
/// dispatchAllCollisionPairs, and of destroying the algorithms of the pairs that are gone. If the
/// scene records pairs, the same cycles are then run again, and compared with exact overlaps. The
/// state hash is that of the pairs that overlap in the last cycle. Throws library::SceneError if
/// the narrow phase fails, or if the recorded run cannot be built. Threads: one.
void ReplayPairs(const plan::Run& run, protocol::Recording& recording, int trace_fd);

}  // namespace cdb::worker
