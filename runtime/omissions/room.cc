#include "runtime/omissions/room.h"

#include "runtime/omissions/omissions.h"

namespace cdb::omissions {

Room::Room(const plan::Scene& scene, const Horizon& horizon)
    : standing_(StandingWalls(scene)),
      half_(scene.world.Real("world.side") / 2),
      // Walls, and the objects near them, are at a distance of about half_. The omission guard
      // allows 16 of these.
      rounding_(32 * horizon.rounding * half_),
      // A box wall ends a little outside the cube, where only another box stops objects.
      is_endless_(scene.world.WordOr("world.wall_shape") == "plane" ||
                  scene.world.WordOr("world.walls") == "all") {}

double Room::Gap(int wall, const Box& places, double reach) const {
  const int axis = wall / 2;
  const double farthest = wall % 2 == 0 ? -places.min()[axis] : places.max()[axis];
  return half_ - rounding_ - reach - farthest;
}

}  // namespace cdb::omissions
