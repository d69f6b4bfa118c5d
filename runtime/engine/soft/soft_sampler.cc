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

/// Calls `visit` with the mass, the place and the velocity of each node, in order.
template <typename Visit>
void ForEachNode(const SoftWorld& world, const Visit& visit) {
  for (const SoftObject& one : world.bodies())
    for (std::size_t i = 0; i < one.masses.size(); ++i) {
      const btSoftBody::Node& node = one.body->m_nodes[static_cast<int>(i)];
      visit(one, one.masses[i], world::ToEigen(node.m_x), world::ToEigen(node.m_v));
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
  ForEachNode(world, [&](const SoftObject& one, double mass, const Vector3d&, const Vector3d&) {
    values_[shape_.Body(index)] = mass;
    values_[shape_.Body(index++) + 1] =
        world.initial_state().objects[one.object].solid.sides.maxCoeff();
  });
}

void SoftSampler::AfterStep() {
  if (++steps_ % cycles_per_sample_ == 0 && taken_ < shape_.samples) Take();
}

void SoftSampler::Take() {
  std::size_t index = 0;
  ForEachNode(world_, [&](const SoftObject&, double, const Vector3d& x, const Vector3d& v) {
    Eigen::Map<Eigen::Matrix<double, protocol::kStateSize, 1>> state(
        &values_[shape_.State(taken_, index++)]);
    state << x, Eigen::Quaterniond::Identity().coeffs(), v, Vector3d::Zero();
  });
  TakeMotion();
  ++taken_;
}

void SoftSampler::TakeMotion() {
  const std::span<double> seen = values_.subspan(
      shape_.Observables(taken_), static_cast<std::size_t>(protocol::kObservableCount));
  std::ranges::fill(seen, std::numeric_limits<double>::quiet_NaN());
  Vector3d centre = Vector3d::Zero(), momentum = Vector3d::Zero(), angular = Vector3d::Zero();
  double whole = 0, momentum_sum = 0, angular_sum = 0;
  ForEachNode(world_, [&](const SoftObject&, double mass, const Vector3d& x, const Vector3d& v) {
    whole += mass;
    centre += mass * x;
    momentum += mass * v;
    momentum_sum += mass * v.norm();
  });
  if (whole > 0) centre /= whole;
  ForEachNode(world_, [&](const SoftObject&, double mass, const Vector3d& x, const Vector3d& v) {
    const Vector3d own = mass * (x - centre).cross(v);
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
  put(protocol::kMomentumX, momentum);
  put(protocol::kAngularX, angular);
  seen[protocol::kMomentumSum] = momentum_sum;
  seen[protocol::kAngularSum] = angular_sum;
}

}  // namespace cdb::soft
