// A ball on the floor under Coulomb friction. The lowest point slips at s = v - r w x up, and
// friction f of at most mu N acts against it: v' = a + f/m, w' = -r up x f/I, so that with I = 2/5
// m r²
//   s' = a + 7/2 f/m.
// If f = -2/7 m a is less than mu N, slipping ends, and then v' = 5/7 a: on a slope the ball rolls
// if its tangent is at most 7/2 mu, and on a level floor a ball thrown without spin keeps 5/7 of
// its speed.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {
namespace {

using Eigen::Vector3d;

constexpr double kRolls = 5.0 / 7;     ///< fraction of an acceleration that a rolling ball gains
constexpr double kSlipGain = 7.0 / 2;  ///< s' divided by f/m

struct BallMotion {
  Vector3d x, v, w;  ///< m, m/s, rad/s
};

/// Slips at first, for `slips_for`, then rolls or slips the other way.
class BallOnFloor : public ClosedForm {
 public:
  /// `along`: the acceleration along the floor, parallel to the slip if both are present. `grip`:
  /// mu N/m, the maximum of friction. m/s².
  BallOnFloor(const Fit& fit, const Vector3d& along, double grip)
      : object_(fit.object(0)),
        acceleration_(fit.acceleration()),
        along_(along),
        grip_(grip),
        radius_(object_.solid.sides.x() / 2) {
    start_ = {object_.pose.position, object_.linear_velocity, object_.angular_velocity};
    start_.x.y() = fit.WallAt(-1) + radius_;
    const Vector3d slip = SlipOf(start_);
    if (!slip.isZero(0)) {
      first_ = -grip_ * slip.normalized();
      // The rate of change of the slip along itself.
      const double rate = slip.normalized().dot(along_ + kSlipGain * first_);
      slips_for_ = rate < 0 ? slip.norm() / -rate : HUGE_VAL;
    }
    const bool rolls = (1 - kRolls) * along_.norm() <= grip_;
    second_ = rolls ? Vector3d(-(1 - kRolls) * along_) : Vector3d(-grip_ * along_.normalized());
    if (std::isfinite(slips_for_)) turning_point_ = After(start_, first_, slips_for_);
    const BallMotion end = MotionAt(fit.end());
    energy_scale_ = std::max(EnergyOf(start_), EnergyOf(end) + TakenByFriction(end));
  }

  double slips_for() const { return slips_for_; }
  BallMotion MotionAt(double time_s) const {
    if (time_s < slips_for_) return After(start_, first_, time_s);
    return After(turning_point_, second_, time_s - slips_for_);
  }

  Truth At(double time_s) const override {
    const BallMotion now = MotionAt(time_s);
    Truth truth;
    truth.positions = {now.x};
    truth.velocities = {now.v};
    truth.spins = {now.w};
    truth.energy = EnergyOf(now) - EnergyOf(start_) -
                   object_.mass * acceleration_.dot(now.x - object_.pose.position);
    truth.momentum = object_.mass * now.v;
    truth.angular_momentum = kBallInertia * object_.mass * radius_ * radius_ * now.w;
    return truth;
  }

  double energy_scale() const override { return energy_scale_; }

 private:
  Vector3d SlipOf(const BallMotion& ball) const {
    return ball.v - radius_ * ball.w.cross(Vector3d::UnitY());
  }
  /// The motion under the constant friction `f` in N/kg.
  BallMotion After(const BallMotion& from, const Vector3d& f, double seconds) const {
    const Vector3d gain = along_ + f;
    const Vector3d spin = -Vector3d::UnitY().cross(f) / (kBallInertia * radius_);
    return {from.x + seconds * (from.v + seconds / 2 * gain), from.v + seconds * gain,
            from.w + seconds * spin};
  }
  /// Kinetic energy, J.
  double EnergyOf(const BallMotion& ball) const {
    return object_.mass / 2 *
           (ball.v.squaredNorm() + kBallInertia * radius_ * radius_ * ball.w.squaredNorm());
  }
  /// The energy lost to friction until then, J.
  double TakenByFriction(const BallMotion& ball) const {
    return std::max(
        0.0, EnergyOf(start_) + object_.mass * along_.dot(ball.x - start_.x) - EnergyOf(ball));
  }

  layouts::ObjectState object_;
  Vector3d acceleration_, along_;
  double grip_, radius_;
  BallMotion start_, turning_point_;
  Vector3d first_ = Vector3d::Zero(), second_;  ///< friction, N/kg
  double slips_for_ = 0;                        ///< s
  double energy_scale_ = 0;
};

/// Requires that the ball is on a floor and does not meet a wall before the end.
std::unique_ptr<BallOnFloor> MakeBallOnFloor(const Fit& fit, const Vector3d& along) {
  const layouts::ObjectState& ball = fit.object(0);
  const double radius = ball.solid.sides.x() / 2;
  fit.RequireStanding(0, ball.pose.position.y() - radius - fit.WallAt(-1), 2 * radius);
  const double grip = ball.numbers["friction"] * fit.WallFriction() * fit.Pressing();
  auto form = std::make_unique<BallOnFloor>(fit, along, grip);
  objects::Box reach{Vector3d::Constant(-radius), Vector3d::Constant(radius)};
  reach.lower.y() = reach.upper.y() = 0;  // it stands on the floor
  const double first = std::min(form->slips_for(), fit.end());
  for (const auto& [from, to] : {std::pair{0.0, first}, {first, fit.end()}}) {
    if (!(to > from)) continue;
    const BallMotion a = form->MotionAt(from), b = form->MotionAt(to);
    fit.RequireClearOfWalls(0, reach, a.x, a.v, (b.v - a.v) / (to - from), to - from);
  }
  return form;
}

void RequireRollingBall(const Fit& fit) {
  fit.RequireOneObject();
  fit.RequireBall(0);
  if (fit.object(0).numbers["rolling_friction"] != 0)
    fit.Refuse(fit.Name(0) + " has rolling friction", "make its rolling_friction 0");
}

}  // namespace

std::unique_ptr<ClosedForm> MakeRoll(const Fit& fit) {
  RequireRollingBall(fit);
  fit.RequireFloor();
  fit.RequireNoVelocity(0);
  fit.RequireNoSpin(0);
  const Vector3d downhill = fit.Downhill();
  if (downhill.isZero(0)) fit.Refuse("the acceleration is straight down", "tilt it");
  return MakeBallOnFloor(fit, downhill);
}

std::unique_ptr<ClosedForm> MakeBowl(const Fit& fit) {
  RequireRollingBall(fit);
  fit.RequireLevelFloor();
  fit.RequireLevelVelocity(0);
  const layouts::ObjectState& ball = fit.object(0);
  if (ball.angular_velocity.y() != 0)
    fit.Refuse(fit.Name(0) + " spins about the vertical", "make the y of its angular_velocity 0");
  if (!(ball.numbers["friction"] > 0))
    fit.Refuse("the ball never begins to roll", "make its friction greater than 0");
  auto form = MakeBallOnFloor(fit, Vector3d::Zero());
  if (form->slips_for() > fit.end())
    fit.Refuse(fmt::format("the ball rolls after {:.4g} s, and the run ends after {:.4g} s",
                           form->slips_for(), fit.end()),
               "make it longer, the friction larger, or the velocity smaller");
  return form;
}

}  // namespace cdb::closed_forms
