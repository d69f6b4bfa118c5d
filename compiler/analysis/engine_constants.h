// Constants of Bullet and of the walls on which lints, pruning and the engine rely.
#pragma once

namespace cdb::analysis {

/// Walls of a cube; Omissions and results list them as -x +x -y +y -z +z.
inline constexpr int kWallCount = 6;
/// Thickness of a box wall, as a fraction of the cube's side.
inline constexpr double kWallThickness = 0.1;

/// Bullet puts a body to sleep that has been slower than both, m/s and rad/s, for this time, s
/// (btRigidBody::updateDeactivation).
inline constexpr double kSlowSpeed = 0.8, kSlowSpin = 1.0, kSleepAfter = 2.0;

/// Bullet switches off a body whose box has this diagonal, m (btCollisionWorld::updateSingleAabb).
inline constexpr double kLargestBox = 1e6;

}  // namespace cdb::analysis
