// A free rigid body: Euler's equations with the orientation, by Taylor series far below rounding. A
// body that spins about its middle axis flips over: with I1 < I2 < I3, the energy E and the angular
// momentum L, the spin along that axis varies as sn(p t), with
//   p² = (I3 - I2)(L² - 2 E I1)/(I1 I2 I3), k² = (I2 - I1)(2 E I3 - L²)/((I3 - I2)(L² - 2 E I1)),
// and I1 and I3 exchanged if L² < 2 E I2; the time between two flips is 2 K(k)/p (Landau and
// Lifshitz, Mechanics, section 37).
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

struct Turning {
  Vector3d spin = Vector3d::Zero();  ///< in body axes, rad/s
  Quaterniond orientation = Quaterniond::Identity();
};

// The rates are at most the squares of the spin, so that the coefficients of a solution are at most
// powers of it: with a step of a tenth of a radian, the remainder after this many is 0.1^17.
constexpr std::size_t kOrder = 16;
constexpr double kRadiansPerStep = 0.1;

/// `ratios` are (I2 - I3)/I1 and so on, each within ±1.
Turning Step(const Turning& from, const Vector3d& ratios, double seconds) {
  // The equations are quadratic, so each coefficient is a sum of products of earlier ones.
  std::array<Vector3d, kOrder + 1> spin;
  std::array<Quaterniond, kOrder + 1> turn;
  spin[0] = from.spin;
  turn[0] = from.orientation;
  Turning to = from;
  double power = 1;
  for (std::size_t k = 0; k < kOrder; ++k) {
    Vector3d spin_sum = Vector3d::Zero();
    Quaterniond turn_sum(0, 0, 0, 0);
    for (std::size_t j = 0; j <= k; ++j) {
      const Vector3d &a = spin[j], &b = spin[k - j];
      spin_sum += Vector3d(a.y() * b.z(), a.z() * b.x(), a.x() * b.y());
      turn_sum.coeffs() += (turn[j] * Quaterniond(0, b.x(), b.y(), b.z())).coeffs();
    }
    const double next = static_cast<double>(k + 1);
    spin[k + 1] = ratios.cwiseProduct(spin_sum) / next;
    turn[k + 1].coeffs() = turn_sum.coeffs() / (2 * next);
    power *= seconds;
    to.spin += power * spin[k + 1];
    to.orientation.coeffs() += power * turn[k + 1].coeffs();
  }
  to.orientation.normalize();
  return to;
}

class Spin : public ClosedForm {
 public:
  explicit Spin(const Fit& fit) : object_(fit.object(0)) {
    start_.orientation = object_.pose.orientation;
    start_.spin = start_.orientation.conjugate() * object_.angular_velocity;
    const Vector3d inertia = object_.solid.InertiaPerMass();
    ratios_ =
        Vector3d(inertia.y() - inertia.z(), inertia.z() - inertia.x(), inertia.x() - inertia.y())
            .cwiseQuotient(inertia);
    const double energy = inertia.dot(start_.spin.cwiseAbs2()) / 2;
    energy_scale_ = object_.mass * energy;
    const double fastest = std::sqrt(2 * energy / inertia.minCoeff());
    step_ = kRadiansPerStep / fastest;
    angular_momentum_ = object_.mass * (start_.orientation * inertia.cwiseProduct(start_.spin));
    last_ = start_;
  }

  Truth At(double time_s) const override {
    if (time_s < steps_done_ * step_) {
      last_ = start_;
      steps_done_ = 0;
    }
    for (; (steps_done_ + 1) * step_ <= time_s; ++steps_done_) last_ = Step(last_, ratios_, step_);
    const Turning now = Step(last_, ratios_, time_s - steps_done_ * step_);
    Truth truth;
    truth.positions = {object_.pose.position + time_s * object_.linear_velocity};
    truth.velocities = {object_.linear_velocity};
    truth.orientations = {now.orientation};
    truth.spins = {now.orientation * now.spin};
    truth.energy = 0;
    truth.momentum = object_.mass * object_.linear_velocity;
    truth.angular_momentum = angular_momentum_;
    return truth;
  }

  double energy_scale() const override { return energy_scale_; }

 private:
  layouts::ObjectState object_;
  Turning start_;
  Vector3d ratios_, angular_momentum_;
  double energy_scale_ = 0, step_ = 0;
  // The last state integrated, from which the next call continues.
  mutable Turning last_;
  mutable double steps_done_ = 0;
};

/// Relative to 1: a modulus this close to 1 differs from it only by rounding.
constexpr double kRoundedModulus = 1e-14;

/// The time between two flips, s; infinite if the body spins about a principal axis.
double FlipTime(const layouts::ObjectState& object) {
  Vector3d inertia = object.solid.InertiaPerMass();
  const Vector3d spin = object.pose.orientation.conjugate() * object.angular_velocity;
  const double twice = inertia.dot(spin.cwiseAbs2());  // 2 E and L² per mass
  const double square = inertia.cwiseProduct(spin).squaredNorm();
  std::sort(inertia.data(), inertia.data() + 3);
  if (square < twice * inertia[1]) std::swap(inertia[0], inertia[2]);
  const double spread = (inertia[2] - inertia[1]) * (square - twice * inertia[0]);
  const double rate = std::sqrt(spread / inertia.prod());
  const double modulus = (inertia[1] - inertia[0]) * (twice * inertia[2] - square) / spread;
  if (!(modulus > 0) || !(modulus < 1 - kRoundedModulus)) return HUGE_VAL;
  return 2 * std::comp_ellint_1(std::sqrt(modulus)) / rate;
}

}  // namespace

std::unique_ptr<ClosedForm> MakeFlip(const Fit& fit) {
  auto form = MakeSpin(fit);
  const layouts::ObjectState& object = fit.object(0);
  Vector3d inertia = object.solid.InertiaPerMass();
  const Vector3d spin = (object.pose.orientation.conjugate() * object.angular_velocity).cwiseAbs();
  int longest = 0;
  spin.maxCoeff(&longest);
  const double about = inertia[longest];
  std::sort(inertia.data(), inertia.data() + 3);
  if (about != inertia[1] || inertia[0] == inertia[1] || inertia[1] == inertia[2])
    fit.Refuse(
        fit.Name(0) + " does not rotate about its middle axis",
        "give it three different sides, and an angular_velocity mainly along the middle one");
  const double flips = FlipTime(object);
  if (!std::isfinite(flips))
    fit.Refuse(fit.Name(0) + " rotates about its middle axis only, and never turns over",
               "increase the other components of its angular_velocity a little");
  if (flips > fit.end())
    fit.Refuse(fmt::format("it turns over every {:.4g} s, and the run ends after {:.4g} s", flips,
                           fit.end()),
               "make the run longer, or increase the other components of its angular_velocity");
  return form;
}

std::unique_ptr<ClosedForm> MakeSpin(const Fit& fit) {
  fit.RequireOneObject();
  fit.RequireNoAcceleration();
  const layouts::ObjectState& object = fit.object(0);
  if (object.angular_velocity.isZero(0))
    fit.Refuse(fit.Name(0) + " does not spin", "give it an angular_velocity");
  fit.RequireClearOfWalls(0, ReachOf(object), object.pose.position, object.linear_velocity,
                          Vector3d::Zero(), fit.end());
  return std::make_unique<Spin>(fit);
}

}  // namespace cdb::closed_forms
