#include "runtime/engine/probes/probes.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;
using Wrench = SleepWatch::Wrench;

/// Limits of the residual weight, in weights: with normal forces only, beyond it the ground slopes;
/// with friction, beyond it the object slides; with forces and torques, beyond it the object rolls.
constexpr double kSlopes = 0.005, kSlides = 0.005, kRolls = 0.0035;
/// With forces and torques, for an object that hardly moved or lies on level ground, as contacts
/// are not exact: beyond it the object tips over.
constexpr double kTips = 0.03;
/// For a ball on walls, boxes and balls, whose normals are exact: beyond it the ball rolls.
constexpr double kExactSlope = 2e-4;
/// In sqrt(g S), and in g dt, which a resting object has while Bullet's contacts let it fall: a
/// slower object rests.
constexpr double kRests = 0.005, kTrembles = 1.1;
/// In least sides and radians a second: without gravity, a slower object rests.
constexpr double kDrifts = 1e-3;
constexpr int kDirections = 8;  ///< edges of a friction cone

/// The part of `weight` that no non-negative combination of the columns balances. Source: Lawson &
/// Hanson, Solving Least Squares Problems, 1974, algorithm NNLS.
double Residual(const std::vector<Wrench>& columns, const Wrench& weight, int rows) {
  const auto count = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd all(rows, count);
  for (Eigen::Index i = 0; i < count; ++i)
    all.col(i) = columns[static_cast<std::size_t>(i)].head(rows).normalized();
  Eigen::VectorXd rest = weight.head(rows), parts;
  std::vector<Eigen::Index> used;
  for (Eigen::Index step = 0; step < 3 * count; ++step) {
    Eigen::Index next = 0;
    if (!((all.transpose() * rest).maxCoeff(&next) > 1e-9)) break;
    if (std::ranges::find(used, next) != used.end()) break;  // by rounding
    used.push_back(next);
    parts.conservativeResize(std::ssize(used));
    parts[std::ssize(used) - 1] = 0;
    while (!used.empty()) {
      const Eigen::MatrixXd some = all(Eigen::all, used);
      const Eigen::VectorXd best = some.colPivHouseholderQr().solve(weight.head(rows).eval());
      // Up to where the first part would be negative, which is then left out.
      double way = 1;
      Eigen::Index first = -1;
      for (Eigen::Index i = 0; i < best.size(); ++i)
        if (best[i] <= 0 && parts[i] / (parts[i] - best[i]) < way)
          way = parts[i] / (parts[i] - best[i]), first = i;
      parts += way * (best - parts);
      if (first < 0) break;
      used.erase(used.begin() + first);
      for (Eigen::Index i = first; i + 1 < parts.size(); ++i) parts[i] = parts[i + 1];
      parts.conservativeResize(parts.size() - 1);
    }
    rest = weight.head(rows) - all(Eigen::all, used) * parts;
  }
  return rest.norm();
}

/// `normal` points towards the object. One edge of the friction cone points up the slope.
void AddPoint(const Vector3d& normal, const Vector3d& arm, double friction, const Vector3d& up,
              SleepWatch::Support& support) {
  const auto add = [&](const Vector3d& force, std::vector<Wrench>& columns) {
    Wrench column;
    column << force, arm.cross(force);
    columns.push_back(column);
  };
  add(normal, support.normals);
  add(normal, support.cones);
  const Vector3d uphill = up - up.dot(normal) * normal;
  const Vector3d side = uphill.norm() > 1e-6 ? uphill.normalized() : normal.unitOrthogonal();
  const Vector3d other = normal.cross(side);
  for (int i = 0; i < kDirections && friction > 0; ++i) {
    const double angle = 2 * std::numbers::pi * i / kDirections;
    add(normal + friction * (std::cos(angle) * side + std::sin(angle) * other), support.cones);
  }
}

}  // namespace

SleepWatch::SleepWatch(world::Engine& engine)
    : engine_(engine), unheld_(engine.objects().size(), 0) {}

std::int32_t SleepWatch::After(const BodyStates& before, const BodyStates& now) {
  supports_.clear();
  for (std::size_t i = 0; i < unheld_.size(); ++i) {
    if (!now[i].is_asleep)
      unheld_[i] = 0;
    else if ((!before[i].is_asleep || is_first_) && !engine_.links().Holds(i))
      supports_.try_emplace(i);
  }
  is_first_ = false;
  if (!supports_.empty()) {
    CollectSupports();
    for (const auto& [object, support] : supports_)
      unheld_[object] = !IsHeld(object, before[object], support);
  }
  return static_cast<std::int32_t>(std::ranges::count(unheld_, 1));
}

void SleepWatch::CollectSupports() {
  const Vector3d up = -engine_.acceleration().normalized();
  const auto is_exact = [&](const btCollisionObject& body) {
    const auto index = static_cast<std::size_t>(body.getUserIndex());
    if (index >= unheld_.size()) return true;
    const objects::Solid& solid = engine_.initial_state().objects[index].solid;
    return solid.IsBall() || solid.shape == objects::Shape::kCuboid;
  };
  const auto add = [&](const btPersistentManifold& manifold, const btCollisionObject* body,
                       const btCollisionObject* other, double sign) {
    const auto found = supports_.find(static_cast<std::size_t>(body->getUserIndex()));
    if (found == supports_.end()) return;
    found->second.is_exact = found->second.is_exact && is_exact(*other);
    const Vector3d origin = world::ToEigen(body->getWorldTransform().getOrigin());
    const double half = HalfOf(found->first);
    for (int j = 0; j < manifold.getNumContacts(); ++j) {
      const btManifoldPoint& point = manifold.getContactPoint(j);
      AddPoint(sign * world::ToEigen(point.m_normalWorldOnB),
               (world::ToEigen(point.getPositionWorldOnB()) - origin) / half,
               static_cast<double>(point.m_combinedFriction), up, found->second);
    }
  };
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world())) {
    add(manifold, manifold.getBody0(), manifold.getBody1(), 1);
    add(manifold, manifold.getBody1(), manifold.getBody0(), -1);
  }
}

double SleepWatch::HalfOf(std::size_t object) const {
  return engine_.initial_state().objects[object].solid.LeastHalfExtent();
}

bool SleepWatch::IsHeld(std::size_t object, const BodyState& before, const Support& support) const {
  const double pull = engine_.acceleration().norm();
  const layouts::ObjectState& state = engine_.initial_state().objects[object];
  const Vector3d velocity = world::ToEigen(before.velocity);
  const double spin = world::ToEigen(before.spin).norm();
  if (!(pull > 0))
    return !support.normals.empty() ||
           (velocity.norm() < kDrifts * 2 * HalfOf(object) && spin < kDrifts);
  // A resting object may have the speed of one step's fall.
  const double tremble = kTrembles * pull * static_cast<double>(engine_.timestep());
  const double falling = velocity.dot(engine_.acceleration()) / pull;
  const Vector3d across = velocity - falling * engine_.acceleration() / pull;
  const double speed = falling >= 0 && falling < tremble ? across.norm() : velocity.norm();
  const bool fell_asleep_unseen = before.is_asleep;
  if (support.normals.empty()) return !fell_asleep_unseen && velocity.norm() < tremble;
  Wrench weight = Wrench::Zero();
  weight.head<3>() = -engine_.acceleration() / pull;
  const bool rolls_freely = state.solid.IsBall() && !(state.numbers["rolling_friction"] > 0);
  // A ball cannot lie on a slope, however slow it was.
  if (rolls_freely && support.is_exact)
    return Residual(support.normals, weight, 3) < kExactSlope ||
           Residual(support.cones, weight, 6) < kExactSlope;
  const double slow = kRests * std::sqrt(pull * 2 * HalfOf(object));
  const bool hardly_moved =
      fell_asleep_unseen ? !state.solid.IsBall() : std::max(speed, spin * HalfOf(object)) < slow;
  // Rolling friction balances a torque of its lever arm times the weight.
  const double rolls = state.numbers["rolling_friction"] / HalfOf(object);
  if (hardly_moved || Residual(support.normals, weight, 3) < kSlopes)
    return Residual(support.cones, weight, 6) < kTips + rolls;
  if (Residual(support.cones, weight, 3) > kSlides) return false;
  return state.numbers["rolling_friction"] > 0 || Residual(support.cones, weight, 6) < kRolls;
}

}  // namespace cdb::probes
