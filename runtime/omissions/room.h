// The cube that contains the objects, and its clearance from an object.
//
// SI units. Errors: none. Threads: any.
#pragma once

#include <cstdint>

#include "compiler/plan/plan.h"
#include "runtime/omissions/trajectory.h"

namespace cdb::omissions {

class Room {
 public:
  Room(const plan::Scene& scene, const Horizon& horizon);

  bool Stands(int wall) const { return (standing_ >> wall & 1) != 0; }
  std::uint8_t standing() const { return standing_; }
  double half() const { return half_; }
  /// True if no object can get past the wall, at any distance from its centre.
  bool Holds(int wall) const { return Stands(wall) && is_endless_; }
  /// Clearance, m, between the wall and an object of radius `reach`, m, whose centre is in
  /// `places`, beyond the distance at which they touch. If 0 or less, the object may touch the
  /// wall.
  double Gap(int wall, const Box& places, double reach) const;

 private:
  std::uint8_t standing_;
  double half_;
  double rounding_;  ///< m: of the position of a wall and of distances from it
  bool is_endless_;
};

}  // namespace cdb::omissions
