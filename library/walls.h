// Material of the walls. Bullet multiplies the coefficients of both bodies, so that the restitution
// of a bounce off a wall is that of the object.
#pragma once

namespace cdb::library {

inline constexpr double kWallFriction = 0.5;  ///< Bullet's default
inline constexpr double kWallRestitution = 1;

}  // namespace cdb::library
