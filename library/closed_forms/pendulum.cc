// A rigid body that swings about a pivot l from its centre of mass: with I + m l² about the pivot
// and the angle q from the position of rest,
//   q'' = -w² sin q, w² = m l a/(I + m l²);
// released at q0, q = 2 asin(k cd(w t, k)), k = sin(q0/2), with the period 4 K(k)/w (Jacobi; see
// DLMF 22.19(i)).
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {
namespace {

using Eigen::Vector3d;

struct JacobiFunctions {
  double sn, cn, dn;
};

/// The Jacobi functions of modulus k < 1, by the arithmetic-geometric mean (DLMF 22.20(ii)).
JacobiFunctions JacobiOf(double u, double k) {
  constexpr std::size_t kMost = 16;  // it converges quadratically
  std::array<double, kMost + 1> a = {1}, c = {k};
  double b = std::sqrt(1 - k * k);
  std::size_t n = 0;
  double power = 1;
  while (n < kMost && std::abs(c[n]) > 1e-17 * a[n]) {
    a[n + 1] = (a[n] + b) / 2;
    c[n + 1] = (a[n] - b) / 2;
    b = std::sqrt(a[n] * b);
    ++n;
    power *= 2;
  }
  double amplitude = power * a[n] * u;
  for (; n > 0; --n) amplitude = (amplitude + std::asin(c[n] / a[n] * std::sin(amplitude))) / 2;
  const double sn = std::sin(amplitude);
  return {sn, std::cos(amplitude), std::sqrt(1 - k * k * sn * sn)};
}

class Pendulum : public ClosedForm {
 public:
  /// It turns about `axis`, starting at `angle` from the position of rest.
  Pendulum(const Fit& fit, double length, double angle, const Vector3d& axis)
      : object_(fit.object(0)),
        pivot_(object_.pose.position + length * Vector3d::UnitY()),
        length_(length),
        angle_(angle),
        axis_(axis) {
    const Vector3d inside = object_.pose.orientation.conjugate() * axis;
    inertia_ = object_.mass * object_.solid.InertiaPerMass().dot(inside.cwiseAbs2());
    const double pull = fit.acceleration().norm();
    frequency_ =
        std::sqrt(object_.mass * length * pull / (inertia_ + object_.mass * length * length));
    energy_scale_ = object_.mass * pull * length * (1 - std::cos(angle));
  }

  Truth At(double time_s) const override {
    const double k = std::sin(angle_ / 2);
    const JacobiFunctions f = JacobiOf(frequency_ * time_s, k);
    const double now = 2 * std::asin(k * f.cn / f.dn);
    // The time derivative; cd' = -(1 - k²) sn/dn².
    const double rate = -2 * k * frequency_ * std::sqrt(1 - k * k) * f.sn / f.dn;
    const Eigen::Quaterniond turn = layouts::TurnAbout((angle_ - now) * axis_);
    const Vector3d below = turn * (-length_ * Vector3d::UnitY());
    const Vector3d spin = -rate * axis_;
    Truth truth;
    truth.positions = {pivot_ + below};
    truth.velocities = {spin.cross(below)};
    truth.orientations = {turn * object_.pose.orientation};
    truth.spins = {spin};
    truth.energy = 0;
    truth.momentum = object_.mass * truth.velocities[0];
    truth.angular_momentum = inertia_ * spin;
    return truth;
  }

  double energy_scale() const override { return energy_scale_; }

 private:
  layouts::ObjectState object_;
  Vector3d pivot_;
  double length_, angle_;
  Vector3d axis_;
  double inertia_ = 0;  ///< about the centre of mass and `axis_`, kg m²
  double frequency_ = 0, energy_scale_ = 0;
};

}  // namespace

std::unique_ptr<ClosedForm> MakePendulum(const Fit& fit) {
  fit.RequireOneObject();
  fit.RequireLink("ball or hinge");
  fit.RequireNoSpin(0);
  fit.RequireNoVelocity(0);
  const layouts::ObjectState& object = fit.object(0);
  const Vector3d down = -Vector3d::UnitY(), pull = fit.acceleration();
  if (fit.Downhill().isZero(0))
    fit.Refuse("the body hangs at rest, as the acceleration is along y",
               "tilt the acceleration by the initial angle of the swing");
  const Vector3d axis = down.cross(pull).normalized();
  const double angle = std::acos(down.dot(pull) / pull.norm());
  const Vector3d inside = object.pose.orientation.conjugate() * axis;
  const Vector3d along = object.solid.InertiaPerMass().cwiseProduct(inside);
  if (inside.cross(along).norm() > kSame * along.norm())
    fit.Refuse("the body does not swing about one of its own axes",
               "turn the acceleration about x or z, or make the object a ball");
  if (fit.links().WordOr("links.type") == "hinge" && std::abs(axis.z()) < 1 - kSame)
    fit.Refuse("a hinge turns about z, but the acceleration is tilted about another axis",
               "make the z of the acceleration 0, or links.type ball");
  const double length = objects::Bounds(object.solid, object.pose.orientation).upper.y();
  const Vector3d reach = Vector3d::Constant(length + object.solid.OuterRadius());
  fit.RequireClearOfWalls(0, {-reach, reach}, object.pose.position - length * down,
                          Vector3d::Zero(), Vector3d::Zero(), 0);
  return std::make_unique<Pendulum>(fit, length, angle, axis);
}

}  // namespace cdb::closed_forms
