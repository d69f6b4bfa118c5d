// A box that slides on the level floor until friction stops it: v' = -mu g, so that it stops after
// v/(mu g) and v²/(2 mu g) (Coulomb; mu is the product of both coefficients).
#include <fmt/format.h>

#include <algorithm>

#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {
namespace {

using Eigen::Vector3d;

class Braking : public ClosedForm {
 public:
  /// `rest`: the position of its centre when it stands on the floor.
  Braking(const Fit& fit, const Vector3d& rest, double deceleration)
      : object_(fit.object(0)),
        acceleration_(fit.acceleration()),
        rest_(rest),
        along_(object_.linear_velocity.normalized()),
        speed_(object_.linear_velocity.norm()),
        deceleration_(deceleration) {}

  double StopsAfter() const { return speed_ / deceleration_; }

  Truth At(double time_s) const override {
    const double moving = std::min(time_s, StopsAfter());
    const double speed = time_s < StopsAfter() ? speed_ - deceleration_ * time_s : 0;
    Truth truth;
    truth.positions = {rest_ + moving * (speed_ - deceleration_ * moving / 2) * along_};
    truth.velocities = {speed * along_};
    truth.orientations = {object_.pose.orientation};
    truth.spins = {Vector3d::Zero()};
    const Vector3d way = truth.positions[0] - object_.pose.position;
    truth.energy = object_.mass * ((speed * speed - speed_ * speed_) / 2 - acceleration_.dot(way));
    truth.momentum = object_.mass * truth.velocities[0];
    truth.angular_momentum = Vector3d::Zero();
    return truth;
  }

  double energy_scale() const override { return object_.mass * speed_ * speed_ / 2; }

 private:
  layouts::ObjectState object_;
  Vector3d acceleration_, rest_, along_;
  double speed_, deceleration_;
};

}  // namespace

std::unique_ptr<ClosedForm> MakeBraking(const Fit& fit) {
  fit.RequireOneObject();
  fit.RequireLevelFloor();
  fit.RequireNoSpin(0);
  const int upright = fit.RequireLevelCuboid(0);
  const layouts::ObjectState& box = fit.object(0);
  const double height = box.solid.sides[upright];
  fit.RequireStanding(0, box.pose.position.y() - height / 2 - fit.WallAt(-1), height);
  fit.RequireLevelVelocity(0);
  const double friction = box.numbers["friction"] * fit.WallFriction();
  if (!(friction > 0)) fit.Refuse("nothing stops the box", "make its friction greater than 0");
  // The force of the floor passes through the centre of mass from this point of the base.
  const Vector3d off = friction * height / 2 * box.linear_velocity.normalized();
  if (!fit.IsOverBase(0, upright, off))
    fit.Refuse("the box would tip over", "make it flatter or the friction smaller");
  Vector3d rest = box.pose.position;
  rest.y() = fit.WallAt(-1) + height / 2;
  auto form = std::make_unique<Braking>(fit, rest, friction * fit.Pressing());
  objects::Box reach = ReachOf(box);
  reach.lower.y() = reach.upper.y() = 0;  // it stands on the floor
  fit.RequireClearOfWalls(0, reach, rest, box.linear_velocity,
                          -friction * fit.Pressing() * box.linear_velocity.normalized(),
                          std::min(fit.end(), form->StopsAfter()));
  return form;
}

}  // namespace cdb::closed_forms
