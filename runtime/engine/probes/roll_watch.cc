#include "runtime/engine/probes/roll_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "runtime/engine/world/conversions.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;

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

RollWatch::RollWatch(world::Engine& engine)
    : engine_(engine),
      pull_(static_cast<double>(engine.timestep()) * engine.acceleration()),
      objects_(engine.objects().size()) {
  std::vector<char> linked(objects_.size(), 0);
  engine.links().MarkHeld(linked, 1);
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const layouts::ObjectState& state = engine.initial_state().objects[i];
    const objects::Solid& solid = state.solid;
    const btRigidBody& body = *engine.objects()[i];
    Round& round = objects_[i];
    round.is_ball = solid.IsBall();
    round.is_judged =
        !state.IsFixed() && linked[i] == 0 && body.getLinearDamping() == 0 &&
        body.getAngularDamping() == 0 && !(state.numbers["rolling_friction"] > 0) &&
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
