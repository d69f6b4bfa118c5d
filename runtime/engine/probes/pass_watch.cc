#include "runtime/engine/probes/pass_watch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "library/objects/surface.h"
#include "runtime/engine/world/conversions.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;

Vector3d InAxesOf(const objects::Pose& pose, const Vector3d& point) {
  return pose.orientation.conjugate() * (point - pose.position);
}

/// rad. The spin of a kinematic object counts, as poses do not determine turns by more than a half.
Vector3d TurnOf(const btRigidBody& body, const objects::Pose& from, const objects::Pose& to,
                double timestep) {
  if (body.isKinematicObject()) return timestep * world::ToEigen(body.getAngularVelocity());
  Eigen::Quaterniond turn = to.orientation * from.orientation.conjugate();
  if (turn.w() < 0) turn.coeffs() *= -1;
  const double sine = turn.vec().norm();
  return sine > 0 ? Vector3d(2 * std::atan2(sine, turn.w()) / sine * turn.vec()) : Vector3d::Zero();
}

/// From the centre of mass.
objects::Box BoxOf(const objects::Solid& solid, const Eigen::Quaterniond& turn) {
  if (!solid.compound && !solid.IsBall()) return objects::Bounds(solid, turn);
  const Vector3d outer = Vector3d::Constant(solid.OuterRadius());
  return {-outer, outer};
}

}  // namespace

PassWatch::PassWatch(const world::Engine& engine)
    : engine_(engine), passed_(engine.objects().size(), 0) {
  for (std::uint32_t i = 0; i < passed_.size(); ++i)
    if (engine.initial_state().objects[i].solid.IsSurface()) surfaces_.push_back(i);
}

std::int32_t PassWatch::After(const BodyStates& before, const BodyStates& now) {
  ++cycle_;
  std::ranges::fill(passed_, 0);
  CrossSurfaces(before, now);
  paths_.clear();
  bool any_moves = false;
  for (std::uint32_t i = 0; i < passed_.size(); ++i) {
    if (engine_.initial_state().objects[i].solid.IsSurface()) continue;
    const Path path = PathOf(i, before, now);
    if (!path.lower.allFinite() || !path.upper.allFinite()) continue;
    any_moves = any_moves || path.moves;
    paths_.push_back(path);
  }
  if (any_moves) {
    SortPaths();
    ComparePaths();
    std::erase_if(pairs_, [&](const auto& pair) { return pair.second.cycle != cycle_; });
  }
  return static_cast<std::int32_t>(std::ranges::count(passed_, 1));
}

/// For objects whose centre of mass is in their solid; a ring may lie around a spike.
void PassWatch::CrossSurfaces(const BodyStates& before, const BodyStates& now) {
  for (const std::uint32_t surface : surfaces_) {
    const btRigidBody& ground = *engine_.objects()[surface];
    const objects::Pose pose = world::ToPose(ground.getWorldTransform());
    const objects::Compound& compound = *engine_.initial_state().objects[surface].solid.compound;
    for (std::uint32_t i = 0; i < passed_.size(); ++i) {
      const btRigidBody& body = *engine_.objects()[i];
      if (body.isStaticOrKinematicObject() ||
          !(engine_.initial_state().objects[i].solid.InnerRadius() > 0) ||
          !engine_.MayTouch(i, surface))
        continue;
      const Vector3d from = world::ToEigen(before[i].pose.getOrigin());
      const Vector3d to = world::ToEigen(now[i].pose.getOrigin());
      if (!from.allFinite() || !to.allFinite()) continue;
      if (Crosses(compound, InAxesOf(pose, from), InAxesOf(pose, to))) passed_[i] = 1;
    }
  }
}

PassWatch::Path PassWatch::PathOf(std::uint32_t object, const BodyStates& before,
                                  const BodyStates& now) const {
  const objects::Solid& solid = engine_.initial_state().objects[object].solid;
  const objects::Pose from = world::ToPose(before[object].pose),
                      to = world::ToPose(now[object].pose);
  Path path{{from, to.position - from.position,
             TurnOf(*engine_.objects()[object], from, to, engine_.timestep())},
            {},
            {},
            object,
            false};
  const double angle = solid.IsBall() ? 0 : path.motion.turn.norm();
  path.moves = path.motion.way.squaredNorm() > 0 || angle > 0;
  const objects::Box first = BoxOf(solid, from.orientation),
                     last = path.moves ? BoxOf(solid, to.orientation) : first;
  // A point that turns strays from its chord.
  const double stray =
      solid.OuterRadius() * (angle < std::numbers::pi ? 1 - std::cos(angle / 2) : 2);
  path.lower = (from.position + first.lower).cwiseMin(to.position + last.lower).array() - stray;
  path.upper = (from.position + first.upper).cwiseMax(to.position + last.upper).array() + stray;
  return path;
}

void PassWatch::SortPaths() {
  Vector3d sum = Vector3d::Zero(), squares = Vector3d::Zero();
  for (const Path& path : paths_) {
    sum += path.lower;
    squares += path.lower.cwiseAbs2();
  }
  int axis = 0;
  (squares - sum.cwiseAbs2() / static_cast<double>(paths_.size())).maxCoeff(&axis);
  axis_ = axis;
  std::ranges::sort(paths_, {}, [axis](const Path& path) { return path.lower[axis]; });
}

void PassWatch::ComparePaths() {
  for (auto a = paths_.begin(); a != paths_.end(); ++a)
    for (auto b = a + 1; b != paths_.end() && b->lower[axis_] <= a->upper[axis_]; ++b)
      if ((a->lower.array() <= b->upper.array()).all() &&
          (b->lower.array() <= a->upper.array()).all())
        a->object < b->object ? Follow(*a, *b) : Follow(*b, *a);
}

void PassWatch::Follow(const Path& first, const Path& second) {
  const std::uint32_t i = first.object, j = second.object;
  const auto [found, is_new] = pairs_.try_emplace(std::uint64_t{i} << 32 | j);
  Pair& pair = found->second;
  pair.cycle = cycle_;
  if (is_new) pair.collide = MayCollide(i, j);
  if (!pair.collide) return;
  const auto& states = engine_.initial_state().objects;
  if (pair.passage.Follow(states[i].solid, first.motion, states[j].solid, second.motion))
    passed_[Passer(i, j)] = 1;
}

bool PassWatch::MayCollide(std::uint32_t object, std::uint32_t other) const {
  const btRigidBody &a = *engine_.objects()[object], &b = *engine_.objects()[other];
  return !(a.isStaticOrKinematicObject() && b.isStaticOrKinematicObject()) &&
         engine_.MayTouch(object, other) && a.checkCollideWith(&b);
}

std::uint32_t PassWatch::Passer(std::uint32_t object, std::uint32_t other) const {
  const auto rank = [&](std::uint32_t i) {
    return std::pair(engine_.objects()[i]->isStaticOrKinematicObject(),
                     engine_.initial_state().objects[i].solid.OuterRadius());
  };
  return rank(other) < rank(object) ? other : object;
}

}  // namespace cdb::probes
