#include "runtime/engine/probes/motion_watch.h"

#include <algorithm>
#include <cmath>

#include "runtime/engine/world/conversions.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;

constexpr double kLeastWay = 0.01;   ///< sides
constexpr double kDisplaced = 0.25;  ///< sides
constexpr double kFrozen = 0.1;      ///< fraction of its motion, lost or gained
constexpr double kLeastTurn = 0.05;  ///< rad
constexpr double kLeastCycles = 4;
constexpr double kLeastTurned = 1;  ///< rad

/// The angle between two rotations, from 0 to pi. |A - B| = 2 sqrt(2) sin(angle / 2) keeps its
/// digits for small angles.
double AngleBetween(const btMatrix3x3& a, const btMatrix3x3& b) {
  double sum = 0;
  for (int row = 0; row < 3; ++row)
    sum += (world::ToEigen(a[row]) - world::ToEigen(b[row])).squaredNorm();
  return 2 * std::asin(std::min(1.0, std::sqrt(sum / 8)));
}

/// Kinetic energy of rotation, J/kg.
double SpinEnergy(const btRigidBody& body, const Vector3d& inertia) {
  const Vector3d own =
      world::ToEigen(body.getAngularVelocity() * body.getWorldTransform().getBasis());
  return inertia.dot(own.cwiseAbs2()) / 2;
}

}  // namespace

MotionWatch::MotionWatch(world::Engine& engine, bool is_driven)
    : engine_(engine), is_driven_(is_driven) {
  tracks_.resize(engine.objects().size());
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const layouts::ObjectState& object = engine.initial_state().objects[i];
    tracks_[i].least_side = object.solid.sides.minCoeff();
    tracks_[i].least_piece = 2 * object.solid.LeastHalfExtent();
    tracks_[i].is_damped = object.numbers["linear_damping"] != 0;
    tracks_[i].keeps_spin = object.solid.IsBall() || object.numbers["angular_damping"] != 0 ||
                            engine.pushes().IsPushed(i);
    tracks_[i].inverse_mass = object.IsFixed() ? 0 : 1 / object.mass;
    tracks_[i].inertia = object.solid.InertiaPerMass();
    const world::Multibodies* multibodies = engine.links().multibodies();
    tracks_[i].is_link = multibodies != nullptr && multibodies->IsLink(i);
  }
}

void MotionWatch::Forget(Track& track) const {
  track.gone = track.to_go = Vector3d::Zero();
  track.gained = track.due = track.missed = 0;
}

void MotionWatch::Begin() {
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const btRigidBody& body = *engine_.objects()[i];
    Track& track = tracks_[i];
    track.position = body.getWorldTransform().getOrigin();
    // Bullet's precision may have displaced the object before its first motion.
    const Vector3d& exact = engine_.initial_state().objects[i].pose.position;
    track.start = world::ToEigen(track.position) + exact - world::RoundedForBullet(exact);
    track.basis = body.getWorldTransform().getBasis();
    track.velocity = body.getLinearVelocity();
    track.spin_energy = SpinEnergy(body, track.inertia);
    track.turned = 0;
    track.was_touched = false;
    Forget(track);
  }
}

MotionWatch::Step MotionWatch::StepOf(const btRigidBody& body, const Track& track) const {
  const double timestep = static_cast<double>(engine_.timestep());
  const Vector3d& g = engine_.acceleration();
  const double pull = g.norm();
  Step step;
  step.way = world::ToEigen(body.getWorldTransform().getOrigin()) - world::ToEigen(track.position);
  step.velocity = world::ToEigen(body.getLinearVelocity());
  // Beyond that of the object's own force.
  const Vector3d gained =
      step.velocity - world::ToEigen(track.velocity) -
      timestep * track.inverse_mass *
          engine_.pushes().Of(static_cast<std::size_t>(body.getUserIndex())).force;
  step.speedup = pull > 0 ? gained.dot(g) / pull : 0;
  step.spin = world::ToEigen(body.getAngularVelocity()).norm();
  const auto threshold = static_cast<double>(body.getCcdMotionThreshold());
  step.is_swept = threshold > 0 && step.velocity.norm() * timestep > threshold;
  return step;
}

double MotionWatch::TurnRatio(const btRigidBody& body, const Track& track, double spin) const {
  const double due = spin * static_cast<double>(engine_.timestep());
  if (!(due > kLeastTurn)) return std::numeric_limits<double>::quiet_NaN();
  return AngleBetween(body.getWorldTransform().getBasis(), track.basis) / due;
}

bool MotionWatch::CompareWay(const Step& step, Track& track, double& worst, Seen& seen) const {
  track.gone += step.way.cwiseAbs();
  track.to_go += step.velocity.cwiseAbs() * static_cast<double>(engine_.timestep());
  const Vector3d excess = track.gone - track.to_go;
  int axis = 0;
  const double largest = excess.cwiseAbs().maxCoeff(&axis);
  seen.lost_way = std::max(seen.lost_way, largest / track.least_side);
  const double longest = track.to_go.maxCoeff();
  if (!(longest > kLeastWay * track.least_side)) return false;
  const double part = largest / longest;
  if (part >= worst) {
    worst = part;
    seen.motion_ratio = 1 + excess[axis] / longest;
  }
  return part > kFrozen;
}

bool MotionWatch::CompareFall(const Step& step, Track& track, Seen& seen) const {
  const double timestep = static_cast<double>(engine_.timestep());
  const double pull = engine_.acceleration().norm();
  if (!(pull > 0) || is_driven_) return false;
  track.gained += step.speedup;
  track.due += pull * timestep;
  track.missed += std::abs(track.due - track.gained) * timestep;
  if (!(track.due > (kLeastCycles - 0.5) * pull * timestep)) return false;
  const double ratio = track.gained / track.due;
  seen.fall_ratio = std::fmin(seen.fall_ratio, ratio);
  seen.lost_way = std::max(seen.lost_way, track.missed / track.least_side);
  return ratio < 1 - kFrozen;
}

void MotionWatch::CompareSpin(const btRigidBody& body, double spin, Track& track,
                              Seen& seen) const {
  if (track.keeps_spin || track.was_touched || spin == 0) return;
  track.turned += spin * static_cast<double>(engine_.timestep());
  if (track.turned < kLeastTurned) return;
  const double ratio = SpinEnergy(body, track.inertia) / track.spin_energy;
  if (!(std::abs(ratio - 1) <= std::abs(seen.spin_ratio - 1))) seen.spin_ratio = ratio;
}

MotionWatch::Seen MotionWatch::After(std::span<const char> touches) {
  const double timestep = static_cast<double>(engine_.timestep());
  double worst = 0;  // distance of the motion ratio from 1
  Seen seen;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const btRigidBody& body = *engine_.objects()[i];
    if (body.isStaticOrKinematicObject()) continue;
    Track& track = tracks_[i];
    const btTransform& pose = body.getWorldTransform();
    const Step step = StepOf(body, track);
    const double displacement =
        (world::ToEigen(pose.getOrigin()) - track.start).norm() / track.least_piece;
    seen.displacement = std::max(seen.displacement, displacement);
    seen.displaced += displacement > kDisplaced;
    if (body.isActive() && !step.is_swept)
      seen.turn_ratio = std::fmin(seen.turn_ratio, TurnRatio(body, track, step.spin));
    track.position = pose.getOrigin();
    track.velocity = body.getLinearVelocity();
    if (step.spin != 0) track.basis = pose.getBasis();
    track.was_touched = track.was_touched || touches[i] != kFree || !body.isActive();
    // Bullet moves a body by its velocity at the end of the step, and out of overlaps; links of
    // multibodies it moves by the velocities of their joints.
    if (track.is_link || !body.isActive() || touches[i] == kPushed || step.is_swept) {
      Forget(track);
      continue;
    }
    if (touches[i] != kFree) {
      track.gained = track.due = track.missed = 0;
      // Resting objects tremble; such small motion does not matter.
      if (!(step.velocity.norm() * timestep > kLeastWay * track.least_side)) continue;
    }
    bool is_frozen = CompareWay(step, track, worst, seen);
    if (touches[i] == kFree) {
      CompareSpin(body, step.spin, track, seen);
      if (!track.is_damped) is_frozen = CompareFall(step, track, seen) || is_frozen;
    }
    seen.frozen += is_frozen;
  }
  return seen;
}

}  // namespace cdb::probes
