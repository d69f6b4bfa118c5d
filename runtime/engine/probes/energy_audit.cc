#include "runtime/engine/probes/energy_audit.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;

/// The energy of a fall by this fraction of an object's side is ignored in a loss, and a tenth of
/// that of a higher one in a gain: contacts at rest tremble, and the corners of a box that friction
/// brakes rebound.
constexpr double kLeastFall = 0.01, kLeastRise = 0.1;
/// An approach by more than so many falls in a cycle is an impact. A contact at rest has one.
constexpr double kImpact = 4;
/// Of the energy of rebounds, half as much excess is a gain: they do not tremble. Balls that drop
/// from 0.1 to 10 m with contact faithful have an excess of 0.000.
constexpr double kReboundWeight = 2;
/// Of the kinetic energy: impacts with less are the rocking of what slides.
constexpr double kLeastImpacts = 0.05;
/// Fraction of the approach; by less, other contacts than the point's change it.
constexpr double kLeastChange = 0.1;
/// Fraction of the velocity of an object; a slower contact point does not slip.
constexpr double kSlips = 0.1;
/// s: the time in which friction stops an object that would stop anyway.
constexpr double kSoon = 1;

/// Velocity of a point of a body; `arm`: the point relative to the centre of mass.
Vector3d PointVelocity(const btVector3& velocity, const btVector3& spin, const Vector3d& arm) {
  return world::ToEigen(velocity) + world::ToEigen(spin).cross(arm);
}

}  // namespace

EnergyAudit::EnergyAudit(world::Engine& engine, const world::Coefficients& coefficients)
    : engine_(engine), coefficients_(coefficients) {
  for (const layouts::ObjectState& object : engine.initial_state().objects) {
    masses_.push_back(object.mass);
    inertias_.push_back(object.solid.InertiaPerMass());
  }
}

void EnergyAudit::Begin(double kinetic, double energy) {
  const double jerk = engine_.links().JerkEnergy();
  start_ = energy - jerk;
  peak_ = peak_without_gain_ = kinetic - jerk;
  lowest_ = start_;
  scale_ = 0;
  const double pull = engine_.acceleration().norm();
  fall_ = pull * static_cast<double>(engine_.timestep());
  weight_ = pull * std::accumulate(masses_.begin(), masses_.end(), 0.0);
  for (std::size_t i = 0; i < masses_.size(); ++i) {
    const double side = 2 * engine_.initial_state().objects[i].solid.LeastHalfExtent();
    // Besides gravity, the energy of moving by a tenth of its side per second.
    scale_ += masses_[i] * (pull * side + std::pow(0.1 * side, 2) / 2) + PushOn(i) * side;
  }
}

EnergyAudit::Seen EnergyAudit::After(const BodyStates& before, const BodyStates& now,
                                     double kinetic, double energy) {
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world()))
    taken_ += TakenBy(manifold, before, now);
  const double rounding = TakenByRounding(now);
  taken_ += TakenBySleep(before, now) + rounding;
  peak_ = std::max(peak_, kinetic);
  const double scale = peak_ + kLeastFall * scale_;
  if (!(scale > 0)) return {0, 0};
  // No object has fallen farther through the gaps of joints than their sum.
  const double sagged = weight_ * engine_.links().MeasureGaps().sum;
  return {(start_ - energy - taken_ - sagged) / scale, Gained(kinetic, energy, sagged, rounding)};
}

double EnergyAudit::Gained(double kinetic, double energy, double sagged, double rounding) {
  if (energy < lowest_) {
    lowest_ = energy;
    given_ = rounded_ = 0;
  }
  rounded_ += rounding;
  // Joints pull together what they let sag.
  given_ = std::max(given_, LiftOfContacts() + sagged);
  const double risen = energy - lowest_;
  peak_without_gain_ = std::max(peak_without_gain_, kinetic - risen);
  return std::max((risen - given_ - rounded_) / (peak_without_gain_ + kLeastRise * scale_),
                  kReboundWeight * excess_ /
                      (approached_ + kLeastImpacts * peak_without_gain_ + kLeastRise * scale_));
}

double EnergyAudit::PushOn(std::size_t object) const {
  return engine_.pushes().Strength(
      object, 2 * engine_.initial_state().objects[object].solid.LeastHalfExtent());
}

/// J: of all objects that a contact may lift by its depth, which are those connected with it, and
/// of each by the fall of a cycle, as contacts tremble.
double EnergyAudit::LiftOfContacts() {
  connected_.resize(masses_.size());
  std::iota(connected_.begin(), connected_.end(), 0u);
  const auto root = [&](std::size_t object) {
    while (connected_[object] != object)
      object = connected_[object] = connected_[connected_[object]];
    return object;
  };
  const auto is_free = [&](const btCollisionObject* body) {
    const auto index = static_cast<std::size_t>(body->getUserIndex());
    return index < masses_.size() && masses_[index] > 0;
  };
  std::vector<std::pair<std::size_t, double>> depths;  // by an object in contact
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world())) {
    const btCollisionObject *a = manifold.getBody0(), *b = manifold.getBody1();
    if (is_free(a) && is_free(b))
      connected_[root(static_cast<std::size_t>(a->getUserIndex()))] =
          static_cast<std::uint32_t>(root(static_cast<std::size_t>(b->getUserIndex())));
    double depth = 0;
    for (int j = 0; j < manifold.getNumContacts(); ++j)
      depth = std::max(depth, -static_cast<double>(manifold.getContactPoint(j).getDistance()));
    if (const auto* body = is_free(a) ? a : is_free(b) ? b : nullptr)
      depths.emplace_back(static_cast<std::size_t>(body->getUserIndex()), depth);
  }
  // N: of their weight, and of what else pushes them into a contact.
  std::vector<double> loads(masses_.size(), 0);
  for (std::size_t i = 0; i < masses_.size(); ++i)
    loads[root(i)] += masses_[i] * engine_.acceleration().norm() + PushOn(i);
  double lift = weight_ * fall_ * static_cast<double>(engine_.timestep());
  for (const auto& [object, depth] : depths) lift += loads[root(object)] * depth;
  return lift;
}

double EnergyAudit::TakenBy(const btPersistentManifold& manifold, const BodyStates& before,
                            const BodyStates& now) {
  const auto velocity_in = [&](const BodyStates& states, const btCollisionObject* body,
                               const Vector3d& point) -> Vector3d {
    const auto index = static_cast<std::size_t>(body->getUserIndex());
    if (index >= masses_.size() || masses_[index] == 0) return Vector3d::Zero();
    const Vector3d arm = point - world::ToEigen(before[index].pose.getOrigin());
    return PointVelocity(states[index].velocity, states[index].spin, arm);
  };
  const auto body = [](const btCollisionObject* object) {
    return static_cast<std::size_t>(object->getUserIndex());
  };
  const double restitution =
      coefficients_.Restitution(body(manifold.getBody0()), body(manifold.getBody1()));
  double taken = 0;
  for (int j = 0; j < manifold.getNumContacts(); ++j) {
    const btManifoldPoint& point = manifold.getContactPoint(j);
    if (!world::HasImpulse(manifold, point)) continue;
    const auto relative = [&](const BodyStates& states) -> Vector3d {
      return velocity_in(states, manifold.getBody0(), world::ToEigen(point.getPositionWorldOnA())) -
             velocity_in(states, manifold.getBody1(), world::ToEigen(point.getPositionWorldOnB()));
    };
    const Vector3d at_start = relative(before), at_end = relative(now);
    const auto work = [&](const btVector3& impulse) {
      return -(at_start + at_end).dot(world::ToEigen(impulse)) / 2;
    };
    taken += std::max(0.0, work(world::FrictionImpulse(point)));
    // Negative where a contact pushes objects out of each other.
    const double impact = work(point.m_appliedImpulse * point.m_normalWorldOnB);
    const Vector3d normal = world::ToEigen(point.m_normalWorldOnB);
    const double approach = fall_ + std::max(0.0, -at_start.dot(normal)),
                 rebound = std::max(0.0, at_end.dot(normal)),
                 // A contact before the bodies touch leaves a part of the approach to a later one.
        change = approach + std::min(at_end.dot(normal), 0.0) + rebound,
                 mass = static_cast<double>(point.m_appliedImpulse) /
                        std::max(change, kLeastChange * approach);
    if (approach > kImpact * fall_) {
      // The fall of the cycle does not count as approach for restitution.
      const double allowed = restitution * (approach - fall_);
      approached_ += mass * std::pow(approach, 2) / 2;
      excess_ += mass * std::max(0.0, std::pow(rebound, 2) - std::pow(allowed, 2)) / 2;
    }
    const double inelastic = mass * std::pow(approach, 2) * (1 - std::pow(restitution, 2)) / 2;
    taken += restitution == 0 ? impact : std::min(impact, inelastic);
  }
  return taken;
}

double EnergyAudit::KineticOf(std::size_t object, const BodyState& state) const {
  const Vector3d spin = world::ToEigen(state.spin * state.pose.getBasis());
  return masses_[object] / 2 *
         (world::ToEigen(state.velocity).squaredNorm() + inertias_[object].dot(spin.cwiseAbs2()));
}

/// By object: 1 if a contact point of it moves over the other surface, so that friction would have
/// stopped it soon.
std::vector<char> EnergyAudit::Slipping(const BodyStates& states) const {
  std::vector<char> slipping(states.size(), 0);
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world())) {
    for (const btCollisionObject* body : {manifold.getBody0(), manifold.getBody1()}) {
      const auto index = static_cast<std::size_t>(body->getUserIndex());
      if (index >= states.size()) continue;
      const BodyState& state = states[index];
      const double speed = world::ToEigen(state.velocity).norm(), least = kSlips * speed;
      // Friction takes longer to stop a faster one.
      const double friction =
          coefficients_.Friction(static_cast<std::size_t>(manifold.getBody0()->getUserIndex()),
                                 static_cast<std::size_t>(manifold.getBody1()->getUserIndex()));
      if (speed > friction * engine_.acceleration().norm() * kSoon) continue;
      for (int j = 0; j < manifold.getNumContacts(); ++j) {
        const Vector3d arm = world::ToEigen(manifold.getContactPoint(j).getPositionWorldOnB() -
                                            state.pose.getOrigin());
        if (PointVelocity(state.velocity, state.spin, arm).norm() > least) slipping[index] = 1;
      }
    }
  }
  return slipping;
}

/// At most: far from the origin, positions are too coarse for the steps of a resting object.
double EnergyAudit::TakenByRounding(const BodyStates& now) const {
  double taken = 0;
  for (std::size_t i = 0; i < masses_.size(); ++i)
    if (masses_[i] > 0 && !now[i].is_asleep)
      taken += masses_[i] * world::ToEigen(now[i].pose.getOrigin()).norm();
  return taken * engine_.acceleration().norm() * static_cast<double>(SIMD_EPSILON) / 2;
}

double EnergyAudit::TakenBySleep(const BodyStates& before, const BodyStates& now) const {
  std::vector<std::size_t> stopped;
  for (std::size_t i = 0; i < masses_.size(); ++i)
    if (now[i].is_asleep && !(before[i].velocity.isZero() && before[i].spin.isZero()))
      stopped.push_back(i);
  if (stopped.empty()) return 0;
  const std::vector<char> slipping = Slipping(before);
  const Vector3d fall = engine_.acceleration() * static_cast<double>(engine_.timestep());
  double taken = 0;
  for (const std::size_t i : stopped) {
    if (slipping[i] == 0) continue;
    const double fallen = masses_[i] * std::abs(fall.dot(world::ToEigen(before[i].velocity)));
    taken += KineticOf(i, before[i]) + fallen;
  }
  return taken;
}

}  // namespace cdb::probes
