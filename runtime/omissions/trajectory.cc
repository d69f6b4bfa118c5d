#include "runtime/omissions/trajectory.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "runtime/omissions/omissions.h"

namespace cdb::omissions {
namespace {

using Eigen::Vector3d;
using layouts::ObjectState;
using objects::Solid;

/// btPersistentManifold's breaking threshold, as a fraction of the shape's angular motion disc.
constexpr double kThreshold = 0.02;
/// Operations other than the steps whose rounding counts: conversion of start, timestep and
/// acceleration to Bullet's numbers, F = m g and back, and those of the detection.
constexpr double kOtherOperations = 32;

/// The distance by which Bullet's rounded corners may protrude from the solid. Its margin is never
/// more than the least half extent.
double MarginOf(const ObjectState& object) {
  if (object.solid.IsBall()) return 0;
  return std::min(object.numbers["margin"], object.solid.HalfExtents().minCoeff());
}

/// Bound of btCollisionShape::getAngularMotionDisc: that of the ball around the shape's box, which
/// for a ball is a cube, and for a compound is made of the boxes of its rotated pieces.
double AngularMotionDisc(const Solid& solid) {
  if (solid.compound != nullptr) return 4 * std::sqrt(3.0) * solid.OuterRadius();
  return solid.HalfExtents().stableNorm() + std::abs(solid.BoxCentre());
}

/// True if the moments of inertia are equal and nothing slows the spin, so that it stays constant.
bool SpinsSteadily(const ObjectState& object) {
  const Vector3d moments = object.solid.InertiaPerMass();
  return moments.x() == moments.y() && moments.y() == moments.z() &&
         object.numbers["angular_damping"] == 0;
}

/// The times from 0 to `end`, in order, between which the distance |d + w t + g t^2/2| is
/// monotonic.
class Turns {
 public:
  Turns(const Vector3d& d, const Vector3d& w, const Vector3d& g, double end) {
    Add(0);
    // Half the derivative of the squared distance.
    const std::array<double, 4> slope{d.dot(w), w.dot(w) + d.dot(g), 1.5 * w.dot(g), g.dot(g) / 2};
    if (slope[3] == 0) {
      if (slope[1] > 0) AddWithin(-slope[0] / slope[1], end);
    } else {
      AddRoots(slope, end);
    }
    Add(end);
  }
  const double* begin() const { return times_.data(); }
  const double* end() const { return times_.data() + count_; }

 private:
  void Add(double time) { times_[count_++] = time; }
  void AddWithin(double time, double end) {
    if (time > 0 && time < end) Add(time);
  }

  void AddRoots(const std::array<double, 4>& slope, double end) {
    const auto at = [&](double t) {
      return slope[0] + t * (slope[1] + t * (slope[2] + t * slope[3]));
    };
    // The slope is monotonic between its own turning points, so each part has at most one root.
    std::array<double, 4> parts{0, 0, 0, end};
    const double b = slope[2], discriminant = b * b - 3 * slope[3] * slope[1];
    const double q = -(b + std::copysign(std::sqrt(std::max(discriminant, 0.0)), b));
    if (q != 0) {
      parts[1] = std::clamp(q / (3 * slope[3]), 0.0, end);
      parts[2] = std::clamp(slope[1] / q, 0.0, end);
      if (parts[1] > parts[2]) std::swap(parts[1], parts[2]);
    }
    for (std::size_t i = 0; i + 1 < parts.size(); ++i) {
      const double first = at(parts[i]), last = at(parts[i + 1]);
      if (!((first < 0) != (last < 0))) continue;
      double low = parts[i], high = parts[i + 1];
      for (int halving = 0; halving < 60; ++halving) {
        const double middle = low + (high - low) / 2;
        ((at(middle) < 0) == (first < 0) ? low : high) = middle;
      }
      AddWithin(low, end);
    }
  }

  std::array<double, 5> times_{};
  std::size_t count_ = 0;
};

}  // namespace

// Rounding to nearest errs by at most u = rounding / 2 of the result. A step adds g dt to the
// velocity, which errs by u |v| and, with F = m g, F / m and the product with dt, by 5 u |g| dt:
// after k steps the error of the velocity is at most u (k + 12) |v|. A step of the position errs by
// u (|x| + 2 |v| dt) and adds the velocity's error: after K steps u (K + 14) (|x| + T |v|) in all.
// Start, timestep and detection are the other operations; `rounding` doubles all of it.
double Horizon::PlaceError(double largest_place, double largest_speed) const {
  // Objects that do not move are rounded only at the start and by detection.
  const double operations = largest_speed == 0 ? kOtherOperations : steps + kOtherOperations;
  return rounding * operations * (largest_place + end * largest_speed);
}

double Horizon::SpeedError(double largest_speed) const {
  return rounding * (steps + kOtherOperations) * largest_speed;
}

Horizon HorizonOf(const plan::Scene& scene) {
  Horizon horizon;
  horizon.timestep = scene.world.Real("timestep");
  horizon.steps = static_cast<double>(scene.world.Count("warmup") + scene.world.Count("cycles"));
  horizon.end = (horizon.steps + 1) * horizon.timestep;
  horizon.rounding = scene.world.WordOr("precision") == "single"
                         ? static_cast<double>(std::numeric_limits<float>::epsilon())
                         : std::numeric_limits<double>::epsilon();
  return horizon;
}

Vector3d FallUntil(const Vector3d& acceleration, double timestep, double time) {
  return acceleration * (time * (timestep + time) / 2);
}

Box RangeOf(const Vector3d& c0, const Vector3d& c1, const Vector3d& c2, double begin, double end) {
  const auto at = [&](double t) -> Vector3d { return c0 + t * (c1 + t * c2); };
  Box box(at(begin));
  box.extend(at(end));
  for (int axis = 0; axis < 3; ++axis) {
    const double vertex = -c1[axis] / (2 * c2[axis]);  // not finite if there is none
    if (!(vertex > begin && vertex < end)) continue;
    const double extreme = c0[axis] + vertex * (c1[axis] + vertex * c2[axis]);
    box.min()[axis] = std::min(box.min()[axis], extreme);
    box.max()[axis] = std::max(box.max()[axis], extreme);
  }
  return box;
}

Vector3d Trajectory::PlaceAt(double time) const {
  return start + velocity * time + FallUntil(acceleration, timestep, time);
}

Box Trajectory::PathUntil(double time) const {
  switch (motion) {
    case Motion::kFixed:
      return Box(start);
    case Motion::kFree:
      return RangeOf(start, velocity + acceleration * (timestep / 2), acceleration / 2, 0, time);
    case Motion::kSlowed:
      break;
  }
  // Along an axis, the velocity after j steps is between min(v, 0) + min(g, 0) j dt and the same
  // with max: damping and sleep bring it nearer to 0, and a step adds g dt or, asleep, nothing.
  const Vector3d fall = FallUntil(acceleration, timestep, time);
  return {start + velocity.cwiseMin(0) * time + fall.cwiseMin(0),
          start + velocity.cwiseMax(0) * time + fall.cwiseMax(0)};
}

Box Trajectory::FallingPathUntil(double time, const Vector3d& gravity) const {
  if (motion == Motion::kFree) {
    Box box(start);
    box.extend(start + velocity * time);
    return box;
  }
  const Box path = PathUntil(time);
  const Vector3d fall = FallUntil(gravity, timestep, time);
  return {path.min() - fall.cwiseMax(0), path.max() - fall.cwiseMin(0)};
}

double Trajectory::FastestUntil(double time) const {
  if (motion == Motion::kFixed) return 0;
  // A norm is convex, so a free object is fastest at the start or at the end.
  const double last = motion == Motion::kFree
                          ? (velocity + acceleration * time).stableNorm()
                          : velocity.stableNorm() + acceleration.stableNorm() * time;
  return std::max(velocity.stableNorm(), last);
}

double LongestRest(const ObjectState& object, const Vector3d& acceleration,
                   const Horizon& horizon) {
  const double spin = object.angular_velocity.stableNorm();
  // The gyroscopic term, w x I w, is only rounding if the moments are equal.
  const double spin_error = horizon.SpeedError(spin) * (8 + 4 * spin * horizon.timestep);
  if (SpinsSteadily(object) && spin - spin_error >= kSlowSpin) return 0;
  // A damped object becomes slow in the end, and gravity may keep it slow.
  if (object.numbers["linear_damping"] > 0) return horizon.end;
  const Vector3d& v = object.linear_velocity;
  const double g = acceleration.stableNorm();
  const double slow = kSlowSpeed + horizon.SpeedError(v.stableNorm() + g * horizon.end);
  // The quadratic below needs a gravity that is not negligible.
  if (g * horizon.end < 1e-9) return v.stableNorm() - g * horizon.end < slow ? horizon.end : 0;
  // |v + g t| < slow between the roots of a quadratic.
  const Vector3d along = acceleration / g;
  const double middle = -v.dot(along) / g;
  const double across = (v - v.dot(along) * along).stableNorm();
  if (!(across < slow)) return 0;
  const double half = std::sqrt((slow - across) * (slow + across)) / g;
  const double begin = std::max(0.0, middle - half);
  const double end = std::min(horizon.end, middle + half);
  if (!(begin <= end)) return 0;
  // Each step in which Bullet finds it slow counts as one timestep.
  return std::min(end - begin + horizon.timestep, horizon.end);
}

Trajectory TrajectoryOf(const ObjectState& object, const Vector3d& acceleration,
                        const plan::Scene& scene, const Horizon& horizon) {
  Trajectory trajectory;
  const double margin = MarginOf(object);
  trajectory.timestep = horizon.timestep;
  trajectory.start = object.pose.position;
  trajectory.radius = object.solid.OuterRadius() + margin;
  trajectory.threshold = kThreshold * AngularMotionDisc(object.solid);
  trajectory.velocity = trajectory.acceleration = Vector3d::Zero();
  if (!object.IsFixed()) {
    trajectory.velocity = object.linear_velocity;
    trajectory.acceleration = acceleration;
    // 1 % for the error of Bullet's sum of the time asleep, in its own precision.
    const bool may_sleep = scene.world.On("sleeping") &&
                           LongestRest(object, acceleration, horizon) >= 0.99 * kSleepAfter;
    trajectory.motion =
        object.numbers["linear_damping"] > 0 || may_sleep ? Motion::kSlowed : Motion::kFree;
  }
  const Vector3d fastest =
      trajectory.velocity.cwiseAbs() + trajectory.acceleration.cwiseAbs() * horizon.end;
  for (int axis = 0; axis < 3; ++axis)
    trajectory.slack[axis] = horizon.PlaceError(
        std::abs(trajectory.start[axis]) + trajectory.radius + horizon.end * fastest[axis],
        fastest[axis]);
  trajectory.extent = Vector3d::Constant(trajectory.radius);
  if (object.IsFixed() || object.angular_velocity.isZero(0)) {
    // Without spin, the orientation is constant up to rounding, which may turn it a little in each
    // step.
    const objects::Box bounds = objects::Bounds(object.solid, object.pose.orientation);
    const double turned = 4 * horizon.SpeedError(trajectory.radius);
    const Vector3d half = bounds.upper.cwiseMax(-bounds.lower).array() + (margin + turned);
    trajectory.extent = trajectory.extent.cwiseMin(half);
  }
  return trajectory;
}

double TouchingDistance(const Trajectory& a, const Trajectory& b) {
  return a.radius + b.radius + std::min(a.threshold, b.threshold);
}

double Distance(const Box& a, const Box& b) { return std::sqrt(a.squaredExteriorDistance(b)); }

Approach ApproachOf(const Trajectory& a, const Trajectory& b, double end) {
  const Vector3d d = a.start - b.start;
  const Vector3d g = a.acceleration - b.acceleration;
  const Vector3d w = a.velocity - b.velocity + g * (a.timestep / 2);
  const double touching = TouchingDistance(a, b) + (a.slack + b.slack).stableNorm();
  const auto distance = [&](double t) { return (d + t * (w + t / 2 * g)).stableNorm(); };
  Approach approach{.gap = std::numeric_limits<double>::infinity()};
  double before = 0;
  for (const double turn : Turns(d, w, g, end)) {
    const double gap = distance(turn) - touching;
    if (!(gap > 0)) {
      const double first =
          FirstTime(turn - before, [&](double t) { return !(distance(before + t) > touching); });
      return {.meets = true, .time = before + first};
    }
    approach.gap = std::min(approach.gap, gap);
    before = turn;
  }
  return approach;
}

Approach BoxApproachOf(const Trajectory& a, const Trajectory& b, double end) {
  const double touching = TouchingDistance(a, b) + (a.slack + b.slack).stableNorm();
  const auto gap = [&](double t) { return Distance(a.PathUntil(t), b.PathUntil(t)) - touching; };
  const auto apart = gap(end);
  if (apart > 0) return {.gap = apart};
  return {.meets = true, .time = FirstTime(end, [&](double t) { return !(gap(t) > 0); })};
}

Box Grown(const Box& box, double by) { return {box.min().array() - by, box.max().array() + by}; }

double Region::Radius(double time) const {
  const double left = time - since;
  return radius + std::min(rate * left + more * (time * time - since * since) / 2, limit * left);
}

Box Region::Core(double time) const {
  const Vector3d moved = drift * (time - since) + FallUntil(gravity, timestep, time) -
                         FallUntil(gravity, timestep, since);
  return {core.min() + moved, core.max() + moved};
}

Box Region::Hull(double time) const {
  // As a parabola in the time since the start.
  const Vector3d c0 = -drift * since - FallUntil(gravity, timestep, since);
  const Box moved = RangeOf(c0, drift + gravity * (timestep / 2), gravity / 2, since, time);
  return Grown({core.min() + moved.min(), core.max() + moved.max()}, Radius(time) + error);
}

ObjectMotions::ObjectMotions(const std::vector<Trajectory>& trajectories,
                             const Vector3d& acceleration, const Horizon& horizon)
    : trajectories_(trajectories),
      fall_(acceleration.stableNorm() * (horizon.end + horizon.timestep)),
      versions_(trajectories.size()),
      regions_(trajectories.size()) {}

void ObjectMotions::SetRegion(std::size_t object, const Region& region) {
  regions_[object] = region;
  ++versions_[object];
}

Ball ObjectMotions::BallAt(std::size_t object, double time) const {
  if (!IsInFlight(object)) {
    const Region& region = regions_[object];
    return {region.Core(time), region.Radius(time)};
  }
  const Trajectory& trajectory = trajectories_[object];
  if (trajectory.motion == Motion::kSlowed) return {trajectory.PathUntil(time), 0};
  return {Box(trajectory.PlaceAt(time)), 0};
}

double ObjectMotions::ErrorOf(std::size_t object) const {
  return IsInFlight(object) ? trajectories_[object].slack.stableNorm() : regions_[object].error;
}

double ObjectMotions::FastestInWorld(std::size_t object) const {
  if (IsFixed(object)) return 0;
  if (IsInFlight(object)) return trajectories_[object].velocity.stableNorm() + fall_;
  const Region& region = regions_[object];
  return region.limit + region.drift.stableNorm() + (region.gravity.isZero(0) ? 0 : fall_);
}

double ObjectMotions::FastestInAir(std::size_t object) const {
  if (IsInFlight(object)) {
    if (trajectories_[object].motion == Motion::kFree)
      return trajectories_[object].velocity.stableNorm();
  } else if (!regions_[object].gravity.isZero(0)) {
    return regions_[object].limit + regions_[object].drift.stableNorm();
  }
  return FastestInWorld(object) + fall_;
}

int BestSweepAxis(const std::vector<SweptBox>& boxes) {
  Box room;
  Eigen::Vector3d lengths = Eigen::Vector3d::Zero();
  for (const SweptBox& swept : boxes) {
    room.extend(swept.box);
    lengths += swept.box.sizes();
  }
  int best = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (lengths[axis] * room.sizes()[best] < lengths[best] * room.sizes()[axis]) best = axis;
  return best;
}

bool Sweep(std::vector<SweptBox> boxes, const SweepPartners& partners, std::uint64_t& tests_left,
           const std::function<void(std::uint32_t, std::uint32_t)>& report) {
  const int axis = BestSweepAxis(boxes);
  std::ranges::sort(boxes, {}, [&](const SweptBox& swept) { return swept.box.min()[axis]; });
  std::array<std::vector<const SweptBox*>, kSweepKinds> open;
  for (const SweptBox& swept : boxes) {
    for (std::size_t kind = 0; kind < kSweepKinds; ++kind) {
      if ((partners[swept.kind] >> kind & 1) == 0) continue;
      auto& others = open[kind];
      for (std::size_t i = 0; i < others.size();) {
        const SweptBox& other = *others[i];
        if (other.box.max()[axis] < swept.box.min()[axis]) {
          others[i] = others.back();
          others.pop_back();
          continue;
        }
        if (tests_left == 0) return false;
        --tests_left;
        if (swept.box.intersects(other.box)) report(swept.object, other.object);
        ++i;
      }
    }
    open[swept.kind].push_back(&swept);
  }
  return true;
}

SortedBoxes::SortedBoxes(std::vector<SweptBox> boxes)
    : axis_(BestSweepAxis(boxes)), boxes_(std::move(boxes)) {
  for (const SweptBox& swept : boxes_) longest_ = std::max(longest_, swept.box.sizes()[axis_]);
  std::ranges::sort(boxes_, {}, [&](const SweptBox& swept) { return swept.box.min()[axis_]; });
}

std::span<const SweptBox> SortedBoxes::Near(const Box& box) const {
  const auto least = [&](const SweptBox& swept) { return swept.box.min()[axis_]; };
  const auto begin = std::ranges::lower_bound(boxes_, box.min()[axis_] - longest_, {}, least);
  const auto end = std::ranges::upper_bound(begin, boxes_.end(), box.max()[axis_], {}, least);
  return {begin, end};
}

Room::Room(const plan::Scene& scene, const Horizon& horizon)
    : standing_(StandingWalls(scene)),
      half_(scene.world.Real("world.side") / 2),
      // Walls, and the objects near them, are at a distance of about half_. The omission guard
      // allows 16 of these.
      rounding_(32 * horizon.rounding * half_),
      // A box wall ends a little outside the cube, where only another box stops objects.
      is_endless_(scene.world.WordOr("world.wall_shape") == "plane" ||
                  scene.world.WordOr("world.walls") == "all") {}

double Room::Gap(int wall, const Box& places, double reach) const {
  const int axis = wall / 2;
  const double farthest = wall % 2 == 0 ? -places.min()[axis] : places.max()[axis];
  return half_ - rounding_ - reach - farthest;
}

}  // namespace cdb::omissions
