// How one object flies while nothing touches it: where it can be until a time, when two first come
// within touching distance, how long it is slow.
//
// A cycle of Bullet 3.24 damps the velocity, detects, adds g dt to the velocity and then moves by
// v dt, so that after k cycles an undamped object is at x0 + (v0 + g dt/2) t + g t^2/2, t = k dt.
// SI units; a path is that of the centre of mass. Nothing here throws;
// what overflows gives infinities or NaN, which the caller looks for. Any thread.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::pruning {

using Box = Eigen::AlignedBox3d;

/// How far ahead to look, and how exactly Bullet computes.
struct Horizon {
  double timestep = 0;  ///< s
  double steps = 0;     ///< warmup and cycles
  double end = 0;       ///< s; one step more than the run has, to be safe
  double rounding = 0;  ///< twice the largest relative error of one operation

  /// How far, along one axis, a computed place may be from the exact one, where neither the place
  /// nor the speed is ever larger than these.
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
  Eigen::Vector3d acceleration;  ///< 0 where fixed
  double radius = 0;     ///< of a ball about the centre of mass that holds it however it is turned
  double threshold = 0;  ///< Bullet makes a contact below this distance from a wall; of two
                         ///< objects the smaller one counts
  Eigen::Vector3d extent;  ///< half of a box that holds it until something touches it
  Eigen::Vector3d slack;   ///< rounding of the place until something touches it
  double timestep = 0;

  /// Of the centre while nothing touches it. Exact for free ones but for rounding; for slowed ones
  /// a place that the centre may have.
  Eigen::Vector3d PlaceAt(double time) const;
  /// Holds all places of the centre until `time`; the later, the larger.
  Box PathUntil(double time) const;
  /// The same as seen from a frame that falls from rest with `gravity`, the scene's: a straight
  /// line's box for free ones.
  Box FallingPathUntil(double time, const Eigen::Vector3d& gravity) const;
  /// m/s: never faster than this until `time`.
  double FastestUntil(double time) const;
};

Trajectory TrajectoryOf(const layouts::ObjectState& object, const Eigen::Vector3d& acceleration,
                        const plan::Scene& scene, const Horizon& horizon);

/// The way of a frame that falls from rest with `acceleration`.
Eigen::Vector3d FallUntil(const Eigen::Vector3d& acceleration, double timestep, double time);
/// Holds c0 + c1 t + c2 t^2 for all t from `begin` to `end`.
Box RangeOf(const Eigen::Vector3d& c0, const Eigen::Vector3d& c1, const Eigen::Vector3d& c2,
            double begin, double end);

/// Distance of the centres at which two make a contact, rounding not counted.
double TouchingDistance(const Trajectory& a, const Trajectory& b);

struct Approach {
  bool meets = false;
  double time = 0;  ///< s: not later than the first moment within touching distance, if they meet
  double gap = 0;   ///< m: the least distance beyond touching and rounding, if they do not
};
/// Two of which neither is slowed and not both are fixed.
Approach ApproachOf(const Trajectory& a, const Trajectory& b, double end);
/// Any two, by the boxes of their paths alone.
Approach BoxApproachOf(const Trajectory& a, const Trajectory& b, double end);

/// The distance between two boxes; 0 where they overlap.
double Distance(const Box& a, const Box& b);

/// The first time up to `end` at which `is_true`, which stays true once it is, to the last bit on
/// the early side. `is_true(end)` must be true.
template <typename Predicate>
double FirstTime(double end, const Predicate& is_true) {
  if (is_true(0.0)) return 0;
  double before = 0, after = end;
  // Halving a double reaches the last bit of any time that matters in 60.
  for (int i = 0; i < 60; ++i) {
    const double middle = before + (after - before) / 2;
    (is_true(middle) ? after : before) = middle;
  }
  return before;
}

/// Bullet's thresholds of sleep: an object is slow below both, and is put to sleep after as long.
inline constexpr double kSlowSpeed = 0.8, kSlowSpin = 1.0, kSleepAfter = 2.0;
/// The longest time in a row that a moving object in free flight is slow, s, at most `end`. What
/// Bullet counts: a step for each time it looks and finds the object slow.
double LongestRest(const layouts::ObjectState& object, const Eigen::Vector3d& acceleration,
                   const Horizon& horizon);

}  // namespace cdb::pruning
