#include "runtime/engine/soft/soft_probes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compiler/analysis/reference.h"
#include "library/exact/signed_distance.h"
#include "runtime/engine/probes/processor_time.h"
#include "runtime/engine/soft/crossings.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/omissions/omissions.h"

namespace cdb::soft {
namespace {

using Eigen::Vector3d;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
/// In thicknesses of a body: the fall whose energy is the scale of a run at rest.
constexpr double kFall = 25;

double MarginOf(const btSoftBody& body) {
  return static_cast<double>(body.getCollisionShape()->getMargin());
}

Vector3d PlaceOf(const btSoftBody& body, std::size_t node) {
  return world::ToEigen(body.m_nodes[static_cast<int>(node)].m_x);
}

Vector3d VelocityOf(const btSoftBody& body, std::size_t node) {
  return world::ToEigen(body.m_nodes[static_cast<int>(node)].m_v);
}

double MassOf(const SoftObject& one) {
  double mass = 0;
  for (const double of_node : one.masses) mass += of_node;
  return mass;
}

Vector3d CentreOf(const SoftObject& one, const std::vector<Vector3d>& nodes) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < nodes.size(); ++i) sum += one.masses[i] * nodes[i];
  return sum / MassOf(one);
}

void AddSprings(const SoftObject& one, double half_timestep, probes::SpringEnergies& energy) {
  for (std::size_t i = 0; i < one.mesh.links.size(); ++i) {
    const auto& [a, b] = one.mesh.links[i];
    const Vector3d along = PlaceOf(*one.body, b) - PlaceOf(*one.body, a);
    const double length = along.norm(), extension = length - one.rest[i];
    const double plain = one.stiffness / 2 * extension * extension;
    energy.plain += plain;
    energy.with_term += plain;
    if (!(length > 0)) continue;
    // A pinned node has no velocity.
    energy.with_term += half_timestep * one.stiffness * extension / length *
                        along.dot(VelocityOf(*one.body, a) - VelocityOf(*one.body, b));
  }
}

/// J: of nodes and springs, with the places of all rounded a few times.
double RoundingEnergyOf(const SoftObject& one, double timestep) {
  constexpr double kTimes = 64;
  double farthest = 0;
  for (std::size_t node = 0; node < one.masses.size(); ++node)
    farthest = std::max(farthest, PlaceOf(*one.body, node).cwiseAbs().maxCoeff());
  const double off =
      kTimes * farthest * static_cast<double>(std::numeric_limits<btScalar>::epsilon());
  return (MassOf(one) / (timestep * timestep) +
          static_cast<double>(one.mesh.links.size()) * one.stiffness) *
         off * off / 2;
}

}  // namespace

SoftEnergy EnergyOf(const SoftWorld& world) {
  const Vector3d& g = world.acceleration();
  const double half_timestep = world.timestep() / 2;
  SoftEnergy energy;
  for (const SoftObject& one : world.bodies()) {
    for (std::size_t node = 0; node < one.masses.size(); ++node) {
      const Vector3d v = VelocityOf(*one.body, node);
      const double weight = -one.masses[node] * g.dot(PlaceOf(*one.body, node));
      energy.kinetic += one.masses[node] / 2 * v.squaredNorm();
      energy.weight += weight;
      energy.weight_with_term += weight + one.masses[node] * half_timestep * g.dot(v);
    }
    if (one.stiffness > 0) AddSprings(one, half_timestep, energy.springs);
  }
  return energy;
}

double StretchOf(const SoftWorld& world) {
  double largest = -1;
  for (const SoftObject& one : world.bodies())
    for (std::size_t i = 0; i < one.mesh.links.size(); ++i) {
      const auto& [a, b] = one.mesh.links[i];
      const double length = (PlaceOf(*one.body, a) - PlaceOf(*one.body, b)).norm();
      const double stretch = length / one.rest[i] - 1;
      if (!(stretch <= largest)) largest = stretch;  // also if it is not a number
    }
  return largest;
}

SoftProbes::SoftProbes(const plan::Scene& scene, SoftWorld& world, protocol::Recording& recording)
    : world_(world),
      recording_(recording),
      cycles_(scene.world.Count("cycles")),
      all_walls_(scene.world.WordOr("world.walls") == "all"),
      floor_(scene.world.WordOr("world.walls") == "floor"),
      nodes_(world.bodies().size()),
      is_finite_(world.bodies().size(), 1),
      fell_off_(world.bodies().size(), 0) {
  const auto add = [&](const objects::Solid& solid, const btRigidBody& body) {
    Obstacle one{solid, world::ExactPose(body), {}, {}};
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d along = one.pose.orientation.conjugate() * Vector3d::Unit(axis);
      one.upper[axis] = one.pose.position[axis] + along.dot(solid.Support(along));
      one.lower[axis] = one.pose.position[axis] + along.dot(solid.Support(-along));
    }
    obstacles_.push_back(one);
  };
  for (const auto& body : world.fixed())
    add(world.initial_state().objects[static_cast<std::size_t>(body->getUserIndex())].solid, *body);
  for (const auto& wall : world.walls()) add(world::BoxWallSolid(*wall), *wall);
}

void SoftProbes::Begin() {
  if (recording_.Reals("stretch").empty()) return;
  protocol::VerdictScales& scales = recording_.header().scales;
  const SoftEnergy energy = EnergyOf(world_);
  const double pull = world_.acceleration().norm();
  scales.initial_energy = energy.kinetic + energy.weight_with_term + energy.springs.with_term;
  scales.energy_scale = energy.kinetic;
  scales.least_side = std::numeric_limits<double>::infinity();
  for (const SoftObject& one : world_.bodies()) {
    const double side = 2 * MarginOf(*one.body);
    scales.least_side = std::min(scales.least_side, side);
    scales.energy_scale += MassOf(one) * (kFall * pull * side + std::pow(0.01 * side, 2) / 2);
    scales.energy_scale += RoundingEnergyOf(one, world_.timestep());
  }
  scales.moving_objects = static_cast<double>(world_.bodies().size());
  scales.speed_scale = std::sqrt(pull * scales.least_side);
}

void SoftProbes::Record(std::uint64_t cycle) {
  if (const auto all = recording_.Reals("duration"); !all.empty()) {
    const auto durations = world_.clock().Durations();
    for (std::size_t phase = 0; phase < durations.size(); ++phase)
      all[phase * cycles_ + cycle] = durations[phase];
  }
  // First, because the following may use the heap.
  if (!recording_.Reals("heap").empty()) recording_.Put("heap", cycle, probes::HeapBytes());
  recording_.Put("pairs", cycle, world_.world().getPairCache()->getNumOverlappingPairs());
  recording_.Put("contacts", cycle, static_cast<std::int32_t>(world_.ContactCount()));
  if (!recording_.Reals("energy").empty()) {
    const SoftEnergy energy = EnergyOf(world_);
    recording_.Put("kinetic_energy", cycle, energy.kinetic);
    recording_.Put("energy", cycle,
                   probes::RecordedEnergy(energy.kinetic, energy.weight_with_term, energy.springs,
                                          recording_.header().scales));
  }
  ReadNodes();
  if (!recording_.Reals("stretch").empty()) RecordStability(cycle);
  if (!recording_.Reals("vertex_positions").empty()) RecordVertices(cycle);
}

void SoftProbes::ReadNodes() {
  if (recording_.Reals("stretch").empty() && recording_.Reals("vertex_positions").empty()) return;
  for (std::size_t body = 0; body < nodes_.size(); ++body) {
    const SoftObject& one = world_.bodies()[body];
    nodes_[body].resize(one.masses.size());
    is_finite_[body] = 1;
    for (std::size_t node = 0; node < one.masses.size(); ++node) {
      nodes_[body][node] = PlaceOf(*one.body, node);
      if (!nodes_[body][node].allFinite() || !VelocityOf(*one.body, node).allFinite())
        is_finite_[body] = 0;
    }
  }
}

void SoftProbes::RecordStability(std::uint64_t cycle) {
  double fastest = 0, deepest = 0;
  std::int32_t escaped = 0, removed = 0, non_finite = 0, inside = 0, crossings = 0;
  bool has_cloth = false;
  for (std::size_t body = 0; body < nodes_.size(); ++body) {
    const SoftObject& one = world_.bodies()[body];
    if (!is_finite_[body]) {
      ++non_finite;
      continue;
    }
    for (std::size_t node = 0; node < one.masses.size(); ++node)
      fastest = std::max(fastest, VelocityOf(*one.body, node).norm());
    btVector3 lower, upper;
    one.body->getAabb(lower, upper);
    removed += one.body->getActivationState() == DISABLE_SIMULATION ||
               !((upper - lower).length() < btScalar(analysis::kLargestBox));
    escaped += IsBeyondWall(body, CentreOf(one, nodes_[body]));
    const Depths depths = DepthsOf(body);
    deepest = std::max(deepest, depths.deepest);
    inside += depths.inside;
    has_cloth = has_cloth || !one.mesh.triangles.empty();
    crossings += static_cast<std::int32_t>(CountCrossings(one.mesh, nodes_[body]));
  }
  const double stretch = StretchOf(world_);
  recording_.Put("max_speed", cycle, fastest);
  recording_.Put("max_penetration", cycle, deepest);
  recording_.Put("escaped", cycle, escaped);
  recording_.Put("removed", cycle, removed);
  recording_.Put("non_finite", cycle, non_finite);
  recording_.Put("inside", cycle, inside);
  recording_.Put("stretch", cycle, std::isfinite(stretch) ? stretch : kNone);
  if (has_cloth) recording_.Put("self_crossings", cycle, crossings);
}

SoftProbes::Depths SoftProbes::DepthsOf(std::size_t body) const {
  const double margin = MarginOf(*world_.bodies()[body].body);
  const objects::Solid ball{objects::Shape::kEllipsoid, Vector3d::Constant(2 * margin)};
  Depths depths;
  for (const Vector3d& node : nodes_[body]) {
    bool is_inside = false;
    for (const Obstacle& one : obstacles_) {
      if (((node.array() + margin) < one.lower.array()).any() ||
          ((node.array() - margin) > one.upper.array()).any())
        continue;
      const double depth =
          exact::DistanceOf(ball, {node, Eigen::Quaterniond::Identity()}, one.solid, one.pose)
              .Depth();
      depths.deepest = std::max(depths.deepest, depth);
      is_inside = is_inside || depth > 2 * margin;
    }
    depths.inside += is_inside;
  }
  return depths;
}

bool SoftProbes::IsBeyondWall(std::size_t body, const Vector3d& centre) {
  const double half = world_.side() / 2;
  if (all_walls_) return centre.cwiseAbs().maxCoeff() > half;
  if (!floor_ || !(centre.y() < -half)) {
    fell_off_[body] = 0;
    return false;
  }
  // The floor is a box with edges, over which a body may fall.
  const double edge = half + omissions::kWallThickness * world_.side();
  if (std::max(std::fabs(centre.x()), std::fabs(centre.z())) > edge) fell_off_[body] = 1;
  return fell_off_[body] == 0;
}

void SoftProbes::RecordVertices(std::uint64_t cycle) {
  const auto all = recording_.Reals("vertex_positions");
  auto at = all.begin() + static_cast<std::ptrdiff_t>(all.size() / cycles_ * cycle);
  for (const std::vector<Vector3d>& nodes : nodes_)
    for (const Vector3d& node : nodes)
      for (const double x : node) *at++ = x;
}

}  // namespace cdb::soft
