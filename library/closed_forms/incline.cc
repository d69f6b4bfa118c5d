// A box on the floor under a tilted acceleration, with Coulomb friction: the product of both
// coefficients.
#include <fmt/format.h>

#include <cmath>

#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {
namespace {

using Eigen::Vector3d;

/// Motion from rest, with constant acceleration along the floor, which may be 0.
class OnFloor : public ClosedForm {
 public:
  OnFloor(const Fit& fit, double height, const Vector3d& along, double energy_scale)
      : object_(fit.object(0)),
        acceleration_(fit.acceleration()),
        along_(along),
        rest_(object_.pose.position),
        energy_scale_(energy_scale) {
    rest_.y() = fit.WallAt(-1) + height / 2;
  }

  Truth At(double time_s) const override {
    Truth truth;
    truth.positions = {rest_ + time_s * time_s / 2 * along_};
    truth.velocities = {time_s * along_};
    truth.orientations = {object_.pose.orientation};
    truth.spins = {Vector3d::Zero()};
    const Vector3d way = truth.positions[0] - object_.pose.position;
    truth.energy = object_.mass * (truth.velocities[0].squaredNorm() / 2 - acceleration_.dot(way));
    truth.momentum = object_.mass * truth.velocities[0];
    truth.angular_momentum = Vector3d::Zero();
    return truth;
  }

  double energy_scale() const override { return energy_scale_; }

 private:
  layouts::ObjectState object_;
  Vector3d acceleration_, along_, rest_;
  double energy_scale_;
};

struct Incline {
  double height;    ///< of the box
  double tangent;   ///< of the slope
  double friction;  ///< of box and floor
};

Incline RequireIncline(const Fit& fit) {
  fit.RequireOneObject();
  fit.RequireFloor();
  fit.RequireNoSpin(0);
  fit.RequireNoVelocity(0);
  const int upright = fit.RequireLevelCuboid(0);
  const layouts::ObjectState& box = fit.object(0);
  const double height = box.solid.sides[upright];
  fit.RequireStanding(0, box.pose.position.y() - height / 2 - fit.WallAt(-1), height);
  const Vector3d downhill = fit.Downhill();
  const double tangent = downhill.norm() / fit.Pressing();
  const double friction = box.numbers["friction"] * fit.WallFriction();
  // The force of the floor passes through the centre of mass from this point of the base.
  const Vector3d off = std::min(tangent, friction) * height / 2 * downhill.stableNormalized();
  if (!fit.IsOverBase(0, upright, off))
    fit.Refuse("the box would tip over", "make it flatter, the slope or the friction smaller");
  return {height, tangent, friction};
}

}  // namespace

std::unique_ptr<ClosedForm> MakeSlide(const Fit& fit) {
  const Incline incline = RequireIncline(fit);
  if (incline.tangent <= incline.friction)
    fit.Refuse(fmt::format("friction of {:.4g} (the product with the floor's) holds the box on a "
                           "slope of {:.4g}",
                           incline.friction, incline.tangent),
               "tilt the acceleration more, make the friction smaller, or use `stick`");
  const Vector3d downhill = fit.Downhill();
  const Vector3d along = downhill * (1 - incline.friction / incline.tangent);
  const double way = along.norm() * fit.end() * fit.end() / 2;
  return std::make_unique<OnFloor>(fit, incline.height, along,
                                   fit.object(0).mass * downhill.norm() * way);
}

std::unique_ptr<ClosedForm> MakeStick(const Fit& fit) {
  const Incline incline = RequireIncline(fit);
  if (incline.tangent > incline.friction)
    fit.Refuse(fmt::format("friction of {:.4g} (the product with the floor's) does not hold the "
                           "box on a slope of {:.4g}",
                           incline.friction, incline.tangent),
               "tilt the acceleration less, make the friction larger, or use `slide`");
  return std::make_unique<OnFloor>(fit, incline.height, Vector3d::Zero(),
                                   fit.object(0).mass * fit.Pressing() * incline.height / 2);
}

}  // namespace cdb::closed_forms
