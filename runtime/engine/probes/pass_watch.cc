#include "runtime/engine/probes/pass_watch.h"

#include <algorithm>
#include <cmath>

#include "library/objects/surface.h"
#include "runtime/engine/probes/press_watch.h"
#include "runtime/engine/world/conversions.h"

namespace cdb::probes {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// Least displacement of an object in a cycle, in its inner radii, at which it can get past a
/// contact.
constexpr double kFastWay = 0.5;
/// Fraction of the least side by which a solid is shrunk, so that a grazing path, or an object that
/// is pushed out at a corner, does not count.
constexpr double kGraze = 0.1, kMiddle = 0.5;
/// Radius of the ball that must not pass either, as a fraction of the inner radius of the object.
constexpr double kInnerPart = 0.5;
constexpr double kTurnStep = 0.1;  ///< rad
constexpr int kMostSteps = 32;

struct Motion {
  objects::Pose from, to;
};

Vector3d InAxesOf(const objects::Pose& pose, const Vector3d& point) {
  return pose.orientation.conjugate() * (point - pose.position);
}

/// Least distance from the origin of the straight path between two points.
double LeastDistance(const Vector3d& from, const Vector3d& to) {
  const Vector3d way = to - from;
  const double square = way.squaredNorm();
  const double at = square > 0 ? std::clamp(-from.dot(way) / square, 0.0, 1.0) : 0;
  return (from + at * way).norm();
}

/// True if the path of a ball, in the solid's axes, meets the moving solid.
bool PathMeets(const objects::Solid& solid, const Motion& centre, const Motion& other,
               double radius) {
  const double turn =
      solid.IsBall() ? 0 : other.from.orientation.angularDistance(other.to.orientation);
  const int steps = std::min(kMostSteps, 1 + static_cast<int>(turn / kTurnStep));
  Vector3d last = InAxesOf(other.from, centre.from.position);
  for (int i = 1; i <= steps; ++i) {
    const double at = static_cast<double>(i) / steps;
    const auto between = [at](const Vector3d& a, const Vector3d& b) {
      return Vector3d(a + at * (b - a));
    };
    const objects::Pose pose{between(other.from.position, other.to.position),
                             other.from.orientation.slerp(at, other.to.orientation)};
    const Vector3d next = InAxesOf(pose, between(centre.from.position, centre.to.position));
    if (MeetsPath(solid, last, next, radius)) return true;
    last = next;
  }
  return false;
}

}  // namespace

PassWatch::PassWatch(const world::Engine& engine) : engine_(engine) {
  for (const layouts::ObjectState& object : engine.initial_state().objects) {
    if (object.solid.IsSurface()) surfaces_.push_back(static_cast<std::uint32_t>(sizes_.size()));
    const double inner = object.solid.InnerRadius(), outer = object.solid.OuterRadius();
    const double least = inner > 0 ? inner : object.solid.LeastHalfExtent();
    sizes_.push_back({inner, outer, kFastWay * least, object.solid.IsBall() ? 0 : outer});
  }
}

std::int32_t PassWatch::After(const BodyStates& before, const BodyStates& now) {
  const std::int32_t left = (entries_.empty() ? 0 : FollowEntries()) + CrossSurfaces(before, now);
  if (!AnyIsFast(before, now)) return left;
  SweepAll(before, now);
  return left + ComparePaths(before);
}

/// For objects whose centre of mass is in their solid; a ring may lie around a spike.
std::int32_t PassWatch::CrossSurfaces(const BodyStates& before, const BodyStates& now) const {
  std::int32_t crossed = 0;
  for (const std::uint32_t surface : surfaces_) {
    const btRigidBody& ground = *engine_.objects()[surface];
    const objects::Pose pose = world::ToPose(ground.getWorldTransform());
    const objects::Compound& compound = *engine_.initial_state().objects[surface].solid.compound;
    for (std::uint32_t i = 0; i < sizes_.size(); ++i) {
      const btRigidBody& body = *engine_.objects()[i];
      if (body.isStaticOrKinematicObject() || !(sizes_[i].inner > 0) ||
          !engine_.MayTouch(i, surface))
        continue;
      const Vector3d from = world::ToEigen(before[i].pose.getOrigin());
      const Vector3d to = world::ToEigen(now[i].pose.getOrigin());
      if (!from.allFinite() || !to.allFinite()) continue;
      crossed += Crosses(compound, InAxesOf(pose, from), InAxesOf(pose, to));
    }
  }
  return crossed;
}

bool PassWatch::IsFast(std::size_t object, const BodyState& before, const BodyState& now) const {
  const Size& size = sizes_[object];
  const auto way = static_cast<double>((now.pose.getOrigin() - before.pose.getOrigin()).length());
  const double turn =
      static_cast<double>(before.spin.length() * engine_.timestep()) * size.turn_radius;
  return way + turn > size.fast_way;
}

bool PassWatch::AnyIsFast(const BodyStates& before, const BodyStates& now) const {
  for (std::size_t i = 0; i < sizes_.size(); ++i)
    if (IsFast(i, before[i], now[i])) return true;
  return false;
}

void PassWatch::SweepAll(const BodyStates& before, const BodyStates& now) {
  swept_.clear();
  for (std::uint32_t i = 0; i < sizes_.size(); ++i) {
    const Vector3d from = world::ToEigen(before[i].pose.getOrigin());
    const Vector3d to = world::ToEigen(now[i].pose.getOrigin());
    if (!from.allFinite() || !to.allFinite()) continue;
    const double outer = sizes_[i].outer;
    swept_.push_back({from.cwiseMin(to).array() - outer, from.cwiseMax(to).array() + outer, i,
                      IsFast(i, before[i], now[i])});
  }
}

std::int32_t PassWatch::ComparePaths(const BodyStates& before) {
  Vector3d sum = Vector3d::Zero(), squares = Vector3d::Zero();
  for (const Swept& swept : swept_) {
    sum += swept.lower;
    squares += swept.lower.cwiseAbs2();
  }
  int axis = 0;
  (squares - sum.cwiseAbs2() / static_cast<double>(swept_.size())).maxCoeff(&axis);
  std::ranges::sort(swept_, {}, [axis](const Swept& swept) { return swept.lower[axis]; });
  std::int32_t passed = 0;
  for (auto a = swept_.begin(); a != swept_.end(); ++a) {
    for (auto b = a + 1; b != swept_.end() && b->lower[axis] <= a->upper[axis]; ++b) {
      if (!(a->is_fast || b->is_fast) || (a->lower.array() > b->upper.array()).any() ||
          (b->lower.array() > a->upper.array()).any())
        continue;
      passed += Passed(before, a->object, b->object) || Passed(before, b->object, a->object);
    }
  }
  return passed;
}

/// Records a centre that ends inside the other solid.
bool PassWatch::Passed(const BodyStates& before, std::uint32_t object, std::uint32_t other) {
  if (!(sizes_[object].inner > 0) || !engine_.MayTouch(object, other)) return false;
  const auto& solids = engine_.initial_state().objects;
  const btRigidBody &body = *engine_.objects()[object], &through = *engine_.objects()[other];
  if (solids[object].solid.IsSurface() || solids[other].solid.IsSurface()) return false;
  if (body.isStaticOrKinematicObject() && through.isStaticOrKinematicObject()) return false;
  const auto origin = [](const btTransform& pose) { return world::ToEigen(pose.getOrigin()); };
  if (LeastDistance(origin(before[object].pose) - origin(before[other].pose),
                    origin(body.getWorldTransform()) - origin(through.getWorldTransform())) >
      sizes_[other].outer + kInnerPart * sizes_[object].inner)
    return false;
  if (!body.checkCollideWith(&through)) return false;
  const objects::Solid& solid = engine_.initial_state().objects[other].solid;
  const Motion centre{world::ToPose(before[object].pose), world::ToPose(body.getWorldTransform())};
  const Motion motion{world::ToPose(before[other].pose),
                      world::ToPose(through.getWorldTransform())};
  const Vector3d from = InAxesOf(motion.from, centre.from.position);
  const Vector3d to = InAxesOf(motion.to, centre.to.position);
  if (Contains(solid, from)) return false;
  if (Contains(solid, to)) {
    entries_.push_back({object, other, from});
    return false;
  }
  if (PathMeets(CoreOf(solid, kGraze), centre, motion, 0)) return true;
  const double radius = kInnerPart * sizes_[object].inner;
  return !MeetsPath(solid, from, from, radius) && !MeetsPath(solid, to, to, radius) &&
         PathMeets(solid, centre, motion, radius);
}

/// Counts the objects that have left a solid that they were inside, on a path through its middle.
std::int32_t PassWatch::FollowEntries() {
  std::int32_t passed = 0;
  std::erase_if(entries_, [&](const Entry& entry) {
    const objects::Pose pose = world::ToPose(engine_.objects()[entry.other]->getWorldTransform());
    const Vector3d at = InAxesOf(
        pose, world::ToEigen(engine_.objects()[entry.object]->getWorldTransform().getOrigin()));
    const objects::Solid& solid = engine_.initial_state().objects[entry.other].solid;
    if (!at.allFinite()) return true;
    if (Contains(solid, at)) return false;
    passed += MeetsPath(CoreOf(solid, kMiddle), entry.entry, at);
    return true;
  });
  return passed;
}

}  // namespace cdb::probes
