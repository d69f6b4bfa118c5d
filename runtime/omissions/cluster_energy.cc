#include "runtime/omissions/cluster_energy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/omissions/omissions.h"

namespace cdb::omissions {
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
