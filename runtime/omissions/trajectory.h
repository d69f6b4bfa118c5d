// Trajectory of an object without contacts: its possible positions until a given time, the time at
// which two objects first come within touching distance, and the duration for which an object is
// slow.
//
// A cycle of Bullet 3.24 damps the velocity, detects, adds g dt to the velocity and then moves by
// v dt, so that after k cycles an undamped object is at x0 + (v0 + g dt/2) t + g t^2/2, t = k dt.
// SI units; a trajectory is that of the centre of mass. Nothing here throws; overflow yields
// infinities or NaN, which the caller checks for. Threads: any.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "compiler/analysis/engine_constants.h"
#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::omissions {

using Box = Eigen::AlignedBox3d;

/// The duration of the run, and the rounding of Bullet.
struct Horizon {
  double timestep = 0;  ///< s
  double steps = 0;     ///< including warm-up
  double end = 0;       ///< s; one step more than the run, as a safety margin
  double rounding = 0;  ///< twice the largest relative error of one operation

  /// Upper bound of the error of a computed position along one axis, given upper bounds of position
  /// and speed.
  double PlaceError(double largest_place, double largest_speed) const;
  double SpeedError(double largest_speed) const;
};
Horizon HorizonOf(const plan::Scene& scene);

enum class Motion {
  kFixed,
  kFree,
  kSlowed,  ///< damped, or so slow that Bullet may put it to sleep: it may be anywhere between
            ///< rest and free flight
};

struct Trajectory {
  Motion motion = Motion::kFixed;
  Eigen::Vector3d start, velocity;
  Eigen::Vector3d acceleration;  ///< 0 if fixed
  double radius = 0;             ///< of the bounding sphere about the centre of mass
  double threshold = 0;          ///< Bullet makes a contact below this distance from a wall; for
                                 ///< two objects the smaller value counts
  Eigen::Vector3d extent;        ///< half extents of a box that contains it until the first contact
  Eigen::Vector3d slack;         ///< rounding of the position until the first contact
  double timestep = 0;

  /// Position of the centre before the first contact. Exact up to rounding for free objects; one of
  /// the possible positions for slowed ones.
  Eigen::Vector3d PlaceAt(double time) const;
  /// A box that contains all positions of the centre until `time`; grows with time.
  Box PathUntil(double time) const;
  /// The same in a frame that falls from rest with `gravity`, that of the scene: the box of a
  /// straight line for free objects.
  Box FallingPathUntil(double time, const Eigen::Vector3d& gravity) const;
  /// m/s: upper bound of the speed until `time`.
  double FastestUntil(double time) const;
};

Trajectory TrajectoryOf(const layouts::ObjectState& object, const Eigen::Vector3d& acceleration,
                        const plan::Scene& scene, const Horizon& horizon);

/// Displacement of a frame that falls from rest with `acceleration`.
Eigen::Vector3d FallUntil(const Eigen::Vector3d& acceleration, double timestep, double time);
/// A box that contains c0 + c1 t + c2 t^2 for all t from `begin` to `end`.
Box RangeOf(const Eigen::Vector3d& c0, const Eigen::Vector3d& c1, const Eigen::Vector3d& c2,
            double begin, double end);

/// Distance of the centres at which two objects make a contact, without rounding.
double TouchingDistance(const Trajectory& a, const Trajectory& b);

struct Approach {
  bool meets = false;
  double time = 0;  ///< s: if they meet, not later than the first moment within touching distance
  double gap =
      0;  ///< m: if they do not meet, the least clearance beyond touching distance and rounding
};
/// For two objects of which neither is slowed and not both are fixed.
Approach ApproachOf(const Trajectory& a, const Trajectory& b, double end);
/// For any two objects, using only the boxes of their trajectories.
Approach BoxApproachOf(const Trajectory& a, const Trajectory& b, double end);

/// The distance between two boxes; 0 if they overlap.
double Distance(const Box& a, const Box& b);

/// The first time up to `end` at which the monotonic predicate `is_true` holds, to the last bit on
/// the early side. `is_true(end)` must be true.
template <typename Predicate>
double FirstTime(double end, const Predicate& is_true) {
  if (is_true(0.0)) return 0;
  double before = 0, after = end;
  // 60 bisections reach the last bit of any relevant time.
  for (int i = 0; i < 60; ++i) {
    const double middle = before + (after - before) / 2;
    (is_true(middle) ? after : before) = middle;
  }
  return before;
}

using analysis::kSleepAfter;
using analysis::kSlowSpeed;
using analysis::kSlowSpin;
/// The longest uninterrupted time, s, for which a moving object in free flight is slow, at most
/// `end`, counted as Bullet does: one step for each step in which it finds the object slow.
double LongestRest(const layouts::ObjectState& object, const Eigen::Vector3d& acceleration,
                   const Horizon& horizon);

}  // namespace cdb::omissions
