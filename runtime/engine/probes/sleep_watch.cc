#include "runtime/engine/probes/sleep_watch.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "runtime/engine/world/conversions.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;
using Wrench = Eigen::Matrix<double, 6, 1>;  ///< force, and torque over the least side

/// Weights that are left over, in weights: of normals alone, that the ground slopes; of forces with
/// friction; of forces and torques.
constexpr double kSlopes = 0.005, kSlides = 0.005, kRolls = 0.0035;
/// Slower, in sqrt(g S), an object rests.
constexpr double kRests = 0.005;
constexpr int kDirections = 8;  ///< edges of a cone of friction
constexpr int kSweeps = 500;

/// What non-negative multiples of the columns leave of `weight`.
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

/// The forces that contacts can put on an object.
struct Support {
  std::vector<Wrench> normals, cones;
};

/// `normal` points to the object. One edge of the cone lies against the slope.
void AddPoint(const Vector3d& normal, const Vector3d& arm, double friction, const Vector3d& up,
              Support& support) {
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

/// Torques are over `length`.
Support SupportOf(world::Engine& engine, const btRigidBody& body, double length) {
  Support support;
  const Vector3d origin = world::ToEigen(body.getWorldTransform().getOrigin());
  const Vector3d up = -engine.acceleration().normalized();
  btDispatcher& dispatcher = *engine.world().getDispatcher();
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
    const bool is_first = manifold.getBody0() == &body;
    if (!is_first && manifold.getBody1() != &body) continue;
    for (int j = 0; j < manifold.getNumContacts(); ++j) {
      const btManifoldPoint& point = manifold.getContactPoint(j);
      AddPoint((is_first ? 1 : -1) * world::ToEigen(point.m_normalWorldOnB),
               (world::ToEigen(point.getPositionWorldOnB()) - origin) / length,
               static_cast<double>(point.m_combinedFriction), up, support);
    }
  }
  return support;
}

}  // namespace

SleepWatch::SleepWatch(world::Engine& engine)
    : engine_(engine), linked_(engine.objects().size(), 0), unheld_(linked_.size(), 0) {
  engine.links().MarkHeld(linked_, 1);
}

std::int32_t SleepWatch::After(const BodyStates& before, const BodyStates& now) {
  std::int32_t count = 0;
  for (std::size_t i = 0; i < unheld_.size(); ++i) {
    if (!now[i].is_asleep) {
      unheld_[i] = 0;
    } else if ((!before[i].is_asleep || is_first_) && !linked_[i]) {
      unheld_[i] = !IsHeld(i, before[i]);
    }
    count += unheld_[i];
  }
  is_first_ = false;
  return count;
}

bool SleepWatch::IsHeld(std::size_t object, const BodyState& before) {
  const double pull = engine_.acceleration().norm();
  if (!(pull > 0)) return true;
  const btRigidBody& body = *engine_.objects()[object];
  const layouts::ObjectState& state = engine_.initial_state().objects[object];
  const double half = state.solid.LeastHalfExtent();
  const Support support = SupportOf(engine_, body, half);
  if (support.normals.empty()) return false;
  // A ball cannot lie on a slope, however slow it was.
  const bool fell_asleep_unseen = before.is_asleep;
  if (fell_asleep_unseen
          ? !state.solid.IsBall()
          : world::ToEigen(before.velocity).norm() < kRests * std::sqrt(pull * 2 * half))
    return true;
  Wrench weight = Wrench::Zero();
  weight.head<3>() = -engine_.acceleration() / pull;
  if (Residual(support.normals, weight, 3) < kSlopes) return true;
  if (Residual(support.cones, weight, 3) > kSlides) return false;
  return state.rolling_friction > 0 || Residual(support.cones, weight, 6) < kRolls;
}

}  // namespace cdb::probes
