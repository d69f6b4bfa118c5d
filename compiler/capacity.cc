#include "compiler/capacity.h"

namespace cdb::compiler {

std::uint64_t BodyCount(const Scene& scene) {
  const std::string_view walls = scene.world.WordOr("world.walls");
  return scene.ObjectCount() + (walls == "all" ? 6 : walls == "floor" ? 1 : 0);
}

}  // namespace cdb::compiler
