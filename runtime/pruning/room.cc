#include "runtime/pruning/room.h"

#include "runtime/pruning/omissions.h"

namespace cdb::pruning {

Room::Room(const plan::Scene& scene, const Horizon& horizon)
    : standing_(StandingWalls(scene)),
      half_(scene.world.Real("world.side") / 2),
      // A wall is half_ away, and so is what comes near it: the omission guard allows 16 of these.
      rounding_(32 * horizon.rounding * half_),
      // A box ends a little outside the cube, where only another box stops what moves there.
      is_endless_(scene.world.WordOr("world.wall_shape") == "plane" ||
                  scene.world.WordOr("world.walls") == "all") {}

double Room::Gap(int wall, const Box& places, double reach) const {
  const int axis = wall / 2;
  const double farthest = wall % 2 == 0 ? -places.min()[axis] : places.max()[axis];
  return half_ - rounding_ - reach - farthest;
}

}  // namespace cdb::pruning
