#include "runtime/engine/probes/sampler.h"

#include <algorithm>
#include <iterator>
#include <limits>

#include "compiler/analysis/reference.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::probes {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Eigen::Quaterniond TurnOf(const btRigidBody& body) {
  return world::ToEigen(body.getWorldTransform().getRotation());
}

}  // namespace

Sampler::Sampler(const plan::Scene& scene, world::Engine& engine, protocol::Recording& recording)
    : engine_(engine),
      shape_(*protocol::SampleShapeOf(scene)),
      values_(recording.SampleValues()),
      cycles_per_sample_(analysis::SamplingOf(scene)->cycles),
      wants_pairs_(scene.world.Lists("accuracy.metrics", "pairs")),
      wants_geometry_(scene.world.Lists("accuracy.metrics", "geometry")) {
  const auto& objects = engine.initial_state().objects;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    values_[shape_.Body(i)] = objects[i].mass;
    values_[shape_.Body(i) + 1] = objects[i].solid.sides.maxCoeff();
  }
}

void Sampler::Begin() { Take(); }

void Sampler::BeforeStep() {
  // The detector runs before the bodies are moved.
  if (!(wants_pairs_ || wants_geometry_) || IsComplete() || (steps_ + 1) % cycles_per_sample_ != 0)
    return;
  exact_ = ExactPairs(engine_);
  if (wants_geometry_) overlaps_ = ExactOverlaps(engine_, WithWalls(engine_, exact_));
}

void Sampler::AfterStep() {
  if (++steps_ % cycles_per_sample_ == 0 && !IsComplete()) Take();
}

double& Sampler::Value(protocol::Observable which) {
  return values_[shape_.Observables(taken_) + which];
}

void Sampler::Take() {
  TakeStates();
  TakeMotion();
  if (steps_ > 0) {
    TakeContacts();
    if (wants_pairs_) TakePairs();
    if (wants_geometry_) TakeGeometry();
  }
  ++taken_;
}

void Sampler::TakeStates() {
  for (std::size_t i = 0; i < shape_.objects; ++i) {
    const btRigidBody& body = *engine_.objects()[i];
    Eigen::Map<Eigen::Matrix<double, protocol::kStateSize, 1>> state(
        &values_[shape_.State(taken_, i)]);
    state << world::ToEigen(body.getWorldTransform().getOrigin()), TurnOf(body).coeffs(),
        world::ToEigen(body.getLinearVelocity()), world::ToEigen(body.getAngularVelocity());
  }
}

void Sampler::TakeMotion() {
  struct Motion {
    double mass;
    Vector3d place, momentum, spin;  ///< `spin`: angular momentum about its own centre
  };
  std::vector<Motion> motions;
  double kinetic = 0, potential = 0, mass = 0;
  Vector3d centre = Vector3d::Zero();
  for (std::size_t i = 0; i < shape_.objects; ++i) {
    const layouts::ObjectState& object = engine_.initial_state().objects[i];
    if (object.IsFixed()) continue;
    const btRigidBody& body = *engine_.objects()[i];
    const Vector3d x = world::ToEigen(body.getWorldTransform().getOrigin());
    const Vector3d v = world::ToEigen(body.getLinearVelocity());
    const Vector3d w = world::ToEigen(body.getAngularVelocity());
    // The axes of a body are its principal axes.
    const Matrix3d axes = TurnOf(body).toRotationMatrix();
    const Vector3d inertia = object.mass * object.solid.InertiaPerMass();
    const Vector3d spin = axes * inertia.cwiseProduct(axes.transpose() * w);
    kinetic += (object.mass * v.squaredNorm() + w.dot(spin)) / 2;
    potential -= object.mass * engine_.acceleration().dot(x);
    motions.push_back({object.mass, x, object.mass * v, spin});
    mass += object.mass;
    centre += object.mass * x;
  }
  if (mass > 0) centre /= mass;
  Vector3d momentum = Vector3d::Zero(), angular = Vector3d::Zero();
  double momentum_sum = 0, angular_sum = 0;
  for (const Motion& motion : motions) {
    // The velocity of the common centre does not change the sum over all objects.
    const Vector3d own = (motion.place - centre).cross(motion.momentum) + motion.spin;
    momentum += motion.momentum;
    angular += own;
    momentum_sum += motion.momentum.norm();
    angular_sum += own.norm();
  }
  Value(protocol::kKinetic) = kinetic;
  // Energies at one time: without the integrator's own term.
  Value(protocol::kPotential) = potential + engine_.links().SpringEnergy(0);
  Eigen::Map<Vector3d>(&Value(protocol::kAccelerationX)) = engine_.acceleration();
  Eigen::Map<Vector3d>(&Value(protocol::kMomentumX)) = momentum;
  Eigen::Map<Vector3d>(&Value(protocol::kAngularX)) = angular;
  Value(protocol::kMomentumSum) = momentum_sum;
  Value(protocol::kAngularSum) = angular_sum;
}

/// A wall's size is that of the object that touches it.
double Sampler::SizeOf(const btCollisionObject* body) const {
  const auto index = static_cast<std::size_t>(body->getUserIndex());
  return index < shape_.objects ? values_[shape_.Body(index) + 1]
                                : std::numeric_limits<double>::infinity();
}

void Sampler::TakeContacts() {
  double contacts = 0, overlaps = 0, sum = 0, deepest = 0;
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world())) {
    const double size = std::min(SizeOf(manifold.getBody0()), SizeOf(manifold.getBody1()));
    contacts += manifold.getNumContacts();
    for (int j = 0; j < manifold.getNumContacts(); ++j) {
      const double depth = -static_cast<double>(manifold.getContactPoint(j).getDistance()) / size;
      if (!(depth > 0)) continue;
      ++overlaps;
      sum += depth;
      deepest = std::max(deepest, depth);
    }
  }
  Value(protocol::kContactCount) = contacts;
  Value(protocol::kDepthMean) = overlaps > 0 ? sum / overlaps : 0;
  Value(protocol::kDepthMax) = deepest;
}

void Sampler::TakePairs() {
  const btOverlappingPairCache& cache = *engine_.world().getPairCache();
  const btBroadphasePair* begin =
      const_cast<btOverlappingPairCache&>(cache).getOverlappingPairArrayPtr();
  std::vector<BodyPair> found;
  for (int i = 0; i < cache.getNumOverlappingPairs(); ++i) {
    const auto index = [](const btBroadphaseProxy* proxy) {
      return static_cast<std::uint32_t>(
          static_cast<const btCollisionObject*>(proxy->m_clientObject)->getUserIndex());
    };
    const auto pair = std::minmax({index(begin[i].m_pProxy0), index(begin[i].m_pProxy1)});
    if (pair.second < shape_.objects) found.push_back(pair);
  }
  std::ranges::sort(found);
  std::vector<BodyPair> missed, false_positives;
  std::ranges::set_difference(exact_, found, std::back_inserter(missed));
  std::ranges::set_difference(found, exact_, std::back_inserter(false_positives));
  Value(protocol::kPairsExact) = static_cast<double>(exact_.size());
  Value(protocol::kPairsMissed) = static_cast<double>(missed.size());
  Value(protocol::kPairsPhantom) = static_cast<double>(false_positives.size());
}

void Sampler::TakeGeometry() {
  const NarrowPhaseErrors errors = CompareContacts(engine_, overlaps_);
  Value(protocol::kOverlapsExact) = static_cast<double>(overlaps_.overlaps.size());
  Value(protocol::kOverlapsMissed) = errors.missed;
  Value(protocol::kDepthErrorSum) = errors.depth_sum;
  Value(protocol::kNormalErrorSum) = errors.normal_sum;
  Value(protocol::kNormalCount) = errors.normals;
}

}  // namespace cdb::probes
