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

/// In mean diameters. The fall ends when no point of any object, except for a fraction kRestless,
/// moves farther in a unit of time, for kRestChecks units in a row.
inline constexpr double kRestDisplacement = 0.03;
inline constexpr double kRestless = 0.05;  ///< fraction of the objects
inline constexpr int kRestChecks = 3;
/// Units of time, in addition to that of the fall, after which it ends in any case.
inline constexpr double kFallTime = 200;

/// Objects that fall in an engine in which all others stand still.
struct Falling {
  std::vector<std::uint32_t> objects;
  // Mean values.
  double diameter = 0;           ///< of the bounding ball, m
  double least_half_extent = 0;  ///< m
  double gravity = 0;            ///< m/s^2

  /// The time in which an object falls half a diameter from rest, s.
  double UnitOfTime() const { return std::sqrt(diameter / gravity); }
  /// Short enough to keep objects from sinking into one another; s.
  double Timestep() const;
  /// Of the drop: longer, but short enough for impacts; s.
  double DropTimestep() const;

 private:
  double TimestepOf(double steps_of_unit) const;
};

/// Steps `engine`, whose time step is that of `falling`, until nearly all objects are at rest.
/// Damping is so weak that they find their places, and is increased once nearly all have stopped
/// falling; an object that nothing holds still falls. `bodies` are all objects of the engine. Calls
/// `tell` with the number of objects at rest, once per unit of time.
void FallDown(world::Engine& engine, const Falling& falling, std::vector<ContactReuse::Body> bodies,
              const std::function<void(std::size_t at_rest)>& tell);

// The referee of rest.

/// An object is at rest if no point of it moves farther than this in a unit of time, nor farther
/// than kMostRestWay while it is watched, in least sides of its thinnest convex piece.
inline constexpr double kRestWay = 0.04, kMostRestWay = 0.1;
/// s, or a unit of time if that is more, for which objects are watched: at first until Bullet would
/// have put them to sleep, which takes two seconds. A heap of 1000 objects of which a quarter can
/// roll is that still only after 45 to 72 rounds, so that the shorter time then is enough.
inline constexpr double kSleepSpan = 2.5, kRestSpan = 1;

struct Unrest {
  std::vector<std::uint32_t> moved;     ///< farther than an object at rest may
  std::vector<std::uint32_t> restless;  ///< so fast that they will have by the end of the time
  double way = 0;                       ///< of the one that went farthest, in its least sides
  double seconds = 0;                   ///< for which they were watched
};
/// Steps `engine` as a run would, for the time that it watches, or until more than `permitted`
/// objects have moved. Where nothing moves, this is the motion with which a run begins that starts
/// like the engine.
Unrest WatchUnrest(world::Engine& engine, const Falling& falling, double span = kRestSpan,
                   std::size_t permitted = SIZE_MAX);

/// Goes on for this time, s, with strong damping, so that what still moves finds a place sooner
/// than if it began at rest each time it is watched. `bodies` are all objects of the engine. Where
/// only a few are restless, all that do not touch them are fixed, for the rest of the engine's
/// life.
void CalmDown(world::Engine& engine, const Falling& falling, std::vector<ContactReuse::Body> bodies,
              double seconds, const std::vector<std::uint32_t>& restless);

}  // namespace cdb::worker
