// A ball that hits one wall obliquely, without acceleration. The normal velocity v_n becomes -e
// v_n, e the product of both restitutions. Friction gives at most mu times that impulse, mu (1 + e)
// v_n, and no more than stops the slip s = v_t - r w x n, which takes 2/7 of it (I = 2/5 m r²).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {
namespace {

using Eigen::Vector3d;

constexpr double kSticks = 2.0 / 7;  ///< change of velocity that stops the slip, divided by it

struct WallHit {
  double time = HUGE_VAL;              ///< s
  Vector3d normal = Vector3d::Zero();  ///< of the wall, into the cube
};

/// The first wall in the path of the ball.
WallHit FirstHit(const Fit& fit) {
  const layouts::ObjectState& ball = fit.object(0);
  const double radius = ball.solid.sides.x() / 2;
  WallHit first;
  for (int axis = 0; axis < 3; ++axis) {
    const double v = ball.linear_velocity[axis];
    const int sign = v < 0 ? -1 : 1;
    if (v == 0 || !fit.HasWall(axis, sign)) continue;
    const double time = (fit.WallAt(sign) - sign * radius - ball.pose.position[axis]) / v;
    if (time < first.time) first = {time, -sign * Vector3d::Unit(axis)};
  }
  return first;
}

class Oblique : public ClosedForm {
 public:
  Oblique(const Fit& fit, const WallHit& hit) : object_(fit.object(0)), meeting_(hit.time) {
    const double radius = object_.solid.sides.x() / 2;
    const Vector3d &v = object_.linear_velocity, &w = object_.angular_velocity;
    const double normal = -v.dot(hit.normal);
    const double restitution = object_.numbers["restitution"] * fit.WallRestitution();
    const double friction = object_.numbers["friction"] * fit.WallFriction();
    const Vector3d slip = v + normal * hit.normal - radius * w.cross(hit.normal);
    const double brake = std::min(kSticks * slip.norm(), friction * (1 + restitution) * normal);
    const Vector3d change = -brake * slip.stableNormalized();
    after_ = v + (1 + restitution) * normal * hit.normal + change;
    spin_after_ = w - hit.normal.cross(change) / (kBallInertia * radius);
    inertia_ = kBallInertia * object_.mass * radius * radius;
  }

  const Vector3d& after() const { return after_; }

  Truth At(double time_s) const override {
    const bool has_met = time_s >= meeting_;
    const double before = std::min(time_s, meeting_);
    Truth truth;
    truth.velocities = {has_met ? after_ : object_.linear_velocity};
    truth.spins = {has_met ? spin_after_ : object_.angular_velocity};
    truth.positions = {object_.pose.position + before * object_.linear_velocity +
                       (time_s - before) * after_};
    truth.energy = EnergyOf(truth.velocities[0], truth.spins[0]) - energy_scale();
    truth.momentum = object_.mass * truth.velocities[0];
    truth.angular_momentum = inertia_ * truth.spins[0];
    return truth;
  }

  double energy_scale() const override {
    return EnergyOf(object_.linear_velocity, object_.angular_velocity);
  }

 private:
  double EnergyOf(const Vector3d& v, const Vector3d& w) const {
    return (object_.mass * v.squaredNorm() + inertia_ * w.squaredNorm()) / 2;
  }

  layouts::ObjectState object_;
  double meeting_, inertia_ = 0;
  Vector3d after_, spin_after_;
};

}  // namespace

std::unique_ptr<ClosedForm> MakeOblique(const Fit& fit) {
  fit.RequireOneObject();
  fit.RequireBall(0);
  fit.RequireNoAcceleration();
  const layouts::ObjectState& ball = fit.object(0);
  const WallHit hit = FirstHit(fit);
  if (!(hit.time < fit.end()))
    fit.Refuse(std::isfinite(hit.time)
                   ? fmt::format("the ball meets a wall after {:.4g} s, and the run ends after "
                                 "{:.4g} s",
                                 hit.time, fit.end())
                   : std::string("there is no wall in the path of the ball"),
               "make the run longer, aim the linear_velocity at a wall, or use `flight`");
  auto form = std::make_unique<Oblique>(fit, hit);
  const Vector3d at_wall = ball.pose.position + hit.time * ball.linear_velocity;
  // The wall itself is left behind.
  const double radius = ball.solid.sides.x() / 2;
  const Vector3d clear = at_wall + kSame * radius * hit.normal;
  fit.RequireClearOfWalls(0, ReachOf(ball), clear, form->after(), Vector3d::Zero(),
                          fit.end() - hit.time);
  return form;
}

}  // namespace cdb::closed_forms
