#include "runtime/engine/soft/soft_probes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "compiler/analysis/reference.h"
#include "compiler/schema/value.h"
#include "library/exact/collision.h"
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

void AddStrains(const SoftObject& one, double half_timestep, probes::SpringEnergies& energy) {
  for (std::size_t i = 0; i < one.elements.size(); ++i) {
    const auto& corners = one.mesh.tetrahedra[i];
    const Element& element = one.elements[i];
    const auto gradient = [&](const auto& value_of) -> Eigen::Matrix3d {
      return analysis::EdgesOf(corners,
                               [&](std::uint32_t node) { return value_of(*one.body, node); }) *
             element.inverse;
    };
    const Strained strained = StrainedBy(one.material, gradient(PlaceOf));
    const double plain = element.volume * strained.energy;
    energy.plain += plain;
    energy.with_term += plain - half_timestep * element.volume *
                                    strained.stress.cwiseProduct(gradient(VelocityOf)).sum();
  }
}

/// N/m: an upper bound of twice the strain energy over the square of the largest displacement of a
/// node.
double StiffnessOf(const SoftObject& one) {
  double sum = static_cast<double>(one.mesh.links.size()) * one.stiffness;
  const double modulus = one.material.lame.lambda + 2 * one.material.lame.mu;
  for (const Element& element : one.elements)
    sum += modulus * element.volume * element.inverse.squaredNorm();
  return sum;
}

/// J: of nodes and springs, with the places of all rounded a few times.
double RoundingEnergyOf(const SoftObject& one, double timestep) {
  constexpr double kTimes = 64;
  double farthest = 0;
  for (std::size_t node = 0; node < one.masses.size(); ++node)
    farthest = std::max(farthest, PlaceOf(*one.body, node).cwiseAbs().maxCoeff());
  const double off =
      kTimes * farthest * static_cast<double>(std::numeric_limits<btScalar>::epsilon());
  return (MassOf(one) / (timestep * timestep) + StiffnessOf(one)) * off * off / 2;
}

bool IsFinite(const btRigidBody& body) {
  return world::IsFinite(body.getWorldTransform().getOrigin()) &&
         world::IsFinite(body.getLinearVelocity()) && world::IsFinite(body.getAngularVelocity());
}

/// Without pins, fixed and kinematic bodies, walls and damping.
bool IsClosed(const plan::Scene& scene, const SoftWorld& world) {
  return world.walls().empty() &&
         std::ranges::all_of(world.rigid(), [](const auto& body) { return IsFree(*body); }) &&
         std::ranges::all_of(world.bodies(),
                             [](const SoftObject& one) {
                               return std::ranges::find(one.masses, 0) == one.masses.end();
                             }) &&
         std::ranges::all_of(scene.groups, [](const plan::Group& group) {
           const schema::Number* damping = schema::AsNumber(group.settings.Get("linear_damping"));
           return damping != nullptr && damping->AsReal() == 0;
         });
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
    if (!one.elements.empty()) AddStrains(one, half_timestep, energy.springs);
  }
  for (const auto& body : world.rigid()) {
    if (!IsFree(*body)) continue;
    const layouts::ObjectState& object = world.ObjectOf(*body);
    const Vector3d v = world::ToEigen(body->getLinearVelocity());
    const double weight = -object.mass * g.dot(world::ExactPose(*body).position);
    energy.kinetic += object.mass / 2 * v.squaredNorm() +
                      SpinOf(*body, object).dot(world::ToEigen(body->getAngularVelocity())) / 2;
    energy.weight += weight;
    energy.weight_with_term += weight + object.mass * half_timestep * g.dot(v);
  }
  return energy;
}

Vector3d SpinOf(const btRigidBody& body, const layouts::ObjectState& object) {
  const Eigen::Quaterniond turn = world::ExactPose(body).orientation;
  const Vector3d own = turn.conjugate() * world::ToEigen(body.getAngularVelocity());
  return turn * (object.mass * object.solid.InertiaPerMass()).cwiseProduct(own);
}

SoftMomentum MomentumOf(const SoftWorld& world) {
  SoftMomentum momentum;
  const auto add = [&](double mass, const Vector3d& velocity) {
    momentum.mass += mass;
    momentum.sum += mass * velocity;
    momentum.parts += mass * velocity.norm();
  };
  for (const SoftObject& one : world.bodies())
    for (std::size_t node = 0; node < one.masses.size(); ++node)
      add(one.masses[node], VelocityOf(*one.body, node));
  for (const auto& body : world.rigid())
    if (IsFree(*body)) add(world.ObjectOf(*body).mass, world::ToEigen(body->getLinearVelocity()));
  return momentum;
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

SoftVolume VolumeOf(const SoftWorld& world) {
  SoftVolume sum;
  double start = 0, now = 0;
  for (const SoftObject& one : world.bodies()) {
    for (std::size_t i = 0; i < one.elements.size(); ++i) {
      const double volume =
          analysis::EdgesOf(one.mesh.tetrahedra[i],
                            [&](std::uint32_t node) { return PlaceOf(*one.body, node); })
              .determinant() /
          6;
      start += one.elements[i].volume;
      now += volume;
      sum.inverted += !(volume > 0);
    }
  }
  if (start > 0) sum.ratio = now / start;
  return sum;
}

SoftProbes::Obstacle::Obstacle(objects::Solid of, const btRigidBody& its_body)
    : solid(std::move(of)), body(&its_body) {
  ReadPose();
}

void SoftProbes::Obstacle::ReadPose() {
  pose = world::ExactPose(*body);
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d along = pose.orientation.conjugate() * Vector3d::Unit(axis);
    upper[axis] = pose.position[axis] + along.dot(solid.Support(along));
    lower[axis] = pose.position[axis] + along.dot(solid.Support(-along));
  }
}

SoftProbes::SoftProbes(const plan::Scene& scene, SoftWorld& world, protocol::Recording& recording)
    : world_(world),
      recording_(recording),
      cycles_(scene.world.Count("cycles")),
      all_walls_(scene.world.WordOr("world.walls") == "all"),
      floor_(scene.world.WordOr("world.walls") == "floor"),
      is_closed_(IsClosed(scene, world)),
      nodes_(world.bodies().size()),
      is_finite_(world.bodies().size(), 1),
      fell_off_(world.bodies().size() + world.rigid().size(), 0) {
  for (const auto& body : world.rigid())
    obstacles_.emplace_back(world.ObjectOf(*body).solid, *body);
  for (const auto& wall : world.walls()) obstacles_.emplace_back(world::BoxWallSolid(*wall), *wall);
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
    const double side = world_.initial_state().objects[one.object].solid.sides.minCoeff();
    scales.least_side = std::min(scales.least_side, side);
    scales.energy_scale += MassOf(one) * (kFall * pull * side + std::pow(0.01 * side, 2) / 2);
    scales.energy_scale += RoundingEnergyOf(one, world_.timestep());
  }
  scales.moving_objects = static_cast<double>(world_.bodies().size());
  for (const auto& body : world_.rigid()) {
    if (!IsFree(*body)) continue;
    const layouts::ObjectState& object = world_.ObjectOf(*body);
    const double side = object.solid.sides.minCoeff();
    scales.least_side = std::min(scales.least_side, side);
    scales.energy_scale += object.mass * (kFall * pull * side + std::pow(0.01 * side, 2) / 2);
    ++scales.moving_objects;
  }
  scales.speed_scale = std::sqrt(pull * scales.least_side);
  // After a warm-up, they are elsewhere.
  ReadNodes();
  for (Obstacle& one : obstacles_)
    if (IsFinite(*one.body)) one.ReadPose();
  first_ = MomentumOf(world_);
  largest_momentum_ = first_.parts;
}

void SoftProbes::Record(std::uint64_t cycle) {
  world::RecordPhases(world_.clock().Phases(), cycle, recording_);
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
  if (!recording_.Reals("poses").empty()) RecordPoses(cycle);
}

void SoftProbes::ReadNodes() {
  if (recording_.Reals("stretch").empty() && recording_.Reals("poses").empty()) return;
  std::swap(nodes_, last_nodes_);
  nodes_.resize(last_nodes_.size());
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
  sweeps_.assign(nodes_.size(), Eigen::AlignedBox3d());
  if (!world_.rigid().empty())
    for (std::size_t body = 0; body < nodes_.size(); ++body)
      for (const auto* nodes : {&last_nodes_[body], &nodes_[body]})
        for (const Vector3d& node : *nodes) sweeps_[body].extend(node);
  auto [fastest, escaped, removed, non_finite, passed] = RecordRigid();
  double deepest = 0;
  std::int32_t inside = 0, crossings = 0;
  bool has_faces = false;
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
    escaped += IsBeyondWall(CentreOf(one, nodes_[body]), fell_off_[body]);
    const Depths depths = DepthsOf(body);
    deepest = std::max(deepest, depths.deepest);
    inside += depths.inside;
    has_faces = has_faces || !one.mesh.triangles.empty();
    crossings += static_cast<std::int32_t>(CountCrossings(one.mesh, nodes_[body]));
  }
  const double stretch = StretchOf(world_);
  recording_.Put("max_speed", cycle, fastest);
  recording_.Put("max_penetration", cycle, deepest);
  recording_.Put("escaped", cycle, escaped);
  recording_.Put("removed", cycle, removed);
  recording_.Put("non_finite", cycle, non_finite);
  recording_.Put("inside", cycle, inside);
  recording_.Put("passed", cycle, passed);
  recording_.Put("momentum_error", cycle, is_closed_ ? MomentumError(cycle) : kNone);
  recording_.Put("stretch", cycle, std::isfinite(stretch) ? stretch : kNone);
  if (has_faces) recording_.Put("self_crossings", cycle, crossings);
  const SoftVolume volume = VolumeOf(world_);
  recording_.Put("volume_ratio", cycle, volume.ratio.value_or(kNone));
  if (volume.ratio) recording_.Put("inverted_tetrahedra", cycle, volume.inverted);
}

SoftProbes::RigidCounts SoftProbes::RecordRigid() {
  RigidCounts counts;
  for (std::size_t i = 0; i < world_.rigid().size(); ++i) {
    Obstacle& one = obstacles_[i];
    const btRigidBody& body = *one.body;
    const Vector3d last = one.pose.position;
    if (!IsFinite(body)) {
      ++counts.non_finite;
      continue;
    }
    one.ReadPose();
    one.has_passed = one.has_passed || HasPassed(one, last);
    counts.passed += one.has_passed;
    if (!IsFree(body)) continue;
    counts.fastest = std::max(counts.fastest, world::ToEigen(body.getLinearVelocity()).norm());
    counts.removed += body.getActivationState() == DISABLE_SIMULATION ||
                      !((one.upper - one.lower).norm() < analysis::kLargestBox);
    counts.escaped += IsBeyondWall(one.pose.position, fell_off_[nodes_.size() + i]);
  }
  return counts;
}

/// `last`: the centre of mass before the cycle.
bool SoftProbes::HasPassed(const Obstacle& one, const Vector3d& last) const {
  const auto box = Eigen::AlignedBox3d(last).extend(one.pose.position);
  for (std::size_t body = 0; body < nodes_.size(); ++body) {
    if (!is_finite_[body]) continue;
    if (!sweeps_[body].intersects(box)) continue;
    const std::vector<Vector3d>&from = last_nodes_[body], &to = nodes_[body];
    for (const auto& [a, b, c] : world_.bodies()[body].mesh.triangles) {
      const auto face = Eigen::AlignedBox3d(from[a])
                            .extend(from[b])
                            .extend(from[c])
                            .extend(to[a])
                            .extend(to[b])
                            .extend(to[c]);
      if (!face.intersects(box)) continue;
      if (exact::VertexMeetsFace(
              {{last, from[a], from[b], from[c]}, {one.pose.position, to[a], to[b], to[c]}}))
        return true;
    }
  }
  return false;
}

double SoftProbes::MomentumError(std::uint64_t cycle) {
  const SoftMomentum now = MomentumOf(world_);
  largest_momentum_ = std::max(largest_momentum_, now.parts);
  const double time = static_cast<double>(cycle + 1) * world_.timestep();
  const double off = (now.sum - first_.sum - first_.mass * time * world_.acceleration()).norm();
  return largest_momentum_ > 0 ? off / largest_momentum_ : kNone;
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

bool SoftProbes::IsBeyondWall(const Vector3d& centre, char& fell_off) const {
  const double half = world_.side() / 2;
  if (all_walls_) return centre.cwiseAbs().maxCoeff() > half;
  if (!floor_ || !(centre.y() < -half)) {
    fell_off = 0;
    return false;
  }
  // The floor is a box with edges, over which a body may fall.
  const double edge = half + omissions::kWallThickness * world_.side();
  if (std::max(std::fabs(centre.x()), std::fabs(centre.z())) > edge) fell_off = 1;
  return fell_off == 0;
}

void SoftProbes::RecordVertices(std::uint64_t cycle) {
  const auto all = recording_.Reals("vertex_positions");
  auto at = all.begin() + static_cast<std::ptrdiff_t>(all.size() / cycles_ * cycle);
  for (const std::vector<Vector3d>& nodes : nodes_)
    for (const Vector3d& node : nodes)
      for (const double x : node) *at++ = x;
}

/// Rigid objects are convex: their own axes are those of their sides.
void SoftProbes::RecordPoses(std::uint64_t cycle) {
  const auto all = recording_.Reals("poses");
  const auto begin = all.begin() + static_cast<std::ptrdiff_t>(all.size() / cycles_ * cycle);
  const auto put = [&](std::size_t object, const Vector3d& place, const Eigen::Quaterniond& turn) {
    auto at = begin + static_cast<std::ptrdiff_t>(object * protocol::kPoseSize);
    for (const double x : place) *at++ = x;
    for (const double part : turn.coeffs()) *at++ = part;
  };
  for (std::size_t body = 0; body < nodes_.size(); ++body) {
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& node : nodes_[body])
      middle += node / static_cast<double>(nodes_[body].size());
    put(world_.bodies()[body].object, middle, Eigen::Quaterniond::Identity());
  }
  for (const auto& body : world_.rigid()) {
    const objects::Pose pose = world::ExactPose(*body);
    put(static_cast<std::size_t>(body->getUserIndex()), pose.position, pose.orientation);
  }
}

}  // namespace cdb::soft
