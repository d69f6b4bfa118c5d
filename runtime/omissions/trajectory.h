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
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "compiler/analysis/reference.h"
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

// The possible positions of each object: on its trajectory until its first possible contact, in a
// growing region from then on.
//
// SI units. Errors: none. Threads: one.

/// All points within `radius` of a box.
struct Ball {
  Box core;
  double radius;
};

Box Grown(const Box& box, double by);

/// The positions that the centre of an object may have after its first possible contact: a box
/// that moves uniformly or falls, and all points within `Radius` of it.
struct Region {
  double since = 0;
  Box core;                 ///< at `since`
  Eigen::Vector3d drift;    ///< m/s
  Eigen::Vector3d gravity;  ///< 0 in the world frame
  double timestep = 0;
  double radius = 0;                     ///< m, at `since`
  double rate = 0, more = 0, limit = 0;  ///< it grows by min(rate + more t, limit)
  double error = 0;                      ///< m: rounding

  double Radius(double time) const;
  Box Core(double time) const;
  /// A box that contains the region until `time`.
  Box Hull(double time) const;
};

class ObjectMotions {
 public:
  /// The arguments must outlive the object.
  ObjectMotions(const std::vector<Trajectory>& trajectories, const Eigen::Vector3d& acceleration,
                const Horizon& horizon);

  const Trajectory& trajectory(std::size_t object) const { return trajectories_[object]; }
  bool IsFixed(std::size_t object) const { return trajectory(object).motion == Motion::kFixed; }

  /// Call when the object has a contact, the first or a later one.
  void SetRegion(std::size_t object, const Region& region);
  /// 0 in free flight; each new region changes it.
  std::uint32_t version(std::size_t object) const { return versions_[object]; }
  bool IsInFlight(std::size_t object) const { return version(object) == 0; }
  /// The region of an object that is not in free flight.
  const Region& region(std::size_t object) const { return regions_[object]; }

  /// The possible positions of the object's centre at `time`.
  Ball BallAt(std::size_t object, double time) const;
  /// m: the rounding error of BallAt.
  double ErrorOf(std::size_t object) const;
  /// m/s: bound of the speed of the surface of BallAt, in the world and in the falling frame.
  double FastestInWorld(std::size_t object) const;
  double FastestInAir(std::size_t object) const;

 private:
  const std::vector<Trajectory>& trajectories_;
  const double fall_;                    ///< m/s: velocity that gravity adds until the end
  std::vector<std::uint32_t> versions_;  ///< by object
  std::vector<Region> regions_;          ///< by object
};

// Finds overlapping pairs in a large set of boxes by one sweep along an axis, and the boxes near
// another one.

inline constexpr std::size_t kSweepKinds = 4;

struct SweptBox {
  Box box;
  std::uint32_t object = 0;
  std::uint8_t kind = 0;  ///< below kSweepKinds
};

/// The axis along which the boxes are shortest relative to the extent of all boxes.
int BestSweepAxis(const std::vector<SweptBox>& boxes);

/// Bit b of entry a: a box of kind a is tested against those of kind b. Must be symmetric.
using SweepPartners = std::array<std::uint8_t, kSweepKinds>;

/// Calls `report` once for each pair of boxes of partner kinds that overlap or touch. Decrements
/// `tests_left` for each pair that overlaps along the axis; if it runs out, returns false without
/// reporting all pairs. No box may contain a NaN.
bool Sweep(std::vector<SweptBox> boxes, const SweepPartners& partners, std::uint64_t& tests_left,
           const std::function<void(std::uint32_t, std::uint32_t)>& report);

/// Boxes sorted along their best axis, for queries by a box.
class SortedBoxes {
 public:
  SortedBoxes() = default;
  /// No box may contain a NaN.
  explicit SortedBoxes(std::vector<SweptBox> boxes);

  /// All boxes that overlap `box` along the axis, and some more.
  std::span<const SweptBox> Near(const Box& box) const;

 private:
  int axis_ = 0;
  double longest_ = 0;
  std::vector<SweptBox> boxes_;
};

// The cube that contains the objects, and its clearance from an object.
//
// SI units. Errors: none. Threads: any.

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
