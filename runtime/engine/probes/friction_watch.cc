#include "runtime/engine/probes/friction_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;

/// Of an object's least half extent: how far a face reaches around the centre of mass.
constexpr double kFace = 0.1;
constexpr int kFaceDirections = 8;
/// rad, in the body's axes: a face is looked for again from here on.
constexpr double kLookAgain = 1e-3;
/// rad: an object that turned by more is twisted.
constexpr double kTwisted = 0.1;
/// Of the speed along the ground: an object whose surface moves faster by its spin is not sliding
/// along a line.
constexpr double kSpins = 0.1;
/// Of an object's least side: the fall whose speed is the least change by friction that counts.
constexpr double kLeastChangeFall = 0.1;

/// Of sqrt(g S), with an object's least side S: a speed. What must rest has at most 0.02 of it
/// late.
constexpr double kLeastSpeed = 0.5;

/// The normal of the face of a wall or a cuboid that a contact has about this normal.
std::optional<Vector3d> FaceNormal(const btCollisionObject& ground, const btVector3& normal) {
  const Eigen::Matrix3d axes = world::ToEigen(ground.getWorldTransform().getBasis());
  const Vector3d inside = axes.transpose() * world::ToEigen(normal);
  int axis = 0;
  const double along = inside.cwiseAbs().maxCoeff(&axis);
  if (along < std::cos(kSameNormal) * inside.norm()) return std::nullopt;
  return Vector3d(std::copysign(1, inside[axis]) * axes.col(axis));
}

}  // namespace

Supports::Supports(world::Engine& engine)
    : engine_(engine),
      has_ground_(!engine.walls().empty() ||
                  std::ranges::any_of(engine.initial_state().objects,
                                      [](const layouts::ObjectState& object) {
                                        return object.IsFixed() && !object.is_kinematic;
                                      })),
      supports_(engine.objects().size()) {}

void Supports::Find() {
  if (!has_ground_) return;
  std::ranges::fill(supports_, Support{});
  const auto add = [&](const btCollisionObject& body, const btCollisionObject& other,
                       const btVector3& normal) {
    const auto index = static_cast<std::size_t>(body.getUserIndex());
    if (index >= supports_.size()) return;
    Support& support = supports_[index];
    if (support.ground == nullptr) {
      support = {&other, normal};
    } else if (support.ground != &other || support.normal.dot(normal) < std::cos(kSameNormal)) {
      support.is_single = false;
    }
  };
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world())) {
    const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
    for (int j = 0; j < manifold.getNumContacts(); ++j) {
      const btManifoldPoint& point = manifold.getContactPoint(j);
      if (!world::HasImpulse(manifold, point)) continue;
      add(a, b, point.m_normalWorldOnB);
      add(b, a, -point.m_normalWorldOnB);
    }
  }
}

FrictionWatch::FrictionWatch(world::Engine& engine, const world::Coefficients& coefficients)
    : engine_(engine), coefficients_(coefficients), objects_(engine.objects().size()) {
  const double pull = engine.acceleration().norm();
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const layouts::ObjectState& state = engine.initial_state().objects[i];
    objects_[i].is_judged = !state.IsFixed() && !engine.links().Holds(i) &&
                            !engine.pushes().IsPushed(i) && !state.solid.IsBall();
    objects_[i].damping = std::pow(1 - static_cast<double>(engine.objects()[i]->getLinearDamping()),
                                   static_cast<double>(engine.timestep()));
    objects_[i].least_due =
        std::sqrt(2 * pull * kLeastChangeFall * 2 * state.solid.LeastHalfExtent());
  }
}

FrictionWatch::Seen FrictionWatch::After(const BodyStates& before, const BodyStates& now,
                                         const Supports& supports) {
  Seen seen = {0, 0, std::numeric_limits<double>::quiet_NaN()};
  if (!supports.has_ground()) return seen;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    Moving& object = objects_[i];
    if (!object.is_judged) continue;
    if (now[i].is_asleep) {
      object.is_flat = false;
    } else {
      Judge(i, before[i], now[i], supports.Of(i));
    }
    const double turned = std::abs(object.turned + object.FalseTurn());
    object.is_twisted = object.is_twisted || turned > kTwisted;
    seen.twisted += object.is_twisted;
    seen.false_turn = std::max(seen.false_turn, turned);
    if (object.due > object.least_due)
      seen.friction_error = std::fmax(seen.friction_error, object.error.norm() / object.due);
  }
  return seen;
}

void FrictionWatch::Judge(std::size_t object, const BodyState& before, const BodyState& now,
                          const Support& support) {
  Moving& moving = objects_[object];
  const bool was_flat = moving.is_flat;
  if (support.ground != nullptr) {
    const auto ground = static_cast<std::size_t>(support.ground->getUserIndex());
    moving.is_flat =
        support.is_single && support.ground->isStaticObject() &&
        (ground >= objects_.size() || !engine_.initial_state().objects[ground].solid.IsSurface());
    moving.normal = world::ToEigen(support.normal).normalized();
    moving.friction = coefficients_.Friction(object, ground);
  }
  const Eigen::Quaterniond turn = world::ToEigen(before.pose.getRotation());
  moving.is_flat = moving.is_flat && LiesFlat(object, turn);
  if (!moving.is_flat) return;

  const Vector3d& normal = moving.normal;
  const double timestep = static_cast<double>(engine_.timestep());
  const auto split = [&](const btVector3& vector) {
    const Vector3d all = world::ToEigen(vector);
    const double along = all.dot(normal);
    return std::pair(along, Vector3d(all - along * normal));
  };
  const auto [first_spin, first_rocking] = split(before.spin);
  const Vector3d in_body = turn.conjugate() * normal;
  if (!was_flat) {
    moving.turned += moving.FalseTurn();
    moving.turns = 0;
    moving.least_spin = std::abs(first_spin);
    moving.first_rocking = first_rocking.norm();
    moving.first_normal = in_body;
  }
  const double spin = split(now.spin).first;
  const layouts::ObjectState& state = engine_.initial_state().objects[object];
  const Vector3d inertia = state.solid.InertiaPerMass();
  const double lever = moving.friction * inertia.maxCoeff() / inertia.dot(in_body.cwiseAbs2());
  const double allowed = moving.least_spin + lever * moving.first_rocking;
  moving.turns += timestep * std::copysign(std::max(0.0, std::abs(spin) - allowed), spin);
  moving.excused = lever * (in_body - moving.first_normal).norm();
  moving.least_spin = std::min(moving.least_spin, std::abs(spin));

  const Vector3d pulled =
      moving.damping * world::ToEigen(before.velocity) + timestep * engine_.acceleration();
  const Vector3d velocity = world::ToEigen(now.velocity);
  const Vector3d across = pulled - pulled.dot(normal) * normal;
  const double speed = across.norm();
  const double fastest_spin =
      std::max(world::ToEigen(before.spin).norm(), world::ToEigen(now.spin).norm());
  if (!(speed > 0) || fastest_spin * state.solid.OuterRadius() > kSpins * speed) return;
  const double due = std::clamp(moving.friction * (velocity - pulled).dot(normal), 0.0, speed);
  moving.error += velocity - velocity.dot(normal) * normal - (1 - due / speed) * across;
  moving.due += due;
}

double FrictionWatch::Moving::FalseTurn() const {
  return std::copysign(std::max(0.0, std::abs(turns) - excused), turns);
}

bool FrictionWatch::LiesFlat(std::size_t object, const Eigen::Quaterniond& turn) {
  Moving& moving = objects_[object];
  const Vector3d normal = turn.conjugate() * moving.normal;
  if ((normal - moving.face_normal).norm() < kLookAgain) return moving.has_face;
  moving.face_normal = normal;
  const objects::Solid& solid = engine_.initial_state().objects[object].solid;
  const Vector3d across = normal.unitOrthogonal();
  Vector3d directions[kFaceDirections];
  double reaches[kFaceDirections] = {};
  for (int i = 0; i < kFaceDirections; ++i)
    directions[i] = Eigen::AngleAxisd(2 * M_PI * i / kFaceDirections, normal) * across;
  for (const Vector3d& direction : directions) {
    const Vector3d corner = solid.Support(kSameNormal * direction - normal);
    for (int i = 0; i < kFaceDirections; ++i)
      reaches[i] = std::max(reaches[i], directions[i].dot(corner));
  }
  moving.has_face = *std::ranges::min_element(reaches) > kFace * solid.LeastHalfExtent();
  return moving.has_face;
}

RollWatch::RollWatch(world::Engine& engine)
    : engine_(engine),
      pull_(static_cast<double>(engine.timestep()) * engine.acceleration()),
      objects_(engine.objects().size()) {
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const layouts::ObjectState& state = engine.initial_state().objects[i];
    const objects::Solid& solid = state.solid;
    const btRigidBody& body = *engine.objects()[i];
    Round& round = objects_[i];
    round.is_ball = solid.IsBall();
    round.is_judged =
        !state.IsFixed() && !engine.links().Holds(i) && !engine.pushes().IsPushed(i) &&
        body.getLinearDamping() == 0 && body.getAngularDamping() == 0 &&
        !(state.numbers["rolling_friction"] > 0) &&
        (round.is_ball || solid.IsRoundCapsule() ||
         (solid.shape == objects::Shape::kCylinder && solid.sides.x() == solid.sides.z()));
    round.radius = solid.sides.x() / 2;
    round.gyration = solid.InertiaPerMass().y();
    round.least_speed =
        kLeastSpeed * std::sqrt(engine.acceleration().norm() * 2 * solid.LeastHalfExtent());
  }
}

double RollWatch::After(const BodyStates& before, const BodyStates& now, const Supports& supports) {
  double largest = std::numeric_limits<double>::quiet_NaN();
  if (!supports.has_ground()) return largest;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    Round& round = objects_[i];
    if (!round.is_judged) continue;
    if (!now[i].is_asleep) Judge(round, before[i], now[i], supports.Of(i));
    if (round.has_rolled)
      largest = std::fmax(largest, round.error.norm() / std::max(round.fastest, round.least_speed));
  }
  return largest;
}

void RollWatch::Judge(Round& round, const BodyState& before, const BodyState& now,
                      const Support& support) {
  if (support.ground == nullptr || !support.is_single || !support.ground->isStaticObject()) return;
  const auto index = static_cast<std::size_t>(support.ground->getUserIndex());
  if (index < objects_.size()) {
    const layouts::ObjectState& ground = engine_.initial_state().objects[index];
    if (ground.solid.shape != objects::Shape::kCuboid || ground.numbers["rolling_friction"] > 0)
      return;
  }
  const std::optional<Vector3d> normal = FaceNormal(*support.ground, support.normal);
  if (!normal) return;

  // Divided by m r, along the ground: a vector, of which a cylinder has that across its axis.
  Vector3d direction = Vector3d::Zero();
  const auto axis_of = [](const BodyState& state) {
    return world::ToEigen(state.pose.getBasis().getColumn(1));
  };
  if (!round.is_ball) {
    const Vector3d first = axis_of(before), last = axis_of(now);
    if (std::max(std::abs(first.dot(*normal)), std::abs(last.dot(*normal))) > kSameNormal) return;
    direction = (first + last).cross(*normal).normalized();
  }
  const double lever = round.gyration / round.radius;
  const auto momentum = [&](const BodyState& state) -> Vector3d {
    const Vector3d velocity = world::ToEigen(state.velocity), spin = world::ToEigen(state.spin);
    if (round.is_ball)
      return velocity - velocity.dot(*normal) * *normal + lever * spin.cross(*normal);
    return (velocity.dot(direction) + lever * spin.dot(axis_of(state))) * direction;
  };
  const Vector3d pulled = round.is_ball ? Vector3d(pull_ - pull_.dot(*normal) * *normal)
                                        : Vector3d(pull_.dot(direction) * direction);
  round.error += (momentum(now) - momentum(before) - pulled) / (1 + lever / round.radius);
  round.fastest = std::max(round.fastest, world::ToEigen(before.velocity).norm());
  round.has_rolled = true;
}

}  // namespace cdb::probes
