// What pushes each object in a cycle.
#pragma once

#include <span>
#include <vector>

#include "runtime/engine/world/engine.h"

namespace cdb::probes {

/// rad: normals that differ by less are the same.
inline constexpr double kSameNormal = 0.05;

struct Support {
  const btCollisionObject* ground = nullptr;  ///< null: nothing pushes the object
  btVector3 normal;                           ///< unit, of one contact, towards the object
  bool is_single = true;                      ///< all contacts are with `ground`, and along it
};

/// By the impulses of Bullet's contacts. The engine must outlive it. Not thread-safe.
class Supports {
 public:
  explicit Supports(world::Engine& engine);

  /// Whether the scene has walls or fixed objects that are not kinematic. Without them, there are
  /// no supports.
  bool has_ground() const { return has_ground_; }
  /// Call after each cycle.
  void Find();
  const Support& Of(std::size_t object) const { return supports_[object]; }

 private:
  world::Engine& engine_;
  bool has_ground_ = false;
  std::vector<Support> supports_;  ///< by object
};

}  // namespace cdb::probes
