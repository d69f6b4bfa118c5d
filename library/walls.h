// What the walls of the cube are made of. Bullet's contact takes the product of both, so that what
// a bounce off a wall keeps is the object's restitution.
#pragma once

namespace cdb::library {

inline constexpr double kWallFriction = 0.5;  ///< Bullet's own
inline constexpr double kWallRestitution = 1;

}  // namespace cdb::library
