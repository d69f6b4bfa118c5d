#include "runtime/engine/probes/motion_watch.h"

#include <algorithm>
#include <cmath>

#include "runtime/engine/world/conversions.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;

constexpr double kLeastWay = 0.01;   ///< sides
constexpr double kLeastTurn = 0.05;  ///< rad
constexpr double kLeastCycles = 4;

/// Between two turns, from 0 to pi: |A - B| = 2 sqrt(2) sin(angle / 2), which keeps its digits for
/// small angles.
double AngleBetween(const btMatrix3x3& a, const btMatrix3x3& b) {
  double sum = 0;
  for (int row = 0; row < 3; ++row)
    sum += (world::ToEigen(a[row]) - world::ToEigen(b[row])).squaredNorm();
  return 2 * std::asin(std::min(1.0, std::sqrt(sum / 8)));
}

}  // namespace

MotionWatch::MotionWatch(world::Engine& engine) : engine_(engine) {
  tracks_.resize(engine.objects().size());
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const layouts::ObjectState& object = engine.initial_state().objects[i];
    tracks_[i].least_side = 2 * object.solid.LeastHalfExtent();
    tracks_[i].is_damped = object.linear_damping != 0;
  }
}

void MotionWatch::Forget(Track& track) const {
  track.gone = track.to_go = Vector3d::Zero();
  track.gained = track.due = 0;
}

void MotionWatch::Begin() {
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const btRigidBody& body = *engine_.objects()[i];
    Track& track = tracks_[i];
    track.position = body.getWorldTransform().getOrigin();
    // Bullet's precision may have moved it before it ever moved.
    const Vector3d& exact = engine_.initial_state().objects[i].pose.position;
    track.start = world::ToEigen(track.position) + exact - world::RoundedForBullet(exact);
    track.basis = body.getWorldTransform().getBasis();
    track.velocity = body.getLinearVelocity();
    Forget(track);
  }
}

MotionWatch::Seen MotionWatch::After(std::span<const char> touches) {
  const double timestep = static_cast<double>(engine_.timestep());
  const Vector3d& g = engine_.acceleration();
  const double pull = g.norm();
  double worst = 0;  // distance of a ratio from 1
  Seen seen;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const btRigidBody& body = *engine_.objects()[i];
    if (body.isStaticObject()) continue;
    Track& track = tracks_[i];
    const btTransform& pose = body.getWorldTransform();
    const Vector3d way = world::ToEigen(pose.getOrigin()) - world::ToEigen(track.position);
    const Vector3d velocity = world::ToEigen(body.getLinearVelocity());
    const double gain = pull > 0 ? (velocity - world::ToEigen(track.velocity)).dot(g) / pull : 0;
    const double spin = world::ToEigen(body.getAngularVelocity()).norm();
    seen.displacement =
        std::max(seen.displacement,
                 (world::ToEigen(pose.getOrigin()) - track.start).norm() / track.least_side);
    // A body that ccd sweeps stops where it hits.
    const bool is_swept =
        body.getCcdMotionThreshold() > 0 &&
        velocity.norm() * timestep > static_cast<double>(body.getCcdMotionThreshold());
    if (body.isActive() && !is_swept && spin * timestep > kLeastTurn)
      seen.turn_ratio = std::fmin(seen.turn_ratio,
                                  AngleBetween(pose.getBasis(), track.basis) / (spin * timestep));
    track.position = pose.getOrigin();
    track.velocity = body.getLinearVelocity();
    if (spin != 0) track.basis = pose.getBasis();
    // Bullet moves a body by its velocity at the end of the step, and out of what it overlaps.
    const bool is_pushed = touches[i] == kPushed || is_swept;
    if (!body.isActive() || is_pushed) {
      Forget(track);
      continue;
    }
    if (touches[i] != kFree) {
      track.gained = track.due = 0;
      // What rests trembles, by less than can matter.
      if (!(velocity.norm() * timestep > kLeastWay * track.least_side)) continue;
    }
    track.gone += way.cwiseAbs();
    track.to_go += velocity.cwiseAbs() * timestep;
    const double longest = track.to_go.maxCoeff();
    for (int axis = 0; axis < 3 && longest > kLeastWay * track.least_side; ++axis) {
      const double excess = (track.gone[axis] - track.to_go[axis]) / longest;
      if (std::abs(excess) < worst) continue;
      worst = std::abs(excess);
      seen.motion_ratio = 1 + excess;
    }
    if (track.is_damped || !(pull > 0) || touches[i] != kFree) continue;
    track.gained += gain;
    track.due += pull * timestep;
    if (track.due > (kLeastCycles - 0.5) * pull * timestep)
      seen.fall_ratio = std::fmin(seen.fall_ratio, track.gained / track.due);
  }
  return seen;
}

}  // namespace cdb::probes
