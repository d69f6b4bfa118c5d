// One object that hangs from its anchor by a spring of stiffness k with a damper c: its stretch u
// follows m u'' = -k u - c u' + m a. With b = c/2m and w² = k/m - b²
//   u = m a/k + exp(-b t) (A cos w t + (u'(0) + b A)/w sin w t), A = -m a/k,
// hyperbolic if w² < 0. Its period is 2 pi/w.
#include <fmt/format.h>

#include <cmath>

#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {
namespace {

using Eigen::Vector3d;

class Spring : public ClosedForm {
 public:
  explicit Spring(const Fit& fit)
      : object_(fit.object(0)),
        k_(fit.links().Real("links.stiffness")),
        pull_(fit.acceleration().y()),
        rate_(fit.links().Real("links.damping") / (2 * object_.mass)),
        square_(k_ / object_.mass - rate_ * rate_),
        hangs_(object_.mass * pull_ / k_) {}

  Truth At(double time_s) const override {
    const double w = std::sqrt(std::abs(square_));
    // cos and sin/w, or their hyperbolic counterparts with a stronger damper.
    double c = 1, s = time_s;
    if (square_ > 0) {
      c = std::cos(w * time_s);
      s = std::sin(w * time_s) / w;
    } else if (square_ < 0) {
      c = std::cosh(w * time_s);
      s = std::sinh(w * time_s) / w;
    }
    const double decay = std::exp(-rate_ * time_s), speed = object_.linear_velocity.y();
    const double a = -hangs_, b = speed - rate_ * hangs_;
    const double u = hangs_ + decay * (a * c + b * s);
    const double v = decay * (b * c - square_ * a * s - rate_ * (a * c + b * s));
    Truth truth;
    truth.positions = {object_.pose.position + u * Vector3d::UnitY()};
    truth.velocities = {v * Vector3d::UnitY()};
    truth.spins = {Vector3d::Zero()};
    truth.energy = object_.mass * ((v * v - speed * speed) / 2 - pull_ * u) + k_ * u * u / 2;
    truth.momentum = object_.mass * truth.velocities[0];
    truth.angular_momentum = Vector3d::Zero();
    return truth;
  }

  /// The energy of the swing about the position of rest.
  double energy_scale() const override {
    const double speed = object_.linear_velocity.y();
    return (object_.mass * speed * speed + k_ * hangs_ * hangs_) / 2;
  }

  /// m, from the start; a damper reduces it.
  double Farthest() const { return std::abs(hangs_) + std::sqrt(2 * energy_scale() / k_); }

 private:
  layouts::ObjectState object_;
  double k_, pull_, rate_, square_;
  double hangs_;  ///< m, position of rest relative to the start
};

}  // namespace

std::unique_ptr<ClosedForm> MakeSpring(const Fit& fit) {
  fit.RequireOneObject();
  fit.RequireLink("spring");
  fit.RequireNoSpin(0);
  const layouts::ObjectState& object = fit.object(0);
  Vector3d across = fit.acceleration().cwiseAbs() + object.linear_velocity.cwiseAbs();
  across.y() = 0;
  if (!across.isZero(0))
    fit.Refuse("acceleration and velocity are not both along the spring, which is upright",
               "make the x and z of both 0");
  auto form = std::make_unique<Spring>(fit);
  if (!(form->energy_scale() > 0))
    fit.Refuse("nothing swings", "give it an acceleration or a velocity");
  objects::Box reach = ReachOf(object);
  reach.lower.y() -= form->Farthest();
  reach.upper.y() += form->Farthest();
  fit.RequireClearOfWalls(0, reach, object.pose.position, Vector3d::Zero(), Vector3d::Zero(), 0);
  return form;
}

}  // namespace cdb::closed_forms
