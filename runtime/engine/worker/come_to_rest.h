// Lets objects fall onto one another and come to rest.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "runtime/engine/world/engine.h"

namespace cdb::worker {

// Reuses contacts between bodies that hardly move.

/// Bound of the displacement, m, of any point within `radius` of the origin from one pose to the
/// other.
double Displacement(const btTransform& from, const btTransform& to, double radius);

/// Bullet's narrow phase runs for a pair only after one of its bodies has moved by more than a
/// tolerance. Until then the contacts of the pair are kept, and follow the bodies as Bullet moves
/// the contacts of a manifold. The poses on which contacts are based are out of date by at most
/// four tolerances. Not thread-safe.
class ContactReuse {
 public:
  struct Body {
    double radius;     ///< about the centre of mass, m
    double tolerance;  ///< m
  };
  /// `bodies`: the engine's objects. The engine must outlive it and have Bullet's narrow phase; its
  /// fixed and kinematic objects must not move.
  ContactReuse(world::Engine& engine, std::vector<Body> bodies);

  /// Call before each step.
  void BeforeStep();

 private:
  world::Engine& engine_;
  const std::vector<Body> bodies_;
  std::vector<btTransform> counted_;  ///< of each object: the pose when it last counted as moved
};

/// In mean diameters. The objects are at rest if no point of any of them, except for a fraction
/// kRestless that may roll or tremble, moves farther in a unit of time, for kRestChecks units in a
/// row.
inline constexpr double kRestDisplacement = 0.03;
inline constexpr double kRestless = 0.02;  ///< fraction of the objects
inline constexpr int kRestChecks = 3;
/// Units of time, in addition to that of the fall, after which settling fails.
inline constexpr double kSettleTime = 400;

/// Objects that fall in an engine in which all others stand still.
struct Falling {
  std::vector<std::uint32_t> objects;
  // Mean values.
  double diameter = 0;           ///< of the bounding ball, m
  double least_half_extent = 0;  ///< m
  double gravity = 0;            ///< m/s^2

  /// The time in which an object falls half a diameter from rest, s.
  double UnitOfTime() const { return std::sqrt(diameter / gravity); }
  /// Short enough for impacts, and to keep objects that are enlarged by the factor `growth` from
  /// sinking into one another at their true size; s.
  double Timestep(double growth) const;
};

/// Steps `engine`, whose time step is that of `falling`, until the objects are at rest and
/// `is_clear`, which is asked only then. Damping is so weak that they find their places, and is
/// increased once nearly all have stopped falling; an object that nothing holds still falls.
/// `bodies` are all objects of the engine. Calls `tell` with the number of objects at rest, once
/// per unit of time. False if they stay at rest for `clearing_time` units but do not come clear:
/// the few that still roll may press into what they hit. Throws library::SceneError if they do not
/// come to rest.
bool ComeToRest(world::Engine& engine, const Falling& falling,
                std::vector<ContactReuse::Body> bodies, int clearing_time,
                const std::function<void(std::size_t at_rest)>& tell,
                const std::function<bool()>& is_clear);

}  // namespace cdb::worker
