// Records the input of the narrow phase in each cycle, for traces of pairs.
#pragma once

#include <vector>

#include "runtime/engine/world/engine.h"
#include "runtime/protocol/trace_memory.h"

namespace cdb::worker {

/// Appends to a file (protocol::AppendNarrowInput), between broad and narrow phase, the pose of
/// every body and the pairs that the narrow phase gets: those of the pair cache that may touch and
/// are not both asleep, in the order of their bodies. Bodies are numbered as by
/// detection::SceneView. Engine and file must outlive it, and the engine must have no clock. Not
/// thread-safe.
class NarrowInput {
 public:
  NarrowInput(world::Engine& engine, int fd);
  /// From the next step on.
  void Begin();

 private:
  void Record();

  world::Engine& engine_;
  const int fd_;
  std::vector<btRigidBody*> bodies_;
  std::vector<std::uint32_t> wall_places_;  ///< by number of the wall
  std::vector<btScalar> frames_;
  std::vector<protocol::TracePair> pairs_;
};

}  // namespace cdb::worker
