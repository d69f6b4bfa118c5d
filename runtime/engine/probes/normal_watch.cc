#include "runtime/engine/probes/normal_watch.h"

#include <algorithm>
#include <cmath>

#include "library/exact/legal_normals.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;

// Found by measurement.
/// Sine of the angle to the nearest legal normal from which on a normal is false.
constexpr double kFalseAngle = 0.02;
/// Of an object's momentum: a tenth of the energy of its motion, as in the verdict of lost energy.
constexpr double kDeflects = 0.05;
/// Of an object's least side: the fall that gives it the least momentum that counts.
constexpr double kScaleFall = 0.01;
/// A contact point lies on the triangles within this part of the surface's longest side and twice
/// the depth, of which no more counts than this part of the object's least side.
constexpr double kOnSurface = 1e-5, kMostDepth = 0.1;

}  // namespace

NormalWatch::NormalWatch(world::Engine& engine) : engine_(engine) {
  const double pull = engine.acceleration().norm();
  for (const layouts::ObjectState& object : engine.initial_state().objects) {
    has_surfaces_ = has_surfaces_ || object.solid.IsSurface();
    const double side = 2 * object.solid.LeastHalfExtent();
    // Without gravity, that of moving by a tenth of its side per second.
    const double least = std::max(std::sqrt(2 * pull * kScaleFall * side), 0.1 * side);
    objects_.push_back({object.IsFixed() ? 0 : object.mass, least, Vector3d::Zero(), false});
  }
}

NormalWatch::Seen NormalWatch::After(const BodyStates& before, const BodyStates& now) {
  Seen seen = {};
  if (!has_surfaces_) return seen;
  for (std::size_t i = 0; i < objects_.size(); ++i)
    objects_[i].speed = std::max({objects_[i].speed, world::ToEigen(before[i].velocity).norm(),
                                  world::ToEigen(now[i].velocity).norm()});
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world()))
    Check(manifold, now, seen);
  for (Moving& object : objects_) {
    const double most = kDeflects * object.mass * object.speed;
    object.is_deflected = object.is_deflected || object.impulse.norm() > most;
    seen.deflected += object.is_deflected;
  }
  return seen;
}

void NormalWatch::Check(const btPersistentManifold& manifold, const BodyStates& now, Seen& seen) {
  const auto index = [](const btCollisionObject* body) {
    return static_cast<std::size_t>(body->getUserIndex());
  };
  const std::size_t a = index(manifold.getBody0()), b = index(manifold.getBody1());
  if (a >= objects_.size() || b >= objects_.size()) return;  // a wall
  const auto& state = engine_.initial_state().objects;
  const bool is_first = state[a].solid.IsSurface();
  if (!is_first && !state[b].solid.IsSurface()) return;
  const std::size_t surface = is_first ? a : b, other = is_first ? b : a;
  // The contacts of objects that sleep keep their last impulse.
  if (objects_[other].mass == 0 || now[other].is_asleep) return;
  const Eigen::Quaterniond& turn = state[surface].pose.orientation;
  const objects::Compound& triangles = *state[surface].solid.compound;
  // Bullet computes the point in the world, in its own precision.
  const double precision =
      kOnSurface * triangles.sides().maxCoeff() +
      8 * static_cast<double>(SIMD_EPSILON) * state[surface].pose.position.norm();
  const double most_depth = kMostDepth * 2 * state[other].solid.LeastHalfExtent();
  for (int j = 0; j < manifold.getNumContacts(); ++j) {
    const btManifoldPoint& point = manifold.getContactPoint(j);
    const double impulse = static_cast<double>(point.m_appliedImpulse);
    if (point.getDistance() > manifold.getContactProcessingThreshold() || impulse == 0) continue;
    // From the surface to the object, in the axes of the surface.
    const Vector3d normal =
        turn.conjugate() *
        ((is_first ? -1.0 : 1.0) * world::ToEigen(point.m_normalWorldOnB)).normalized();
    const Vector3d place = world::ToEigen(is_first ? point.m_localPointA : point.m_localPointB);
    const double depth = std::abs(static_cast<double>(point.getDistance()));
    const double reach = precision + 2 * std::min(depth, most_depth);
    const auto legal = exact::NearestLegalNormal(triangles, place, normal, reach);
    if (!legal) continue;
    const Vector3d across = normal - std::max(0.0, normal.dot(*legal)) * *legal;
    if (across.norm() <= kFalseAngle) continue;
    ++seen.false_normals;
    seen.false_impulse += impulse * across.norm();
    objects_[other].impulse += turn * (impulse * across);
  }
}

}  // namespace cdb::probes
