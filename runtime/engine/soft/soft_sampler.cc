#include "runtime/engine/soft/soft_sampler.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "compiler/analysis/reference.h"
#include "runtime/engine/soft/soft_probes.h"
#include "runtime/engine/world/conversions.h"

namespace cdb::soft {

using Eigen::Vector3d;

namespace {

/// What a sample holds of a node, or of a rigid body that is free.
struct Part {
  double mass, size;
  Vector3d place;
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  Vector3d velocity, angular_velocity = Vector3d::Zero(), spin = Vector3d::Zero();
};

/// Calls `visit` with each node, in order, then with each free rigid body.
template <typename Visit>
void ForEachPart(const SoftWorld& world, const Visit& visit) {
  for (const SoftObject& one : world.bodies()) {
    const double size = world.initial_state().objects[one.object].solid.sides.maxCoeff();
    for (std::size_t i = 0; i < one.masses.size(); ++i) {
      const btSoftBody::Node& node = one.body->m_nodes[static_cast<int>(i)];
      visit(Part{.mass = one.masses[i],
                 .size = size,
                 .place = world::ToEigen(node.m_x),
                 .velocity = world::ToEigen(node.m_v)});
    }
  }
  for (const auto& body : world.rigid()) {
    if (!IsFree(*body)) continue;
    const layouts::ObjectState& object = world.ObjectOf(*body);
    const objects::Pose pose = world::ExactPose(*body);
    visit(Part{.mass = object.mass,
               .size = object.solid.sides.maxCoeff(),
               .place = pose.position,
               .turn = pose.orientation,
               .velocity = world::ToEigen(body->getLinearVelocity()),
               .angular_velocity = world::ToEigen(body->getAngularVelocity()),
               .spin = SpinOf(*body, object)});
  }
}

}  // namespace

SoftSampler::SoftSampler(const plan::Scene& scene, const SoftWorld& world,
                         protocol::Recording& recording)
    : world_(world),
      shape_(*protocol::SampleShapeOf(scene)),
      values_(recording.SampleValues()),
      cycles_per_sample_(analysis::SamplingOf(scene)->cycles) {
  std::size_t index = 0;
  ForEachPart(world, [&](const Part& part) {
    values_[shape_.Body(index)] = part.mass;
    values_[shape_.Body(index++) + 1] = part.size;
  });
}

void SoftSampler::AfterStep() {
  if (++steps_ % cycles_per_sample_ == 0 && taken_ < shape_.samples) Take();
}

void SoftSampler::Take() {
  std::size_t index = 0;
  ForEachPart(world_, [&](const Part& part) {
    Eigen::Map<Eigen::Matrix<double, protocol::kStateSize, 1>> state(
        &values_[shape_.State(taken_, index++)]);
    state << part.place, part.turn.coeffs(), part.velocity, part.angular_velocity;
  });
  TakeMotion();
  ++taken_;
}

void SoftSampler::TakeMotion() {
  const std::span<double> seen = values_.subspan(
      shape_.Observables(taken_), static_cast<std::size_t>(protocol::kObservableCount));
  std::ranges::fill(seen, std::numeric_limits<double>::quiet_NaN());
  Vector3d centre = Vector3d::Zero(), angular = Vector3d::Zero();
  double angular_sum = 0;
  const SoftMomentum momentum = MomentumOf(world_);
  ForEachPart(world_, [&](const Part& part) { centre += part.mass * part.place; });
  if (momentum.mass > 0) centre /= momentum.mass;
  ForEachPart(world_, [&](const Part& part) {
    const Vector3d own = part.mass * (part.place - centre).cross(part.velocity) + part.spin;
    angular += own;
    angular_sum += own.norm();
  });
  // Energies at one time: without the integrator's own term.
  const SoftEnergy energy = EnergyOf(world_);
  seen[protocol::kKinetic] = energy.kinetic;
  seen[protocol::kPotential] = energy.weight + energy.springs.plain;
  const auto put = [&](protocol::Observable first, const Vector3d& value) {
    std::ranges::copy(value, &seen[first]);
  };
  put(protocol::kAccelerationX, world_.acceleration());
  put(protocol::kMomentumX, momentum.sum);
  put(protocol::kAngularX, angular);
  seen[protocol::kMomentumSum] = momentum.parts;
  seen[protocol::kAngularSum] = angular_sum;
}

}  // namespace cdb::soft
