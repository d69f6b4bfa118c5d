#include "runtime/engine/probes/impact_bodies.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compiler/analysis/expectation.h"
#include "runtime/engine/world/conversions.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;
using exact::ImpactBody;

/// An approach in least sides, and in falls of a cycle.
constexpr double kImpactFall = 0.05, kImpactFalls = 4;
/// 1/s: without gravity, of the least side.
constexpr double kImpactRate = 0.1;
/// Of a cycle: further points that follow within this time touch at once; points that follow later,
/// but within the other, are another impact, which the first one changes.
constexpr double kAtOnce = 0.25, kAmbiguous = 4;
/// rad: at most, between faces of which all points touch at once, for certain or possibly; of which
/// any do; at rest.
constexpr double kFlush = 0.002, kParallel = 0.02, kMostTilt = 0.5, kNearlyParallel = 0.05;
/// Regions of contact, in least half extents and relative to each other.
constexpr double kPoint = 0.1, kSameRegion = 0.2;
/// In least sides: contacts at rest are as deep. Where the shortest way out of one has another
/// direction (a cosine) than the touch, it is not known which counts.
constexpr double kShallow = 0.05, kOtherWay = 0.9;
/// Of a cycle, in which it is seen how two part.
constexpr int kSamples = 4;

double Diameter(const std::vector<Vector3d>& points) {
  double most = 0;
  for (const Vector3d& a : points)
    for (const Vector3d& b : points) most = std::max(most, (a - b).norm());
  return most;
}

/// m: of a point of one set from the nearest of another, at most.
double Farthest(const std::vector<Vector3d>& points, const std::vector<Vector3d>& others) {
  double most = 0;
  for (const Vector3d& point : points) {
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3d& other : others) least = std::min(least, (point - other).norm());
    most = std::max(most, least);
  }
  return most;
}

bool IsFinite(const BodyState& state) {
  return world::IsFinite(state.pose.getOrigin()) && world::IsFinite(state.velocity) &&
         world::IsFinite(state.spin);
}

}  // namespace

ImpactBodies::ImpactBodies(const plan::Scene& scene, world::Engine& engine,
                           const world::Coefficients& coefficients)
    : engine_(engine),
      coefficients_(coefficients),
      timestep_(static_cast<double>(engine.timestep())) {
  for (std::size_t i = 0; i < engine.objects().size(); ++i) {
    const layouts::ObjectState& state = engine.initial_state().objects[i];
    const btRigidBody& body = *engine.objects()[i];
    Judged judged = Judged::kWhole;
    if (state.solid.compound || engine.links().Holds(i) || state.numbers["rolling_friction"] > 0 ||
        state.numbers["spinning_friction"] > 0)
      judged = Judged::kCone;
    const plan::Group& group = scene.groups[state.group];
    if (analysis::HasSchedule(group) && !state.is_kinematic) judged = Judged::kNot;
    if (engine.pushes().IsPushed(i)) judged = Judged::kNot;
    if (state.solid.IsSurface() || std::isfinite(state.numbers["contact_stiffness"]))
      judged = Judged::kNot;
    bodies_.push_back({state.mass, state.mass * state.solid.InertiaPerMass(),
                       std::pow(1 - static_cast<double>(body.getLinearDamping()), timestep_),
                       std::pow(1 - static_cast<double>(body.getAngularDamping()), timestep_),
                       2 * state.solid.LeastHalfExtent(), judged});
  }
}

bool ImpactBodies::AreFinite(const ImpactPair& pair, const BodyStates& states) const {
  return IsFinite(states[pair.a]) && (IsWall(pair.b) || IsFinite(states[pair.b]));
}

bool ImpactBodies::IsLinked(const ImpactPair& pair) const {
  return engine_.links().Holds(pair.a) || engine_.links().Holds(pair.b);
}

ImpactBodies::Judged ImpactBodies::JudgedOf(const ImpactPair& pair) const {
  const Judged judged = bodies_[pair.a].judged;
  return IsWall(pair.b) ? judged : std::min(judged, bodies_[pair.b].judged);
}

double ImpactBodies::LeastSide(const ImpactPair& pair) const {
  const double side = bodies_[pair.a].least_side;
  return IsWall(pair.b) ? side : std::min(side, bodies_[pair.b].least_side);
}

double ImpactBodies::LeastApproach(const ImpactPair& pair) const {
  const double side = LeastSide(pair);
  const double pull = engine_.acceleration().norm();
  return std::max({std::sqrt(2 * pull * kImpactFall * side), kImpactFalls * pull * timestep_,
                   kImpactRate * side});
}

double ImpactBodies::ApproachAt(const ImpactPair& pair, const exact::Touch& touch,
                                const Vector3d& point, const BodyStates& states) const {
  ImpactBody a = StateOf(pair.a, states), b = StateOf(pair.b, states);
  a.centre += touch.part * timestep_ * a.velocity;
  b.centre += touch.part * timestep_ * b.velocity;
  return -(exact::VelocityAt(a, point) - exact::VelocityAt(b, point)).dot(touch.normal);
}

ImpactBodies::Points ImpactBodies::PointsOf(const ImpactPair& pair, const exact::Touch& touch,
                                            const BodyStates& states) const {
  const Points one = {{touch.point}};
  if (IsRound(pair)) return one;
  const exact::Collider other = ColliderOf(pair.b, states);
  const objects::Pose pose = ColliderOf(pair.a, states).motion.At(touch.part),
                      other_pose = other.motion.At(touch.part);
  const auto region = [&](double tilt) {
    return exact::ContactRegion(SolidOf(pair.a), pose, other.solid, other_pose, touch, tilt);
  };
  const auto is_same = [](const std::vector<Vector3d>& whole, const std::vector<Vector3d>& part) {
    return Farthest(whole, part) <= kSameRegion * Diameter(whole);
  };
  const double half = LeastSide(pair) / 2;
  const double tilt = ApproachAt(pair, touch, touch.point, states) * timestep_ / half;
  const std::vector<Vector3d> all = region(std::min(kMostTilt, kAmbiguous * tilt));
  if (Diameter(all) <= kPoint * half) return one;
  const std::vector<Vector3d> close = region(std::min(kParallel, kAtOnce * tilt));
  if (!is_same(all, close)) return {one.points, false, true};
  return {close, true, !is_same(close, region(std::min(kFlush, kAtOnce * tilt)))};
}

bool ImpactBodies::IsRound(const ImpactPair& pair) const {
  const auto is_ellipsoid = [&](std::uint32_t body) {
    return !IsWall(body) && SolidOf(body).shape == objects::Shape::kEllipsoid;
  };
  return is_ellipsoid(pair.a) || is_ellipsoid(pair.b);
}

exact::SignedDistance ImpactBodies::Distance(const ImpactPair& pair,
                                             const BodyStates& states) const {
  const objects::Solid& solid = SolidOf(pair.a);
  const objects::Pose pose = world::ToPose(states[pair.a].pose);
  const exact::Collider other = ColliderOf(pair.b, states);
  return other.solid ? exact::DistanceOf(solid, pose, *other.solid, other.motion.from)
                     : exact::DistanceOf(solid, pose, other.plane);
}

bool ImpactBodies::Overlap(const ImpactPair& pair, double part, const BodyStates& states) const {
  const exact::Collider a = ColliderOf(pair.a, states), b = ColliderOf(pair.b, states);
  const objects::Pose pose = a.motion.At(part);
  return (b.solid ? exact::DistanceOf(*a.solid, pose, *b.solid, b.motion.At(part))
                  : exact::DistanceOf(*a.solid, pose, b.plane))
             .gap < 0;
}

bool ImpactBodies::LeavesAnotherWay(const ImpactPair& pair, const exact::Touch& touch,
                                    const BodyStates& states) const {
  if (IsWall(pair.b)) return false;
  return IsShallowAcross(pair, touch, Distance(pair, states));
}

bool ImpactBodies::IsShallowAcross(const ImpactPair& pair, const exact::Touch& touch,
                                   const exact::SignedDistance& distance) const {
  return distance.Depth() < kShallow * LeastSide(pair) &&
         distance.normal.dot(touch.normal) < kOtherWay;
}

bool ImpactBodies::SlidesAcross(const Meeting& meeting, const exact::Touch& touch) const {
  const ImpactPair pair{meeting.a, meeting.b};
  if (IsWall(pair.b)) return false;
  bool overlaps = false;
  for (int sample = 1; sample <= kSamples; ++sample) {
    const double part = touch.part + (1 - touch.part) * sample / kSamples;
    const exact::SignedDistance distance = exact::DistanceOf(
        SolidOf(pair.a), meeting.motion_a.At(part), SolidOf(pair.b), meeting.motion_b.At(part));
    if (distance.gap >= 0) continue;
    overlaps = true;
    if (!IsShallowAcross(pair, touch, distance)) return false;
  }
  return overlaps;
}

exact::Collider ImpactBodies::ColliderOf(std::uint32_t body, const BodyStates& states) const {
  exact::Collider collider;
  if (IsWall(body)) {
    const auto wall = body - static_cast<std::uint32_t>(bodies_.size());
    collider.plane.normal = (wall % 2 == 0 ? 1 : -1) * Vector3d::Unit(wall / 2);
    collider.plane.offset = -engine_.side() / 2;
    return collider;
  }
  collider.solid = &SolidOf(body);
  collider.motion = {world::ToPose(states[body].pose),
                     timestep_ * world::ToEigen(states[body].velocity),
                     timestep_ * world::ToEigen(states[body].spin)};
  return collider;
}

ImpactBody ImpactBodies::StateOf(std::uint32_t body, const BodyStates& states) const {
  ImpactBody result;
  if (IsWall(body)) return result;
  const BodyState& state = states[body];
  result.centre = world::ToEigen(state.pose.getOrigin());
  result.velocity = world::ToEigen(state.velocity);
  result.spin = world::ToEigen(state.spin);
  if (!IsFree(body)) return result;
  result.inverse_mass = 1 / bodies_[body].mass;
  const Eigen::Matrix3d turn = world::ToEigen(state.pose.getBasis());
  result.inverse_inertia =
      turn * bodies_[body].inertia.cwiseInverse().asDiagonal() * turn.transpose();
  return result;
}

ImpactBody ImpactBodies::Pulled(std::uint32_t body, const ImpactBody& state) const {
  ImpactBody pulled = state;
  const Vector3d momentum = state.inverse_inertia.inverse() * state.spin;
  pulled.velocity = bodies_[body].damping * state.velocity + timestep_ * engine_.acceleration();
  pulled.spin = bodies_[body].spin_damping *
                (state.spin - timestep_ * state.inverse_inertia * state.spin.cross(momentum));
  return pulled;
}

exact::ImpactCourse ImpactBodies::CourseOf(const ImpactPair& pair, double part, exact::Slip slip,
                                           const BodyStates& states) const {
  const auto body_of = [&](std::uint32_t body) {
    const exact::Collider collider = ColliderOf(body, states);
    exact::ImpactCourse::Body result{collider.solid, collider.motion.At(part)};
    result.velocity = collider.motion.way / timestep_;
    result.spin = collider.motion.turn / timestep_;
    if (!IsFree(body)) return result;
    result.mass = bodies_[body].mass;
    result.inertia = bodies_[body].inertia;
    return result;
  };
  return {body_of(pair.a),
          body_of(pair.b),
          {Friction(pair), Restitution(pair), engine_.acceleration(), slip,
           ColliderOf(pair.b, states).plane}};
}

double ImpactBodies::Momentum(const BodyStates& states) const {
  double momentum = 0, moving = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    momentum += bodies_[i].mass * world::ToEigen(states[i].velocity).norm();
    moving += bodies_[i].mass > 0;
  }
  return momentum * std::max(0.0, 1 - 2 / moving);
}

ImpactBodies::Change ImpactBodies::ChangeOf(const ImpactPair& pair,
                                            std::span<const ImpactBody> from,
                                            std::span<const ImpactBody> to,
                                            const BodyStates& states) const {
  double energy = 0, inverse_mass = 0;
  for (const std::uint32_t object : {pair.a, pair.b}) {
    const std::size_t i = object == pair.a ? 0 : 1;
    if (!IsFree(object)) continue;
    const Body& body = bodies_[object];
    const Eigen::Quaterniond back = world::ToEigen(states[object].pose.getRotation()).conjugate();
    energy += body.mass * (to[i].velocity - from[i].velocity).squaredNorm() +
              body.inertia.dot((back * (to[i].spin - from[i].spin)).cwiseAbs2());
    inverse_mass += 1 / body.mass;
  }
  return {std::sqrt(energy / inverse_mass), inverse_mass};
}

double ImpactBodies::MostApproach(const ImpactPair& pair, const BodyStates& states) const {
  const ImpactBody a = StateOf(pair.a, states), b = StateOf(pair.b, states);
  double most = (a.velocity - b.velocity).norm() + a.spin.norm() * SolidOf(pair.a).OuterRadius();
  if (!IsWall(pair.b)) most += b.spin.norm() * SolidOf(pair.b).OuterRadius();
  return most;
}

std::vector<Vector3d> ImpactBodies::RestingPoints(const ImpactPair& pair, const exact::Touch& touch,
                                                  const BodyStates& states) const {
  std::vector<Vector3d> points;
  const exact::Collider other = ColliderOf(pair.b, states);
  if (!IsRound(pair))
    points = exact::ContactRegion(SolidOf(pair.a), ColliderOf(pair.a, states).motion.from,
                                  other.solid, other.motion.from, touch, kNearlyParallel);
  if (points.empty()) points = {touch.point};
  return points;
}

}  // namespace cdb::probes
