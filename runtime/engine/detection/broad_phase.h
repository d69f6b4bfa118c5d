// Bullet's own broad phases, by detector name.
#pragma once

#include <btBulletCollisionCommon.h>

#include <memory>
#include <string_view>

namespace cdb::detection {

struct BroadPhaseOptions {
  std::string_view detector;
  std::size_t bodies = 0;  ///< capacity: objects and walls
  btVector3 lower, upper;  ///< where sweep and prune counts its steps from; what leaves this box is
                           ///< still found, with more pairs
  bool raycast_tree = true;  ///< sweep and prune keeps its tree for ray casts
  /// Bodies come and go: each has the number of its getUserIndex, by which Bullet orders pairs and
  /// contacts, whenever it comes. A number comes only once.
  bool numbers_bodies = false;
};

/// Throws library::SceneError for a detector that is not part of this build, or for more bodies
/// than the limit in the catalogue.
std::unique_ptr<btBroadphaseInterface> MakeBroadPhase(const BroadPhaseOptions& options);

}  // namespace cdb::detection
