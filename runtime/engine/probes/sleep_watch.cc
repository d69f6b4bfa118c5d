#include "runtime/engine/probes/sleep_watch.h"

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
/// In sqrt(g S): a slower object rests.
constexpr double kRests = 0.005;
constexpr int kDirections = 8;  ///< edges of a friction cone
constexpr int kSweeps = 500;

/// The part of `weight` that no non-negative combination of the columns balances.
double Residual(const std::vector<Wrench>& columns, Wrench weight, int rows) {
  std::vector<double> parts(columns.size(), 0);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double change = 0;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto column = columns[i].head(rows);
      const double part =
          std::max(0.0, parts[i] + column.dot(weight.head(rows)) / column.squaredNorm());
      weight.head(rows) -= (part - parts[i]) * column;
      change = std::max(change, std::abs(part - parts[i]));
      parts[i] = part;
    }
    if (change < 1e-6) break;
  }
  return weight.head(rows).norm();
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
    : engine_(engine), linked_(engine.objects().size(), 0), unheld_(linked_.size(), 0) {
  engine.links().MarkHeld(linked_, 1);
}

std::int32_t SleepWatch::After(const BodyStates& before, const BodyStates& now) {
  supports_.clear();
  for (std::size_t i = 0; i < unheld_.size(); ++i) {
    if (!now[i].is_asleep)
      unheld_[i] = 0;
    else if ((!before[i].is_asleep || is_first_) && !linked_[i])
      supports_.try_emplace(i);
  }
  is_first_ = false;
  if (!supports_.empty() && engine_.acceleration().norm() > 0) {
    CollectSupports();
    for (const auto& [object, support] : supports_)
      unheld_[object] = !IsHeld(object, before[object], support);
  }
  return static_cast<std::int32_t>(std::ranges::count(unheld_, 1));
}

void SleepWatch::CollectSupports() {
  const Vector3d up = -engine_.acceleration().normalized();
  const auto add = [&](const btPersistentManifold& manifold, const btCollisionObject* body,
                       double sign) {
    const auto found = supports_.find(static_cast<std::size_t>(body->getUserIndex()));
    if (found == supports_.end()) return;
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
    add(manifold, manifold.getBody0(), 1);
    add(manifold, manifold.getBody1(), -1);
  }
}

double SleepWatch::HalfOf(std::size_t object) const {
  return engine_.initial_state().objects[object].solid.LeastHalfExtent();
}

bool SleepWatch::IsHeld(std::size_t object, const BodyState& before, const Support& support) const {
  const double pull = engine_.acceleration().norm();
  const layouts::ObjectState& state = engine_.initial_state().objects[object];
  if (support.normals.empty()) return false;
  // A ball cannot lie on a slope, however slow it was.
  const bool fell_asleep_unseen = before.is_asleep;
  if (fell_asleep_unseen
          ? !state.solid.IsBall()
          : world::ToEigen(before.velocity).norm() < kRests * std::sqrt(pull * 2 * HalfOf(object)))
    return true;
  Wrench weight = Wrench::Zero();
  weight.head<3>() = -engine_.acceleration() / pull;
  if (Residual(support.normals, weight, 3) < kSlopes) return true;
  if (Residual(support.cones, weight, 3) > kSlides) return false;
  return state.numbers["rolling_friction"] > 0 || Residual(support.cones, weight, 6) < kRolls;
}

}  // namespace cdb::probes
