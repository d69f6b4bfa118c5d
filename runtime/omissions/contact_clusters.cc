#include "runtime/omissions/contact_clusters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "runtime/omissions/omissions.h"

namespace cdb::omissions {
namespace {

constexpr std::uint32_t kNoCluster = std::numeric_limits<std::uint32_t>::max();

/// A gap smaller than this, relative to the size, counts as touching. So does an approach that
/// takes more than kMaxApproaches steps.
constexpr double kNearly = 1e-3;
constexpr int kMaxApproaches = 200;
/// The cost of such a step, in tests of two boxes.
constexpr std::uint64_t kTestsOfApproach = 4;

}  // namespace

bool ContactClusters::Event::operator>(const Event& event) const {
  const auto key = [](const Event& it) { return std::tie(it.time, it.object, it.other, it.wall); };
  return key(*this) > key(event);
}

ContactClusters::ContactClusters(const plan::Scene& scene, const layouts::InitialState& state,
                                 const Horizon& horizon, const Room& room,
                                 const std::vector<Trajectory>& trajectories)
    : state_(state),
      horizon_(horizon),
      room_(room),
      energy_(scene, state, horizon, room, trajectories),
      motions_(trajectories, state.acceleration, horizon),
      cluster_of_(trajectories.size(), kNoCluster),
      walls_(trajectories.size()) {}

void ContactClusters::MeetObject(std::size_t object, std::size_t other, double time) {
  events_.push({time, static_cast<std::uint32_t>(object), static_cast<std::uint32_t>(other), -1,
                motions_.version(object), motions_.version(other)});
}

void ContactClusters::MeetWall(std::size_t object, int wall, double time) {
  events_.push({time, static_cast<std::uint32_t>(object), static_cast<std::uint32_t>(object), wall,
                motions_.version(object), motions_.version(object)});
}

std::size_t ContactClusters::Largest() const {
  std::size_t largest = 1;
  for (const ContactCluster& cluster : clusters_)
    largest = std::max(largest, cluster.members.size());
  return largest;
}

std::optional<std::string> ContactClusters::Follow(std::uint64_t& tests_left) {
  tests_left_ = &tests_left;
  SortPaths();
  while (!events_.empty()) {
    const Event event = events_.top();
    events_.pop();
    if (event.object_version != motions_.version(event.object) ||
        event.other_version != motions_.version(event.other))
      continue;
    if (auto why = Process(event)) return why;
  }
  return std::nullopt;
}

/// Returns the reason if the analysis has to give up.
std::optional<std::string> ContactClusters::Process(const Event& event) {
  for (const std::uint32_t i : {event.object, event.other})
    if (std::isfinite(state_.objects[i].numbers["contact_stiffness"]))
      return fmt::format("object {} has a soft contact, and may touch something", i + 1);
  if (event.wall >= 0) walls_[event.object] |= static_cast<std::uint8_t>(1 << event.wall);
  const bool is_alone = event.wall >= 0 || motions_.IsFixed(event.other);
  const bool is_known =
      is_alone && !motions_.IsInFlight(event.object) && ClusterOf(event.object).leans;
  if (is_known) return std::nullopt;
  const std::uint32_t cluster = Join(event.object);
  if (is_alone) {
    clusters_[cluster].leans = true;
  } else {
    Merge(cluster, Join(event.other));
  }
  if (!Redirect(clusters_[cluster], event.time))
    return fmt::format("object {} may get too far for the forecast", event.object + 1);
  if (has_given_up_) return "too many objects may meet to predict their contacts";
  return std::nullopt;
}

/// The cluster of the object; a new one if it has none.
std::uint32_t ContactClusters::Join(std::size_t object) {
  if (cluster_of_[object] != kNoCluster) return cluster_of_[object];
  cluster_of_[object] = static_cast<std::uint32_t>(clusters_.size());
  touched_.push_back(static_cast<std::uint32_t>(object));
  clusters_.push_back(energy_.Alone(object));
  return cluster_of_[object];
}

void ContactClusters::Merge(std::uint32_t to, std::uint32_t from) {
  if (to == from) return;
  for (const std::uint32_t i : clusters_[from].members) cluster_of_[i] = to;
  clusters_[to].Absorb(clusters_[from]);
}

/// Gives all members new regions from `time` on; false if one cannot be followed.
bool ContactClusters::Redirect(ContactCluster& cluster, double time) {
  energy_.Update(cluster);
  for (const std::uint32_t i : cluster.members) {
    const Region region = energy_.RegionOf(cluster, i, motions_.BallAt(i, time), time);
    if (!std::isfinite(region.Hull(horizon_.end).diagonal().squaredNorm())) return false;
    motions_.SetRegion(i, region);
  }
  for (const std::uint32_t i : cluster.members) {
    ForeseeWalls(i);
    ForeseeMeetings(i);
  }
  return true;
}

void ContactClusters::SortPaths() {
  std::vector<SweptBox> boxes;
  boxes.reserve(walls_.size());
  for (std::size_t i = 0; i < walls_.size(); ++i) {
    const Trajectory& trajectory = motions_.trajectory(i);
    const double grown =
        trajectory.radius + trajectory.threshold / 2 + trajectory.slack.stableNorm();
    boxes.push_back(
        {Grown(trajectory.PathUntil(horizon_.end), grown), static_cast<std::uint32_t>(i)});
  }
  paths_ = SortedBoxes(std::move(boxes));
}

void ContactClusters::ForeseeWalls(std::size_t object) {
  const Trajectory& trajectory = motions_.trajectory(object);
  const Region& region = motions_.region(object);
  const double reach = trajectory.radius + trajectory.threshold + region.error;
  for (int wall = 0; wall < kWallCount; ++wall) {
    if (!room_.Stands(wall) || (walls_[object] >> wall & 1) != 0) continue;
    if (room_.Gap(wall, region.Hull(horizon_.end), reach) > 0) continue;
    const auto time = FirstContact(region.since, motions_.FastestInWorld(object),
                                   kNearly * trajectory.radius, [&](double t) {
                                     const Ball ball = motions_.BallAt(object, t);
                                     return room_.Gap(wall, ball.core, ball.radius + reach);
                                   });
    if (time) MeetWall(object, wall, *time);
  }
}

void ContactClusters::ForeseeMeetings(std::size_t object) {
  const Trajectory& trajectory = motions_.trajectory(object);
  const Box hull = Grown(motions_.region(object).Hull(horizon_.end),
                         trajectory.radius + trajectory.threshold / 2);
  for (const SweptBox& path : paths_.Near(hull)) {
    if (!Spend(1)) return;
    if (motions_.IsInFlight(path.object) && path.box.intersects(hull))
      ForeseeMeeting(object, path.object);
  }
  for (const std::uint32_t other : touched_) {
    if (!Spend(1)) return;
    if (cluster_of_[other] != cluster_of_[object] && !motions_.IsInFlight(other))
      ForeseeMeeting(object, other);
  }
}

void ContactClusters::ForeseeMeeting(std::size_t object, std::size_t other) {
  // Another contact with a fixed object adds nothing to a cluster that leans on one.
  if (motions_.IsFixed(other) && ClusterOf(object).leans) return;
  const double touching =
      TouchingDistance(motions_.trajectory(object), motions_.trajectory(other)) +
      motions_.ErrorOf(object) + motions_.ErrorOf(other);
  const double fastest = std::min(motions_.FastestInWorld(object) + motions_.FastestInWorld(other),
                                  motions_.FastestInAir(object) + motions_.FastestInAir(other));
  const auto time =
      FirstContact(motions_.region(object).since, fastest, kNearly * touching, [&](double t) {
        const Ball a = motions_.BallAt(object, t), b = motions_.BallAt(other, t);
        return Distance(a.core, b.core) - a.radius - b.radius - touching;
      });
  if (time) MeetObject(object, other, *time);
}

/// A time from `begin` on, not later than the first at which `gap` is 0 or less, if there is one.
/// `gap` must never shrink faster than `fastest`.
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

bool ContactClusters::Spend(std::uint64_t tests) {
  has_given_up_ = has_given_up_ || *tests_left_ < tests;
  *tests_left_ -= std::min(*tests_left_, tests);
  return !has_given_up_;
}

namespace {

using Eigen::Vector3d;
using layouts::ObjectState;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Bullet pushes penetrating bodies out again by `solver.erp` of the depth per step, regardless of
/// energy. A body that penetrates within a step has moved that far in it, so this is as if speeds
/// were larger by erp. The rest allows for the error that the solver leaves after its iterations.
constexpr double kSpeedFactor = 1.3;
/// m: Bullet corrects shallower penetrations by a velocity, which persists
/// (m_splitImpulsePenetrationThreshold), unless `contact faithful` forbids it.
constexpr double kShallow = 0.04;

double LargestPlace(const Box& box) {
  return box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
}

}  // namespace

void ContactCluster::Absorb(ContactCluster& other) {
  members.insert(members.end(), other.members.begin(), other.members.end());
  leans = leans || other.leans;
  is_slowed = is_slowed || other.is_slowed;
  mass += other.mass;
  momentum += other.momentum;
  energy += other.energy;
  energy_of_drop += other.energy_of_drop;
  restitution = std::max(restitution, other.restitution);
  other = {};
}

ClusterEnergy::ClusterEnergy(const plan::Scene& scene, const layouts::InitialState& state,
                             const Horizon& horizon, const Room& room,
                             const std::vector<Trajectory>& trajectories)
    : state_(state),
      horizon_(horizon),
      room_(room),
      trajectories_(trajectories),
      sleeps_(scene.world.On("sleeping")),
      is_faithful_(scene.world.WordOr("contact") == "faithful"),
      erp_(scene.world.Real("solver.erp")) {}

ContactCluster ClusterEnergy::Alone(std::size_t object) const {
  const ObjectState& it = state_.objects[object];
  ContactCluster cluster;
  cluster.members = {static_cast<std::uint32_t>(object)};
  cluster.is_slowed = trajectories_[object].motion == Motion::kSlowed;
  cluster.mass = it.mass;
  cluster.momentum = it.mass * it.linear_velocity;
  cluster.energy = KineticEnergy(object, Vector3d::Zero());
  cluster.energy_of_drop = WeightedDrop(object);
  cluster.restitution = it.numbers["restitution"];
  return cluster;
}

void ClusterEnergy::Update(ContactCluster& cluster) const {
  const Vector3d velocity = cluster.momentum / cluster.mass;
  cluster.energy_in_air = 0;
  for (const std::uint32_t i : cluster.members) cluster.energy_in_air += KineticEnergy(i, velocity);
  // A cluster that has once lost momentum to the world does not regain it by meeting others.
  cluster.is_slowed = !FallsFreely(cluster);
}

double ClusterEnergy::KineticEnergy(std::size_t object, const Vector3d& frame) const {
  const ObjectState& it = state_.objects[object];
  const Vector3d spin = it.pose.orientation.conjugate() * it.angular_velocity;
  return it.mass *
         ((it.linear_velocity - frame).squaredNorm() +
          spin.cwiseAbs2().dot(it.solid.InertiaPerMass())) /
         2;
}

/// J: the work that gravity can do on the object before walls stop it. A step of Bullet's loses g^2
/// dt^2 / 2 of a falling object's energy per mass; this is as much as being pushed out of a wall
/// gives back after a penetration by the displacement of one step.
double ClusterEnergy::WeightedDrop(std::size_t object) const {
  const ObjectState& it = state_.objects[object];
  double work = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double g = state_.acceleration[axis];
    if (g == 0) continue;
    if (!room_.Holds(2 * axis + (g > 0 ? 1 : 0))) return kInfinity;
    const double sunk = trajectories_[object].FastestUntil(horizon_.end) * horizon_.timestep;
    // A faster object could pass through a box in one step.
    if (sunk > kWallThickness * room_.half()) return kInfinity;
    const double lowest = room_.half() - it.solid.InnerRadius() + sunk;
    work += std::abs(g) * std::max(0.0, lowest - std::copysign(1.0, g) * it.pose.position[axis]);
  }
  return it.mass * work;
}

/// m/s: the speed that a bounce may add if Bullet corrects shallow penetrations by velocity and the
/// bounce itself keeps so much that together they exceed the incoming speed.
double ClusterEnergy::Boost(const ContactCluster& cluster, std::size_t object) const {
  if (is_faithful_ || cluster.restitution + erp_ <= 1) return 0;
  return (1 + erp_) * kShallow / horizon_.timestep *
         std::sqrt(cluster.mass / state_.objects[object].mass);
}

/// m/s relative to the cluster's centre of mass, as long as gravity is the only external force.
double ClusterEnergy::SpeedInAir(const ContactCluster& cluster, std::size_t object) const {
  return (kSpeedFactor + erp_) *
             std::sqrt(2 * cluster.energy_in_air / state_.objects[object].mass) +
         Boost(cluster, object);
}

/// True if the cluster's energy in the falling frame never grows. Sleep stops an object in the
/// world, which could make it faster in that frame; but to be slow in the world for as long as
/// sleep takes, it must first have changed its velocity in the frame by nearly all of g times that
/// duration.
bool ClusterEnergy::FallsFreely(const ContactCluster& cluster) const {
  if (cluster.leans || cluster.is_slowed) return false;
  if (!sleeps_) return true;
  const double change =
      state_.acceleration.stableNorm() * (kSleepAfter - horizon_.timestep) - 2.02 * kSlowSpeed;
  return std::ranges::all_of(cluster.members,
                             [&](std::uint32_t i) { return 2 * SpeedInAir(cluster, i) < change; });
}

Region ClusterEnergy::RegionOf(const ContactCluster& cluster, std::size_t object, const Ball& ball,
                               double time) const {
  const Vector3d& g = state_.acceleration;
  Region region;
  region.since = time;
  region.core = ball.core;
  region.radius = ball.radius;
  region.drift = region.gravity = Vector3d::Zero();
  region.timestep = horizon_.timestep;
  const double fall = g.stableNorm() * (horizon_.end + horizon_.timestep);
  double fastest = 0;
  if (!cluster.is_slowed) {
    region.drift = cluster.momentum / cluster.mass;
    region.gravity = g;
    region.rate = region.limit = SpeedInAir(cluster, object);
    fastest = region.rate + region.drift.stableNorm() + fall;
  } else {
    // sqrt(2 E) is the norm of the velocities weighted by the square roots of the masses. Gravity
    // adds
    // g| sqrt(M) dt to it per step; if walls hold the cluster, its energy is also bounded.
    const double factor = (kSpeedFactor + erp_) / std::sqrt(state_.objects[object].mass);
    const double boost = Boost(cluster, object);
    const double per_second = g.stableNorm() * std::sqrt(cluster.mass);
    const double per_step = per_second * horizon_.timestep;
    region.rate = factor * (std::sqrt(2 * cluster.energy) + per_step) + boost;
    region.more = factor * per_second;
    fastest = region.rate + region.more * horizon_.end;
    const double held = std::sqrt(2 * (cluster.energy + cluster.energy_of_drop));
    fastest = region.limit = std::min(fastest, factor * (held + per_step) + boost);
  }
  region.error =
      std::sqrt(3.0) * horizon_.PlaceError(LargestPlace(region.Hull(horizon_.end)), fastest);
  return region;
}

}  // namespace cdb::omissions
