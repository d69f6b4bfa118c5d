// Whether motors reach the velocities and positions that they seek.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "runtime/engine/world/axis_drive.h"
#include "runtime/engine/world/gears.h"

namespace cdb::world {

struct JointFrame;

/// A motor that has effort left reaches what it seeks in each step, if the solver converges: unless
/// something rigid stops it. So motors are judged in steps in which nothing touches the bodies that
/// joints and gears connect to theirs; and not where these have a loop, or gears, and further
/// motors, which may contradict each other. Not thread-safe.
class MotorWatch {
 public:
  /// Bodies and drives must outlive it.
  MotorWatch(std::span<const JointFrame> joints, std::span<Gear* const> gears);

  /// No motor can be judged.
  bool IsEmpty() const { return motors_.empty(); }
  /// The largest AxisDrive::TakeMiss of the last step; nullopt if none was judged.
  std::optional<double> LargestMiss(btCollisionWorld& world, double length);

 private:
  struct Motor {
    AxisDrive* drive;
    std::size_t machine;
  };
  std::vector<Motor> motors_;
  std::map<const btCollisionObject*, std::size_t> machines_;  ///< of the bodies that move
  std::vector<char> is_touched_;                              ///< by machine
};

}  // namespace cdb::world
