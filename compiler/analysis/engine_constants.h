// Constants of Bullet and of the walls that lints, pruning and the engine rely on.
#pragma once

namespace cdb::analysis {

/// The walls of a cube; pruning and results list them as -x +x -y +y -z +z.
inline constexpr int kWallCount = 6;
/// Thickness of a box wall, as a fraction of the side of the cube.
inline constexpr double kWallThickness = 0.1;

/// Bullet puts a body to sleep after it has been slower than both speeds, m/s and rad/s, for this
/// time, s (btRigidBody::updateDeactivation).
inline constexpr double kSlowSpeed = 0.8, kSlowSpin = 1.0, kSleepAfter = 2.0;

/// Bullet disables a body whose box has at least this diagonal, m
/// (btCollisionWorld::updateSingleAabb).
inline constexpr double kLargestBox = 1e6;

}  // namespace cdb::analysis
