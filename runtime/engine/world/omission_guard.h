// Omission guard: monitors a run with omitted walls, and ends it at the first sign that the
// omission could change the motion of an object.
//
// A run without walls is the same as with them, by induction over its cycles, as long as
//   - no object whose wall is omitted comes so near that Bullet would make a contact;
//   - no moving object is in two manifolds with contacts at once: Bullet solves the contacts of an
//     island in an order that depends on all existing pairs;
//   - with dbvt, no object that has ever been in a pair with another one wants to sleep: dbvt drops
//     pairs a few at a time, the more slowly the more pairs there are, and a pair keeps both awake.
#pragma once

#include <array>
#include <stdexcept>
#include <vector>

#include "runtime/engine/world/engine.h"

namespace cdb::world {

/// The run must be restarted with all its walls; what() gives the reason.
class OmissionGuardTripped : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Does nothing if the engine has all walls. The engine must outlive it. Not thread-safe.
class OmissionGuard {
 public:
  explicit OmissionGuard(Engine& engine);

  /// Call before each step: checks the positions that the step's detection will see. Throws
  /// OmissionGuardTripped.
  void BeforeStep() const {
    if (is_set_) CheckWalls();
  }
  /// Call after each step. Throws OmissionGuardTripped.
  void AfterStep() {
    if (is_set_) CheckOrder();
  }

 private:
  /// Bounds within which an object's centre needs no closer check.
  struct Room {
    std::array<btScalar, 3> lower, upper;
  };

  void CheckWalls() const;
  void CheckOutside(std::size_t object) const;
  void CheckOrder();
  void CheckSleepers();

  Engine& engine_;
  const bool is_set_, watches_sleepers_;
  std::vector<Room> rooms_;
  std::vector<char> touches_, has_met_;  ///< by object
};

}  // namespace cdb::world
