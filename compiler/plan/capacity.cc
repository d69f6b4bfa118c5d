#include "compiler/plan/capacity.h"

#include <algorithm>

#include "compiler/plan/engine_constants.h"

namespace cdb::plan {

std::uint64_t BodyCount(const Scene& scene) {
  const std::string_view walls = scene.world.WordOr("world.walls");
  return scene.ObjectCount() + (walls == "all" ? kWallCount : walls == "floor" ? 1 : 0);
}

std::uint64_t MaxBodyCount(const Plan& plan) {
  std::uint64_t most = 0;
  for (const Run& run : plan.Bounds()) most = std::max(most, BodyCount(run.scene));
  return most;
}

}  // namespace cdb::plan
