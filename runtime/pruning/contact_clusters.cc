#include "runtime/pruning/contact_clusters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
#include <utility>

#include "runtime/pruning/omissions.h"
#include "runtime/pruning/swept_boxes.h"

namespace cdb::pruning {
namespace {

using Eigen::Vector3d;
using layouts::ObjectState;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kNoCrowd = std::numeric_limits<std::uint32_t>::max();

/// Bullet pushes what has sunk in out again, without regard to energy: by `solver.erp` of the depth
/// each step. What sinks in within a step has come that far in it, so this is as if speeds were
/// larger by erp. The rest is for what the solver leaves undone in its iterations.
constexpr double kSpeedFactor = 1.3;
/// m: shallower than this Bullet mends a penetration by velocity, which stays
/// (m_splitImpulsePenetrationThreshold), unless `contact faithful` forbids it.
constexpr double kShallow = 0.04;
/// So near to touching, for its size, counts as touching, and after so many steps towards it too.
constexpr double kNearly = 1e-3;
constexpr int kMaxApproaches = 200;
/// What such a step costs beside a test of two boxes.
constexpr std::uint64_t kTestsOfApproach = 4;

Box Grown(const Box& box, double by) { return {box.min().array() - by, box.max().array() + by}; }

double LargestPlace(const Box& box) {
  return box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
}

}  // namespace

Room::Room(const plan::Scene& scene, const Horizon& horizon)
    : standing_(StandingWalls(scene)),
      half_(scene.world.Real("world.side") / 2),
      // A wall is half_ away, and so is what comes near it: the tripwire allows 16 of these.
      rounding_(32 * horizon.rounding * half_),
      // A box ends a little outside the cube, where only another box stops what moves there.
      is_endless_(scene.world.WordOr("world.wall_shape") == "plane" ||
                  scene.world.WordOr("world.walls") == "all") {}

double Room::Gap(int wall, const Box& places, double reach) const {
  const int axis = wall / 2;
  const double farthest = wall % 2 == 0 ? -places.min()[axis] : places.max()[axis];
  return half_ - rounding_ - reach - farthest;
}

bool ContactClusters::Event::operator>(const Event& event) const {
  const auto key = [](const Event& it) { return std::tie(it.time, it.object, it.other, it.wall); };
  return key(*this) > key(event);
}

double ContactClusters::Region::Radius(double time) const {
  const double left = time - since;
  return radius + std::min(rate * left + more * (time * time - since * since) / 2, limit * left);
}

Box ContactClusters::Region::Core(double time) const {
  const Vector3d moved = drift * (time - since) + FallUntil(gravity, timestep, time) -
                         FallUntil(gravity, timestep, since);
  return {core.min() + moved, core.max() + moved};
}

Box ContactClusters::Region::Hull(double time) const {
  // As a parabola in the time from the start.
  const Vector3d c0 = -drift * since - FallUntil(gravity, timestep, since);
  const Box moved = RangeOf(c0, drift + gravity * (timestep / 2), gravity / 2, since, time);
  return Grown({core.min() + moved.min(), core.max() + moved.max()}, Radius(time) + error);
}

ContactClusters::ContactClusters(const plan::Scene& scene, const layouts::InitialState& state,
                                 const Horizon& horizon, const Room& room,
                                 const std::vector<Trajectory>& flights)
    : state_(state),
      horizon_(horizon),
      room_(room),
      flights_(flights),
      sleeps_(scene.world.On("sleeping")),
      is_faithful_(scene.world.WordOr("contact") == "faithful"),
      erp_(scene.world.Real("solver.erp")),
      crowd_of_(flights.size(), kNoCrowd),
      version_(flights.size()),
      regions_(flights.size()),
      walls_(flights.size()) {}

void ContactClusters::MeetObject(std::size_t object, std::size_t other, double time) {
  events_.push({time, static_cast<std::uint32_t>(object), static_cast<std::uint32_t>(other), -1,
                version_[object], version_[other]});
}

void ContactClusters::MeetWall(std::size_t object, int wall, double time) {
  events_.push({time, static_cast<std::uint32_t>(object), static_cast<std::uint32_t>(object), wall,
                version_[object], version_[object]});
}

std::size_t ContactClusters::Largest() const {
  std::size_t largest = 1;
  for (const ContactCluster& crowd : crowds_) largest = std::max(largest, crowd.members.size());
  return largest;
}

double ContactClusters::KineticEnergy(std::size_t object, const Vector3d& frame) const {
  const ObjectState& it = state_.objects[object];
  const Vector3d spin = it.pose.orientation.conjugate() * it.angular_velocity;
  return it.mass *
         ((it.linear_velocity - frame).squaredNorm() +
          spin.cwiseAbs2().dot(it.solid.InertiaPerMass())) /
         2;
}

/// J: the work that gravity can do on the object until walls hold it. A step of Bullet's loses
/// g^2 dt^2 / 2 of a falling object's energy per mass, which is as much as the push out of a wall
/// gives back when it has sunk in by a step's way.
double ContactClusters::WeightedDrop(std::size_t object) const {
  const ObjectState& it = state_.objects[object];
  double work = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double g = state_.acceleration[axis];
    if (g == 0) continue;
    if (!room_.Holds(2 * axis + (g > 0 ? 1 : 0))) return kInfinity;
    const double sunk = flights_[object].FastestUntil(horizon_.end) * horizon_.timestep;
    // A faster one could pass through a box in one step.
    if (sunk > kWallThickness * room_.half()) return kInfinity;
    const double lowest = room_.half() - it.solid.InnerRadius() + sunk;
    work += std::abs(g) * std::max(0.0, lowest - std::copysign(1.0, g) * it.pose.position[axis]);
  }
  return it.mass * work;
}

/// m/s: what bounces may add where Bullet mends shallow penetrations by velocity and the bounce
/// itself keeps so much that together they are more than what came in.
double ContactClusters::Boost(const ContactCluster& crowd, std::size_t object) const {
  if (is_faithful_ || crowd.restitution + erp_ <= 1) return 0;
  return (1 + erp_) * kShallow / horizon_.timestep *
         std::sqrt(crowd.mass / state_.objects[object].mass);
}

/// m/s relative to the crowd's centre of mass while nothing from outside acts on it but gravity.
double ContactClusters::SpeedInAir(const ContactCluster& crowd, std::size_t object) const {
  return (kSpeedFactor + erp_) * std::sqrt(2 * crowd.energy_in_air / state_.objects[object].mass) +
         Boost(crowd, object);
}

/// Whether the crowd's energy in the falling frame never grows. Sleep stops an object in the world,
/// which could make it faster in the frame; but to be slow in the world for as long as sleep takes
/// it must first have changed its velocity in the frame by nearly all of g times that.
bool ContactClusters::FallsFreely(const ContactCluster& crowd) const {
  if (crowd.leans || crowd.is_slowed) return false;
  if (!sleeps_) return true;
  const double change =
      state_.acceleration.stableNorm() * (kSleepAfter - horizon_.timestep) - 2.02 * kSlowSpeed;
  return std::ranges::all_of(crowd.members,
                             [&](std::uint32_t i) { return 2 * SpeedInAir(crowd, i) < change; });
}

/// The crowd of the object, alone in a new one if need be.
std::uint32_t ContactClusters::Join(std::size_t object) {
  if (crowd_of_[object] != kNoCrowd) return crowd_of_[object];
  const ObjectState& it = state_.objects[object];
  crowd_of_[object] = static_cast<std::uint32_t>(crowds_.size());
  touched_.push_back(static_cast<std::uint32_t>(object));
  ContactCluster& crowd = crowds_.emplace_back();
  crowd.members = {static_cast<std::uint32_t>(object)};
  crowd.is_slowed = flights_[object].motion == Motion::kSlowed;
  crowd.mass = it.mass;
  crowd.momentum = it.mass * it.linear_velocity;
  crowd.energy = KineticEnergy(object, Vector3d::Zero());
  crowd.energy_of_drop = WeightedDrop(object);
  crowd.restitution = it.restitution;
  return crowd_of_[object];
}

void ContactClusters::Merge(std::uint32_t to, std::uint32_t from) {
  if (to == from) return;
  ContactCluster &into = crowds_[to], &other = crowds_[from];
  for (const std::uint32_t i : other.members) crowd_of_[i] = to;
  into.members.insert(into.members.end(), other.members.begin(), other.members.end());
  into.leans = into.leans || other.leans;
  into.is_slowed = into.is_slowed || other.is_slowed;
  into.mass += other.mass;
  into.momentum += other.momentum;
  into.energy += other.energy;
  into.energy_of_drop += other.energy_of_drop;
  into.restitution = std::max(into.restitution, other.restitution);
  other = {};
}

ContactClusters::Region ContactClusters::RegionFrom(const ContactCluster& crowd, bool falls,
                                                    std::size_t object, double time) const {
  const Ball ball = BallOf(object, time);
  const Vector3d& g = state_.acceleration;
  Region region;
  region.since = time;
  region.core = ball.core;
  region.radius = ball.radius;
  region.drift = region.gravity = Vector3d::Zero();
  region.timestep = horizon_.timestep;
  const double fall = g.stableNorm() * (horizon_.end + horizon_.timestep);
  double fastest = 0;
  if (falls) {
    region.drift = crowd.momentum / crowd.mass;
    region.gravity = g;
    region.rate = region.limit = SpeedInAir(crowd, object);
    fastest = region.rate + region.drift.stableNorm() + fall;
  } else {
    // sqrt(2 E) is the length of the velocities weighted by the masses' roots. Gravity adds
    // |g| sqrt(M) dt to it in a step; and energy that walls hold is bounded besides.
    const double factor = (kSpeedFactor + erp_) / std::sqrt(state_.objects[object].mass);
    const double boost = Boost(crowd, object);
    const double per_second = g.stableNorm() * std::sqrt(crowd.mass);
    const double per_step = per_second * horizon_.timestep;
    region.rate = factor * (std::sqrt(2 * crowd.energy) + per_step) + boost;
    region.more = factor * per_second;
    fastest = region.rate + region.more * horizon_.end;
    const double held = std::sqrt(2 * (crowd.energy + crowd.energy_of_drop));
    fastest = region.limit = std::min(fastest, factor * (held + per_step) + boost);
  }
  region.error =
      std::sqrt(3.0) * horizon_.PlaceError(LargestPlace(region.Hull(horizon_.end)), fastest);
  return region;
}

/// Where the object is at `time`.
ContactClusters::Ball ContactClusters::BallOf(std::size_t object, double time) const {
  if (!IsInFlight(object)) {
    const Region& region = regions_[object];
    return {region.Core(time), region.Radius(time)};
  }
  const Trajectory& flight = flights_[object];
  if (flight.motion == Motion::kSlowed) return {flight.PathUntil(time), 0};
  return {Box(flight.PlaceAt(time)), 0};
}

double ContactClusters::ErrorOf(std::size_t object) const {
  return IsInFlight(object) ? flights_[object].slack.stableNorm() : regions_[object].error;
}

/// m/s: the surface of BallOf is never faster, in the world and in the falling frame.
double ContactClusters::FastestInWorld(std::size_t object) const {
  const double fall = state_.acceleration.stableNorm() * (horizon_.end + horizon_.timestep);
  if (IsFixed(object)) return 0;
  if (IsInFlight(object)) return flights_[object].velocity.stableNorm() + fall;
  const Region& region = regions_[object];
  return region.limit + region.drift.stableNorm() + (region.gravity.isZero(0) ? 0 : fall);
}
double ContactClusters::FastestInAir(std::size_t object) const {
  const double fall = state_.acceleration.stableNorm() * (horizon_.end + horizon_.timestep);
  if (IsInFlight(object)) {
    if (flights_[object].motion == Motion::kFree) return flights_[object].velocity.stableNorm();
  } else if (!regions_[object].gravity.isZero(0)) {
    return regions_[object].limit + regions_[object].drift.stableNorm();
  }
  return FastestInWorld(object) + fall;
}

bool ContactClusters::Spend(std::uint64_t tests) {
  has_given_up_ = has_given_up_ || *tests_left_ < tests;
  *tests_left_ -= std::min(*tests_left_, tests);
  return !has_given_up_;
}

/// A time from `begin` on, not later than the first at which `gap` is 0 or less, if there is one;
/// `gap` never shrinks faster than `fastest`.
template <typename Gap>
std::optional<double> ContactClusters::FirstContact(double begin, double fastest, double near,
                                                    const Gap& gap) {
  double time = begin;
  for (int i = 0; i < kMaxApproaches; ++i) {
    if (!Spend(kTestsOfApproach)) return time;
    const double left = gap(time);
    if (!(left > near)) return time;
    time += left / fastest;
    if (time > horizon_.end) return std::nullopt;
  }
  return time;
}

void ContactClusters::ForeseeWalls(std::size_t object) {
  const Trajectory& flight = flights_[object];
  const double reach = flight.radius + flight.threshold + regions_[object].error;
  for (int wall = 0; wall < kWallCount; ++wall) {
    if (!room_.Stands(wall) || (walls_[object] >> wall & 1) != 0) continue;
    if (room_.Gap(wall, regions_[object].Hull(horizon_.end), reach) > 0) continue;
    const auto time = FirstContact(regions_[object].since, FastestInWorld(object),
                                   kNearly * flight.radius, [&](double t) {
                                     const Ball ball = BallOf(object, t);
                                     return room_.Gap(wall, ball.core, ball.radius + reach);
                                   });
    if (time) MeetWall(object, wall, *time);
  }
}

void ContactClusters::ForeseeMeeting(std::size_t object, std::size_t other) {
  // A crowd that leans has nothing new to learn from another fixed object.
  if (IsFixed(other) && CrowdOf(object).leans) return;
  const double touching =
      TouchingDistance(flights_[object], flights_[other]) + ErrorOf(object) + ErrorOf(other);
  const double fastest = std::min(FastestInWorld(object) + FastestInWorld(other),
                                  FastestInAir(object) + FastestInAir(other));
  const auto time =
      FirstContact(regions_[object].since, fastest, kNearly * touching, [&](double t) {
        const Ball a = BallOf(object, t), b = BallOf(other, t);
        return Distance(a.core, b.core) - a.radius - b.radius - touching;
      });
  if (time) MeetObject(object, other, *time);
}

void ContactClusters::SortPaths() {
  std::vector<SweptBox> boxes;
  boxes.reserve(flights_.size());
  for (std::size_t i = 0; i < flights_.size(); ++i) {
    const Trajectory& flight = flights_[i];
    const double grown = flight.radius + flight.threshold / 2 + flight.slack.stableNorm();
    boxes.push_back({Grown(flight.PathUntil(horizon_.end), grown), static_cast<std::uint32_t>(i)});
  }
  path_axis_ = BestSweepAxis(boxes);
  for (const SweptBox& swept : boxes) {
    longest_path_ = std::max(longest_path_, swept.box.sizes()[path_axis_]);
    paths_.push_back({swept.box, swept.object});
  }
  std::ranges::sort(paths_, {}, [&](const Path& path) { return path.box.min()[path_axis_]; });
}

void ContactClusters::ForeseeMeetings(std::size_t object) {
  const Trajectory& flight = flights_[object];
  const Box hull = Grown(regions_[object].Hull(horizon_.end), flight.radius + flight.threshold / 2);
  const auto begin =
      std::ranges::lower_bound(paths_, hull.min()[path_axis_] - longest_path_, {},
                               [&](const Path& path) { return path.box.min()[path_axis_]; });
  for (auto path = begin;
       path != paths_.end() && path->box.min()[path_axis_] <= hull.max()[path_axis_]; ++path) {
    if (!Spend(1)) return;
    if (IsInFlight(path->object) && path->box.intersects(hull))
      ForeseeMeeting(object, path->object);
  }
  for (const std::uint32_t other : touched_) {
    if (!Spend(1)) return;
    if (crowd_of_[other] != crowd_of_[object] && !IsInFlight(other)) ForeseeMeeting(object, other);
  }
}

/// Sends all of the crowd on new ways from `time`; false where one cannot be followed.
bool ContactClusters::Redirect(std::uint32_t crowd, double time) {
  ContactCluster& it = crowds_[crowd];
  const Vector3d velocity = it.momentum / it.mass;
  it.energy_in_air = 0;
  for (const std::uint32_t i : it.members) it.energy_in_air += KineticEnergy(i, velocity);
  const bool falls = FallsFreely(it);
  // What has once lost its momentum to the world does not get it back by meeting more.
  it.is_slowed = it.is_slowed || !falls;
  for (const std::uint32_t i : it.members) {
    const Region region = RegionFrom(it, falls, i, time);
    if (!(region.Hull(horizon_.end).diagonal().squaredNorm() < kInfinity)) return false;
    regions_[i] = region;
    ++version_[i];
  }
  for (const std::uint32_t i : it.members) {
    ForeseeWalls(i);
    ForeseeMeetings(i);
  }
  return true;
}

std::optional<std::string> ContactClusters::Follow(std::uint64_t& tests_left) {
  tests_left_ = &tests_left;
  SortPaths();
  while (!events_.empty()) {
    const Event event = events_.top();
    events_.pop();
    if (event.object_version != version_[event.object] ||
        event.other_version != version_[event.other])
      continue;
    for (const std::uint32_t i : {event.object, event.other})
      if (std::isfinite(state_.objects[i].contact_stiffness))
        return fmt::format("object {} has a soft contact, and may touch something", i + 1);
    if (event.wall >= 0) walls_[event.object] |= static_cast<std::uint8_t>(1 << event.wall);
    const bool is_alone = event.wall >= 0 || IsFixed(event.other);
    const bool is_known = is_alone && !IsInFlight(event.object) && CrowdOf(event.object).leans;
    if (is_known) continue;
    const std::uint32_t crowd = Join(event.object);
    if (is_alone) {
      crowds_[crowd].leans = true;
    } else {
      Merge(crowd, Join(event.other));
    }
    if (!Redirect(crowd, event.time))
      return fmt::format("object {} may get too far for the forecast's numbers", event.object + 1);
    if (has_given_up_) return "too many objects may meet to follow them all";
  }
  return std::nullopt;
}

}  // namespace cdb::pruning
