#include "compiler/analysis/capacity.h"

#include <algorithm>

#include "compiler/analysis/engine_constants.h"

namespace cdb::analysis {

std::uint64_t BodyCount(const plan::Scene& scene) {
  const std::string_view walls = scene.world.WordOr("world.walls");
  return scene.ObjectCount() + (walls == "all" ? kWallCount : walls == "floor" ? 1 : 0);
}

std::uint64_t MaxBodyCount(const plan::Plan& plan) {
  std::uint64_t most = 0;
  for (const plan::Run& run : plan.Bounds()) most = std::max(most, BodyCount(run.scene));
  return most;
}

}  // namespace cdb::analysis
