#include "runtime/engine/probes/probes.h"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "compiler/analysis/coverage.h"
#include "compiler/analysis/expectation.h"
#include "compiler/analysis/reference.h"
#include "runtime/engine/probes/processor_time.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/manifolds.h"
#include "runtime/protocol/file_descriptor_io.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;

/// Kinetic and potential energy; `energy` is their sum with the integrator's own term.
struct Energy {
  double kinetic = 0, other = 0;
};

/// x* = x + v dt with v = v + g dt: v^2/2 - g.x + dt g.v/2 is constant in free flight.
Energy EnergyOf(const world::Engine& engine) {
  const Vector3d& g = engine.acceleration();
  const double half_timestep = static_cast<double>(engine.timestep()) / 2;
  Energy energy;
  for (std::size_t i = 0; i < engine.objects().size(); ++i) {
    const layouts::ObjectState& object = engine.initial_state().objects[i];
    if (object.IsFixed() || !engine.IsPresent(i)) continue;
    const btRigidBody& body = *engine.objects()[i];
    const Vector3d v = world::ToEigen(body.getLinearVelocity());
    // The axes of a body are its principal axes.
    const Vector3d spin =
        world::ToEigen(body.getAngularVelocity() * body.getWorldTransform().getBasis());
    const Vector3d inertia = object.solid.InertiaPerMass();
    energy.kinetic += object.mass / 2 * (v.squaredNorm() + inertia.dot(spin.cwiseAbs2()));
    const Vector3d x = world::ToEigen(body.getWorldTransform().getOrigin());
    energy.other += object.mass * (half_timestep * g.dot(v) - g.dot(x));
  }
  energy.kinetic += engine.links().RotorEnergy();
  energy.other -= engine.Work();
  return energy;
}

/// Replaces BT_LARGE_FLOAT, which Bullet uses for the sides of a plane's box, by infinity.
double WithInfinity(btScalar side) {
  if (std::fabs(side) < BT_LARGE_FLOAT) return static_cast<double>(side);
  return std::copysign(std::numeric_limits<double>::infinity(), static_cast<double>(side));
}

bool IsFinite(const btRigidBody& body) {
  using world::IsFinite;
  const btMatrix3x3& basis = body.getWorldTransform().getBasis();
  return IsFinite(body.getWorldTransform().getOrigin()) && IsFinite(basis[0]) &&
         IsFinite(basis[1]) && IsFinite(basis[2]) && IsFinite(body.getLinearVelocity()) &&
         IsFinite(body.getAngularVelocity());
}

}  // namespace

Probes::Probes(const plan::Scene& scene, world::Engine& engine, protocol::Recording& recording,
               int contacts_fd)
    : engine_(engine),
      recording_(recording),
      header_(recording.header()),
      cycles_(scene.world.Count("cycles")),
      is_driven_(analysis::ExpectationOf(scene) == analysis::Expectation::kDriven),
      streams_contacts_(scene.world.Lists("record", "contacts")),
      all_walls_(scene.world.WordOr("world.walls") == "all"),
      floor_(scene.world.WordOr("world.walls") == "floor"),
      is_floor_box_(scene.world.WordOr("world.wall_shape") == "box"),
      contacts_fd_(contacts_fd),
      standing_walls_(omissions::StandingWalls(scene)) {
  if (recording_.Reals("max_speed").empty()) return;
  touches_.resize(engine.objects().size() + omissions::kWallCount);
  below_.resize(engine.objects().size(), Below::kNot);
  contact_sides_.emplace(engine);
  if (recording_.Reals("motion_ratio").empty()) return;
  motion_watch_.emplace(engine, is_driven_);
  soundness_.emplace(scene, engine, *contact_sides_);
  motor_watch_ = engine.links().WatchMotors();
}

void Probes::Begin() {
  if (!recording_.Reals("box_filters").empty()) RecordFilters();
  if (!contact_sides_) return;
  if (motion_watch_) motion_watch_->Begin();
  SetScales();
}

/// In least sides: the fall whose energy is the scale of a run at rest. A hundredth of it pushes an
/// object out of a penetration of a quarter of its side, which has a verdict of its own.
constexpr double kFall = 25;

void Probes::SetScales() {
  const Energy energy = EnergyOf(engine_);
  const double pull = engine_.acceleration().norm();
  header_.scales.initial_energy =
      energy.kinetic + energy.other +
      engine_.links().SpringEnergy(static_cast<double>(engine_.timestep()));
  if (soundness_) soundness_->Begin(energy.kinetic, header_.scales.initial_energy);
  // What perfect joints take at once from velocities that contradict them is not lost.
  header_.scales.initial_energy -= engine_.links().JerkEnergy();
  header_.scales.energy_scale = energy.kinetic;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < engine_.objects().size(); ++i) {
    const double mass = engine_.initial_state().objects[i].mass;
    // Of the object as a whole: a small piece of a compound makes neither its joints nor its rest
    // worse.
    if (mass > 0)
      smallest = std::min(smallest, engine_.initial_state().objects[i].solid.sides.minCoeff());
    const double side = contact_sides_->least()[i];
    // Without gravity, an object at rest has no energy as a scale: that of moving by a hundredth of
    // its side per second is used.
    header_.scales.energy_scale += mass * (kFall * pull * side + std::pow(0.01 * side, 2) / 2) +
                                   kFall * engine_.pushes().Strength(i, side) * side;
  }
  header_.scales.least_side = smallest;
  header_.scales.moving_objects = static_cast<double>(std::ranges::count_if(
      engine_.objects(), [](const auto& body) { return !body->isStaticOrKinematicObject(); }));
  header_.scales.speed_scale = std::isfinite(smallest) ? std::sqrt(pull * smallest) : 0;
}

void Probes::Record(std::uint64_t cycle) {
  if (engine_.timed_world() != nullptr)
    world::RecordPhases(engine_.timed_world()->Phases(), cycle, recording_);
  // First, because the following may use the heap.
  if (!recording_.Reals("heap").empty()) recording_.Put("heap", cycle, HeapBytes());
  recording_.Put("pairs", cycle, engine_.world().getPairCache()->getNumOverlappingPairs());
  if (const world::Population* population = engine_.population()) {
    recording_.Put("present", cycle, static_cast<std::int32_t>(engine_.present()));
    recording_.Put("spawned", cycle, population->last().spawned);
    recording_.Put("departed", cycle, population->last().departed);
    recording_.Put("waiting", cycle, population->last().waiting);
    recording_.Put("change_time", cycle, population->last().ns);
  }
  if (!recording_.Ints("manifolds").empty() || !recording_.Ints("contacts").empty() ||
      !recording_.Reals("max_penetration").empty())
    RecordManifolds(cycle);
  if (!recording_.Reals("max_speed").empty()) RecordStability(cycle);
  if (motion_watch_) RecordMotion(cycle);
  if (!recording_.Reals("energy").empty()) RecordEnergy(cycle);
  if (!recording_.Reals("poses").empty()) RecordPoses(cycle);
  if (!recording_.Reals("repose_angle").empty()) RecordRepose(cycle);
  if (!recording_.Reals("boxes").empty()) RecordBoxes(cycle);
  // The series has no value if there is no joint.
  if (engine_.links().HasJoints() && !recording_.Reals("joint_gap").empty()) RecordJoints(cycle);
  if (soundness_) RecordSoundness(cycle);
}

void Probes::RecordJoints(std::uint64_t cycle) {
  const world::Links::Gaps gaps = engine_.links().MeasureGaps();
  recording_.Put("joint_gap", cycle, gaps.largest);
  recording_.Put("joint_bend", cycle, gaps.bend);
  recording_.Put("joint_stretch", cycle, gaps.stretch);
  if (motor_watch_ == nullptr) return;
  if (const auto miss = motor_watch_->LargestMiss(engine_.world(), header_.scales.least_side))
    recording_.Put("motor_error", cycle, *miss);
}

void Probes::RecordSoundness(std::uint64_t cycle) {
  const Soundness::Seen seen = soundness_->After(recording_.Reals("kinetic_energy")[cycle],
                                                 recording_.Reals("energy")[cycle]);
  recording_.Put("passed", cycle, seen.passes.passed);
  recording_.Put("unfollowed", cycle, seen.passes.unfollowed);
  recording_.Put("pressed", cycle, seen.pressed);
  recording_.Put("inverted", cycle, seen.inverted);
  recording_.Put("unheld", cycle, seen.unheld);
  recording_.Put("lost_energy", cycle, seen.energy.lost);
  recording_.Put("gained_energy", cycle, seen.energy.gained);
  recording_.Put("false_normals", cycle, seen.normals.false_normals);
  recording_.Put("false_impulse", cycle, seen.normals.false_impulse);
  recording_.Put("deflected", cycle, seen.normals.deflected);
  recording_.Put("false_turn", cycle, seen.friction.false_turn);
  recording_.Put("twisted", cycle, seen.friction.twisted);
  recording_.Put("friction_error", cycle, seen.friction.friction_error);
  recording_.Put("rolling_error", cycle, seen.rolling_error);
  recording_.Put("impact_error", cycle, seen.impacts.error);
  recording_.Put("unjudged_impacts", cycle, seen.impacts.unjudged);
}

// Of the 95 % of a uniform cone that are nearest to its axis, the mean height is 0.26081 of that of
// the cone, and the mean distance from the axis 0.47837 of its radius. What strays does not count.
void Probes::RecordRepose(std::uint64_t cycle) {
  constexpr double kPart = 0.95, kSlope = 0.47837 / 0.26081;
  struct Grain {
    double distance = 0, mass = 0;
    Vector3d at;
  };
  std::vector<Grain> grains;
  double mass = 0;
  for (std::size_t i = 0; i < engine_.objects().size(); ++i) {
    const btRigidBody& body = *engine_.objects()[i];
    if (!engine_.IsPresent(i) || body.isStaticOrKinematicObject() ||
        !world::IsFinite(body.getWorldTransform().getOrigin()))
      continue;
    grains.push_back({.mass = engine_.initial_state().objects[i].mass,
                      .at = world::ToEigen(body.getWorldTransform().getOrigin())});
    mass += grains.back().mass;
  }
  if (grains.empty()) return;
  // The first ones, with the mass of each that is within this part of the whole.
  const auto first = [&](double part, const auto& act) {
    double sum = 0;
    for (const Grain& grain : grains) {
      if (sum >= part * mass) return;
      act(grain, std::min(grain.mass, part * mass - sum));
      sum += grain.mass;
    }
  };
  Vector3d axis = Vector3d::Zero();
  for (const int k : {0, 2}) {
    std::ranges::sort(grains, {}, [&](const Grain& grain) { return grain.at[k]; });
    first(0.5, [&](const Grain& grain, double) { axis[k] = grain.at[k]; });
  }
  for (Grain& grain : grains)
    grain.distance = std::hypot(grain.at.x() - axis.x(), grain.at.z() - axis.z());
  std::ranges::sort(grains, {}, &Grain::distance);
  double height = 0, distance = 0, runout = 0;
  first(kPart, [&](const Grain& grain, double of) {
    height += of * (grain.at.y() + engine_.side() / 2);
    distance += of * grain.distance;
    runout = grain.distance;
  });
  recording_.Put("repose_angle", cycle, std::atan2(kSlope * height, distance));
  recording_.Put("runout", cycle, runout);
}

void Probes::RecordManifolds(std::uint64_t cycle) {
  std::int32_t manifolds = 0, contacts = 0;
  double deepest = 0, deepest_ratio = 0;
  std::ranges::fill(touches_, 0);
  for (std::size_t i = 0; i < touches_.size(); ++i)
    if (engine_.links().Holds(i)) touches_[i] = MotionWatch::kHeld;
  contact_records_.clear();
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world())) {
    const int count = manifold.getNumContacts();
    const auto a = static_cast<std::size_t>(manifold.getBody0()->getUserIndex());
    const auto b = static_cast<std::size_t>(manifold.getBody1()->getUserIndex());
    ++manifolds;
    contacts += count;
    for (int j = 0; j < count; ++j) {
      const btManifoldPoint& point = manifold.getContactPoint(j);
      const double distance = static_cast<double>(point.getDistance());
      deepest = std::max(deepest, -distance);
      if (!touches_.empty())
        for (const std::size_t body : {a, b}) {
          char& touch = touches_[body];
          touch = std::max<char>(touch, distance < 0 ? MotionWatch::kPushed : MotionWatch::kHeld);
        }
      if (contact_sides_ && -distance > deepest_ratio * contact_sides_->Least(a, b))
        deepest_ratio = std::max(deepest_ratio, -distance / contact_sides_->At(manifold, point));
      if (!streams_contacts_) continue;
      const Vector3d at = world::ToEigen(point.getPositionWorldOnA());
      const Vector3d normal = world::ToEigen(point.m_normalWorldOnB);
      contact_records_.push_back({static_cast<double>(a),
                                  static_cast<double>(b),
                                  {at.x(), at.y(), at.z()},
                                  {normal.x(), normal.y(), normal.z()},
                                  distance});
    }
  }
  recording_.Put("manifolds", cycle, manifolds);
  recording_.Put("contacts", cycle, contacts);
  recording_.Put("max_penetration", cycle, deepest);
  recording_.Put("penetration_ratio", cycle, deepest_ratio);
  protocol::WriteAll(contacts_fd_, std::as_bytes(std::span(contact_records_)),
                     "cannot write the contacts");
}

bool Probes::IsBeyondWall(std::size_t object, const Vector3d& centre) {
  const double half = engine_.side() / 2;
  if (all_walls_) return centre.cwiseAbs().maxCoeff() > half;
  Below& below = below_[object];
  if (!floor_ || !(centre.y() < -half)) {
    below = Below::kNot;
  } else if (below == Below::kNot) {
    // A floor that is a box has edges, over which objects may fall.
    const double edge = half + omissions::kWallThickness * engine_.side();
    const bool is_outside = std::max(std::fabs(centre.x()), std::fabs(centre.z())) > edge;
    below = is_floor_box_ && is_outside ? Below::kFellOff : Below::kWentThrough;
  }
  return below == Below::kWentThrough;
}

/// Bullet removes a body whose box is larger, or, if it may not sleep, stops updating its box
/// (btCollisionWorld::updateSingleAabb).
bool Probes::IsTooLarge(const btRigidBody& body) const {
  constexpr btScalar kMostDiagonal = btScalar(analysis::kLargestBox);
  const btScalar way = body.getLinearVelocity().length() * engine_.timestep();
  const btScalar disc = body.getCollisionShape()->getAngularMotionDisc();
  if (4 * (disc + way) < kMostDiagonal) return false;
  btVector3 lower, upper, swept_lower, swept_upper;
  const btCollisionShape& shape = *body.getCollisionShape();
  shape.getAabb(body.getWorldTransform(), lower, upper);
  shape.getAabb(body.getInterpolationWorldTransform(), swept_lower, swept_upper);
  lower.setMin(swept_lower);
  upper.setMax(swept_upper);
  return !((upper - lower).length() < kMostDiagonal);
}

void Probes::RecordStability(std::uint64_t cycle) {
  double fastest = 0;
  std::int32_t escaped = 0, asleep = 0, removed = 0, non_finite = 0;
  for (std::size_t i = 0; i < engine_.objects().size(); ++i) {
    if (!engine_.IsPresent(i)) continue;
    const auto& body = engine_.objects()[i];
    if (!IsFinite(*body)) {
      ++non_finite;
      continue;
    }
    if (body->isKinematicObject()) continue;  // moves as it is told
    if (body->isStaticObject()) continue;     // Bullet marks fixed bodies as asleep
    escaped += engine_.MayTouchWalls(i) &&
               IsBeyondWall(i, world::ToEigen(body->getWorldTransform().getOrigin()));
    fastest = std::max(fastest, world::ToEigen(body->getLinearVelocity()).norm());
    asleep += body->getActivationState() == ISLAND_SLEEPING;
    removed += body->getActivationState() == DISABLE_SIMULATION || IsTooLarge(*body);
  }
  recording_.Put("max_speed", cycle, fastest);
  recording_.Put("escaped", cycle, escaped);
  recording_.Put("asleep", cycle, asleep);
  recording_.Put("removed", cycle, removed);
  recording_.Put("non_finite", cycle, non_finite);
}

void Probes::RecordMotion(std::uint64_t cycle) {
  const MotionWatch::Seen seen = motion_watch_->After(touches_);
  recording_.Put("displacement", cycle, seen.displacement);
  recording_.Put("motion_ratio", cycle, seen.motion_ratio);
  recording_.Put("fall_ratio", cycle, seen.fall_ratio);
  recording_.Put("lost_way", cycle, seen.lost_way);
  recording_.Put("frozen", cycle, seen.frozen);
  recording_.Put("displaced", cycle, seen.displaced);
  recording_.Put("turn_ratio", cycle, seen.turn_ratio);
  recording_.Put("spin_ratio", cycle, seen.spin_ratio);
}

void Probes::RecordEnergy(std::uint64_t cycle) {
  const Energy energy = EnergyOf(engine_);
  const world::Links& links = engine_.links();
  const SpringEnergies springs{links.SpringEnergy(0),
                               links.SpringEnergy(static_cast<double>(engine_.timestep()))};
  recording_.Put("kinetic_energy", cycle, energy.kinetic);
  recording_.Put("energy", cycle,
                 RecordedEnergy(energy.kinetic, energy.other, springs, header_.scales));
}

void Probes::RecordPoses(std::uint64_t cycle) {
  auto at = recording_.Reals("poses")
                .subspan(cycle * engine_.objects().size() * protocol::kPoseSize)
                .begin();
  for (std::size_t i = 0; i < engine_.objects().size(); ++i) {
    const btTransform& body = engine_.objects()[i]->getWorldTransform();
    const btQuaternion turn = body.getRotation();
    const objects::Pose pose =
        objects::OriginOf(engine_.initial_state().objects[i].solid,
                          {world::ToEigen(body.getOrigin()), world::ToEigen(turn)});
    const bool is_there = engine_.IsPresent(i);
    const auto put = [&](double value) {
      *at++ = is_there ? value : std::numeric_limits<double>::quiet_NaN();
    };
    for (const double x : pose.position) put(x);
    for (const double part : pose.orientation.coeffs()) put(part);  // x, y, z, w
  }
}

/// Index among the bodies with a box: the standing walls follow the objects without a gap.
std::size_t Probes::PlaceOfWall(const btRigidBody& wall) const {
  const auto index =
      static_cast<unsigned>(wall.getUserIndex()) - static_cast<unsigned>(engine_.objects().size());
  return engine_.objects().size() +
         static_cast<std::size_t>(std::popcount(standing_walls_ & ((1u << index) - 1)));
}

void Probes::RecordFilters() {
  const auto filters = recording_.Reals("box_filters");
  const auto record = [&](std::size_t place, const btRigidBody& body) {
    const btBroadphaseProxy& proxy = *body.getBroadphaseHandle();
    double* filter = &filters[place * protocol::kFilterSize];
    filter[0] = static_cast<std::uint32_t>(proxy.m_collisionFilterGroup);
    filter[1] = static_cast<std::uint32_t>(proxy.m_collisionFilterMask);
    filter[2] = body.isStaticOrKinematicObject() ? 1 : 0;
  };
  for (std::size_t i = 0; i < engine_.objects().size(); ++i) record(i, *engine_.objects()[i]);
  for (const auto& wall : engine_.walls()) record(PlaceOfWall(*wall), *wall);
}

/// A broad phase keeps a box until it is given the next.
void Probes::RecordBoxes(std::uint64_t cycle) {
  const auto boxes = recording_.Reals("boxes");
  const std::size_t bodies = recording_.Reals("box_filters").size() / protocol::kFilterSize;
  const auto record = [&](std::size_t place, const btRigidBody& body) {
    btVector3 lower, upper;
    engine_.world().getBroadphase()->getAabb(
        const_cast<btBroadphaseProxy*>(body.getBroadphaseHandle()), lower, upper);
    // A detector may have got the half-space instead; a trace must not depend on the detector.
    if (body.getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE) {
      upper = btVector3(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
      lower = -upper;
    }
    double* box = &boxes[(cycle * bodies + place) * protocol::kBoxSize];
    for (const btVector3* corner : {&lower, &upper})
      for (int axis = 0; axis < 3; ++axis) *box++ = WithInfinity((*corner)[axis]);
  };
  for (std::size_t i = 0; i < engine_.objects().size(); ++i) record(i, *engine_.objects()[i]);
  for (const auto& wall : engine_.walls()) record(PlaceOfWall(*wall), *wall);
}

Soundness::Soundness(const plan::Scene& scene, world::Engine& engine,
                     const ContactSides& contact_sides)
    : engine_(engine),
      passes_(engine),
      presses_(engine, contact_sides,
               analysis::ExpectationOf(scene) == analysis::Expectation::kDriven ||
                   !engine.pushes().IsEmpty()),
      sleepers_(engine),
      normals_(engine),
      supports_(engine),
      coefficients_(scene, engine.initial_state()),
      friction_(engine, coefficients_),
      rolling_(engine),
      impacts_(scene, engine, coefficients_),
      are_losses_judged_(analysis::IsChecked(analysis::Question::kLosses, scene)) {
  if (analysis::AreGainsJudged(scene)) audit_.emplace(engine, coefficients_);
}

void Soundness::Begin(double kinetic, double energy) {
  ReadStates(engine_, before_);
  if (audit_) audit_->Begin(kinetic, energy);
}

Soundness::Seen Soundness::After(double kinetic, double energy) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  ReadStates(engine_, now_);
  const PressWatch::Seen pressed = presses_.After();
  EnergyAudit::Seen audited{kNone, kNone};
  if (audit_) audited = audit_->After(before_, now_, kinetic, energy);
  if (!are_losses_judged_) audited.lost = kNone;
  supports_.Find();
  const Seen seen{passes_.After(before_, now_),
                  pressed.pressed,
                  pressed.inverted,
                  sleepers_.After(before_, now_),
                  audited,
                  normals_.After(before_, now_),
                  friction_.After(before_, now_, supports_),
                  rolling_.After(before_, now_, supports_),
                  impacts_.After(before_, now_, passes_.meetings())};
  before_.swap(now_);
  return seen;
}

}  // namespace cdb::probes
