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

double SpinAngle(const btRigidBody& body, double timestep) {
  return timestep * static_cast<double>(body.getAngularVelocity().length());
}

}  // namespace

PassWatch::PassWatch(const world::Engine& engine)
    : engine_(engine), paths_(engine.objects().size()), passed_(engine.objects().size(), 0) {
  for (std::uint32_t i = 0; i < passed_.size(); ++i) {
    const objects::Solid& solid = engine.initial_state().objects[i].solid;
    if (solid.IsSurface()) surfaces_.push_back(i);
    const objects::Box box = objects::Bounds(solid, Eigen::Quaterniond::Identity());
    const double outer = solid.OuterRadius();
    sizes_.push_back({box.upper.cwiseMax(-box.lower), outer, solid.IsBall() ? 0 : outer,
                      2 * solid.LeastHalfExtent()});
  }
}

PassWatch::Seen PassWatch::After(const BodyStates& before, const BodyStates& now) {
  ++cycle_;
  unfollowed_ = 0;
  meetings_.clear();
  CrossSurfaces(before, now);
  if (ReadPaths(before, now) || !overlaps_.empty()) {
    MeetWalls(before, now);
    SortPaths();
    ComparePaths(before, now);
    std::erase_if(overlaps_, [&](const auto& pair) {
      return pair.second.cycle != cycle_ || !pair.second.passage.Overlaps();
    });
  }
  return {static_cast<std::int32_t>(std::ranges::count(passed_, 1)), unfollowed_};
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
      const Vector3d place = InAxesOf(pose, to);
      if (Crosses(compound, InAxesOf(pose, from), place) || compound.IsInCells(place))
        passed_[i] = 1;
    }
  }
}

/// Returns true if any two objects moved far enough to meet unseen.
bool PassWatch::ReadPaths(const BodyStates& before, const BodyStates& now) {
  ends_.clear();
  double most = 0;
  for (std::uint32_t i = 0; i < passed_.size(); ++i) {
    if (engine_.initial_state().objects[i].solid.IsSurface()) continue;
    paths_[i] = PathOf(i, before[i], now[i]);
    if (!paths_[i].lower.allFinite() || !paths_[i].upper.allFinite()) continue;
    most = std::max(most, paths_[i].most);
    ends_.push_back({0, i});
  }
  return std::ranges::any_of(ends_, [&](const End& end) {
    return paths_[end.object].most + most >= kMeets * sizes_[end.object].side;
  });
}

PassWatch::Path PassWatch::PathOf(std::uint32_t object, const BodyState& before,
                                  const BodyState& now) const {
  const Size& size = sizes_[object];
  const btRigidBody& body = *engine_.objects()[object];
  const Vector3d from = world::ToEigen(before.pose.getOrigin()),
                 to = world::ToEigen(now.pose.getOrigin());
  Path path{from.cwiseMin(to), from.cwiseMax(to), (to - from).norm()};
  if (!(size.turn_radius > 0)) {
    path.lower.array() -= size.outer;
    path.upper.array() += size.outer;
    return path;
  }
  Vector3d far_before, far_now;
  double trace = 0;
  for (int row = 0; row < 3; ++row) {
    const Vector3d old = world::ToEigen(before.pose.getBasis()[row]),
                   current = world::ToEigen(now.pose.getBasis()[row]);
    far_before[row] = old.cwiseAbs().dot(size.far);
    far_now[row] = current.cwiseAbs().dot(size.far);
    trace += old.dot(current);
  }
  // 2 sin(angle / 2): the way of a point at distance 1 from the axis, as the crow flies.
  const double chord = std::sqrt(std::clamp(3 - trace, 0.0, 4.0));
  // A point that turns strays from its chord.
  double angle = chord * std::numbers::pi / 2,
         stray = size.turn_radius * (1 - std::sqrt(1 - chord * chord / 4));
  if (body.isKinematicObject()) {
    angle = SpinAngle(body, engine_.timestep());
    stray = angle > 0 ? 2 * size.outer : 0;
  }
  const Vector3d far = far_before.cwiseMax(far_now).array() + stray;
  path.most += angle * size.turn_radius;
  path.lower -= far;
  path.upper += far;
  return path;
}

void PassWatch::MeetWalls(const BodyStates& before, const BodyStates& now) {
  const double half = engine_.side() / 2;
  for (const auto& wall : engine_.walls()) {
    const auto body = static_cast<std::uint32_t>(wall->getUserIndex());
    const auto index = body - static_cast<std::uint32_t>(passed_.size());
    for (const End& end : ends_) {
      const std::uint32_t i = end.object;
      const Path& path = paths_[i];
      const double beyond =
          index % 2 == 0 ? -half - path.lower[index / 2] : path.upper[index / 2] - half;
      if (beyond > 0 && sizes_[i].turn_radius > 0 && path.most >= kMeets * sizes_[i].side &&
          !engine_.objects()[i]->isStaticOrKinematicObject() && engine_.MayTouchWalls(i))
        meetings_.push_back({i, body, MotionOf(i, before, now), {}});
    }
  }
}

void PassWatch::SortPaths() {
  Vector3d sum = Vector3d::Zero(), squares = Vector3d::Zero();
  for (const End& end : ends_) {
    const Vector3d& lower = paths_[end.object].lower;
    sum += lower;
    squares += lower.cwiseAbs2();
  }
  (squares - sum.cwiseAbs2() / static_cast<double>(ends_.size())).maxCoeff(&axis_);
  for (End& end : ends_) end.lower = paths_[end.object].lower[axis_];
  std::ranges::sort(ends_, {}, &End::lower);
}

void PassWatch::ComparePaths(const BodyStates& before, const BodyStates& now) {
  for (auto first = ends_.begin(); first != ends_.end(); ++first) {
    const std::uint32_t i = first->object;
    const Path& a = paths_[i];
    for (auto second = first + 1; second != ends_.end() && second->lower <= a.upper[axis_];
         ++second) {
      const std::uint32_t j = second->object;
      const Path& b = paths_[j];
      if ((a.lower.array() <= b.upper.array()).all() && (b.lower.array() <= a.upper.array()).all())
        Follow(std::min(i, j), std::max(i, j), before, now);
    }
  }
}

void PassWatch::Follow(std::uint32_t first, std::uint32_t second, const BodyStates& before,
                       const BodyStates& now) {
  const double side = std::min(sizes_[first].side, sizes_[second].side),
               most = paths_[first].most + paths_[second].most;
  const auto found = overlaps_.empty() ? overlaps_.end() : overlaps_.find(std::pair(first, second));
  const bool overlapped = found != overlaps_.end();
  if (!overlapped && (most < kMeets * side || !MayCollide(first, second))) return;
  const auto& states = engine_.initial_state().objects;
  const objects::Solid &solid = states[first].solid, &other = states[second].solid;
  const exact::Motion motion = MotionOf(first, before, now),
                      other_motion = MotionOf(second, before, now);
  if (!overlapped && MayMeet(solid, motion, other, other_motion))
    meetings_.push_back({first, second, motion, other_motion});
  if (passed_[Passer(first, second)] || (!overlapped && most < exact::Passage::kLeastMotion * side))
    return;
  exact::Passage passage = overlapped ? found->second.passage : exact::Passage();
  const exact::Passing passing = passage.Follow(solid, motion, other, other_motion);
  if (passing == exact::Passing::kPassed) passed_[Passer(first, second)] = 1;
  unfollowed_ += passing == exact::Passing::kUnknown;
  if (passage.Overlaps())
    overlaps_.insert_or_assign(std::pair(first, second), Pair{passage, cycle_});
}

exact::Motion PassWatch::MotionOf(std::uint32_t object, const BodyStates& before,
                                  const BodyStates& now) const {
  const objects::Pose from = world::ToPose(before[object].pose),
                      to = world::ToPose(now[object].pose);
  return {from, to.position - from.position,
          sizes_[object].turn_radius > 0
              ? TurnOf(*engine_.objects()[object], from, to, engine_.timestep())
              : Vector3d::Zero()};
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
