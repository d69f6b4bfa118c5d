// A ball between walls: parabolas, or straight lines, from impact to impact. An impact multiplies
// the normal velocity by the product of both restitutions.
#include <algorithm>
#include <cmath>

#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A ball that leaves a wall no faster than this fraction of its maximum speed stays there. Its
/// next hop is 1e-18 of the first in height, below rounding, and the infinitely many later hops
/// take 1e-9 of the time of the first.
constexpr double kRest = 1e-9;

/// The motion along one axis.
struct Ball {
  double x = 0, v = 0, a = 0;

  void Fly(double seconds) {
    x += seconds * (v + a * seconds / 2);
    v += a * seconds;
  }
  /// The velocity at which it passes `wall` in the direction of `sign`; 0 if it never does.
  double SpeedAt(double wall, int sign) const {
    return sign * std::sqrt(std::max(v * v + 2 * a * (wall - x), 0.0));
  }
  /// The time until it passes; negative or infinite if it never does.
  double TimeTo(double wall, int sign) const {
    const double at_wall = SpeedAt(wall, sign);
    if (at_wall == 0) return kInfinity;
    // Of the two forms of the root, the one without cancellation.
    if (v * at_wall > 0) return 2 * (wall - x) / (v + at_wall);
    return (at_wall - v) / a;
  }
};

class Bounce : public ClosedForm {
 public:
  Bounce(const Fit& fit, int axis)
      : object_(fit.object(0)),
        axis_(axis),
        start_{object_.pose.position[axis], object_.linear_velocity[axis],
               fit.acceleration()[axis]},
        restitution_(object_.numbers["restitution"] * fit.WallRestitution()) {
    const double radius = object_.solid.sides.x() / 2;
    for (const int sign : {-1, 1})
      walls_[sign > 0] =
          fit.HasWall(axis, sign) ? fit.WallAt(sign) - sign * radius : sign * kInfinity;
  }

  Truth At(double time_s) const override {
    const Ball ball = After(time_s);
    Truth truth;
    truth.positions = {object_.pose.position};
    truth.positions[0][axis_] = ball.x;
    truth.velocities = {ball.v * Vector3d::Unit(axis_)};
    truth.energy = Energy(ball) - Energy(start_);
    truth.momentum = object_.mass * truth.velocities[0];
    truth.angular_momentum = Vector3d::Zero();
    return truth;
  }

  double energy_scale() const override {
    const double lowest = start_.a == 0 ? 0 : -object_.mass * start_.a * walls_[start_.a > 0];
    return Energy(start_) - lowest;
  }

 private:
  Ball After(double seconds) const {
    Ball ball = start_;
    double fastest = std::abs(ball.v);
    for (;;) {
      double next = seconds;
      int hit = 0;
      for (const int sign : {-1, 1}) {
        if (!std::isfinite(walls_[sign > 0])) continue;
        const double time = ball.TimeTo(walls_[sign > 0], sign);
        if (!(time >= 0 && time < next)) continue;
        next = time;
        hit = sign;
      }
      if (hit == 0) {
        ball.Fly(seconds);
        return ball;
      }
      const double wall = walls_[hit > 0];
      const double speed = ball.SpeedAt(wall, hit);
      fastest = std::max(fastest, std::abs(speed));
      ball.x = wall;
      ball.v = -restitution_ * speed;
      seconds -= next;
      if (std::abs(ball.v) <= kRest * fastest) {
        ball.v = 0;
        if (ball.a * hit >= 0) return ball;
      }
    }
  }

  double Energy(const Ball& ball) const {
    return object_.mass * (ball.v * ball.v / 2 - ball.a * ball.x);
  }

  layouts::ObjectState object_;
  int axis_;
  Ball start_;
  double restitution_;
  double walls_[2];  ///< of the path of the centre, - and +; infinite without a wall
};

bool IsAlong(const Vector3d& vector, int axis) {
  Vector3d rest = vector;
  rest[axis] = 0;
  return rest.isZero(0);
}

}  // namespace

std::unique_ptr<ClosedForm> MakeBounce(const Fit& fit) {
  fit.RequireOneObject();
  fit.RequireBall(0);
  fit.RequireNoSpin(0);
  const Vector3d& velocity = fit.object(0).linear_velocity;
  int axis = 0;
  const bool falls = !fit.acceleration().isZero(0);
  (falls ? fit.acceleration() : velocity).cwiseAbs().maxCoeff(&axis);
  if (!falls && velocity.isZero(0))
    fit.Refuse("nothing moves", "give it an acceleration or a velocity");
  if (!IsAlong(fit.acceleration(), axis) || !IsAlong(velocity, axis))
    fit.Refuse("acceleration and velocity are not both along one axis",
               "make two components of both 0");
  const int towards = fit.acceleration()[axis] < 0 ? -1 : 1;
  if (!fit.HasWall(axis, -1) && !fit.HasWall(axis, 1))
    fit.Refuse("there is no wall in the path of the ball", "make world.walls all, or use `flight`");
  if (falls && !fit.HasWall(axis, towards))
    fit.Refuse("it falls to a side without a wall", "make world.walls all, or use `flight`");
  auto form = std::make_unique<Bounce>(fit, axis);
  if (!(form->energy_scale() > 0))
    fit.Refuse("the ball rests", "place it above the floor or give it a velocity");
  return form;
}

}  // namespace cdb::closed_forms
