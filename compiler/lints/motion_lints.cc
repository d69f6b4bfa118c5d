// Lints about motion in flight: spin, long distances in one step, and sleep.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "compiler/analysis/engine_constants.h"
#include "compiler/lints/lint_formulae.h"

namespace cdb::lints {
namespace {

using analysis::kSleepAfter;
using analysis::kSlowSpeed;
using analysis::kSlowSpin;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Measured.
constexpr double kFastSpin = 1.41, kSpinDrift = 0.05;
constexpr double kRounding = 1e-9;

/// The rate at which a free spin changes its direction in the body, divided by the spin: |w x Iw| /
/// (|w| |Iw|), for a body whose second moment along y is `along_y` times that of a box.
double TwistOf(const GroupFacts& objects, double along_y) {
  // Second moments are proportional to the squares of the sides.
  Vector3d squares = objects.most_sides.cwiseAbs2();
  if (objects.least_side < objects.most_sides.minCoeff()) squares.x() /= 2;  // separate draws
  squares.y() *= along_y;
  const Vector3d inertia = Vector3d::Constant(squares.sum()) - squares;
  const auto* turn = std::get_if<Vector3d>(&objects.settings->Get("orientation"));
  const auto* spin = std::get_if<Vector3d>(&objects.settings->Get("angular_velocity"));
  if (turn == nullptr || !turn->isZero(0) || spin == nullptr)
    return 1 - inertia.minCoeff() / inertia.maxCoeff();
  const Vector3d momentum = inertia.cwiseProduct(*spin);
  return spin->cross(momentum).norm() / (spin->norm() * momentum.norm());
}

/// The largest twist of the shapes that may be drawn. 0 about an axis of the body.
double Twist(const GroupFacts& objects) {
  if (!(objects.spin > 0)) return 0;
  // The second moment of a cylinder is larger by 4/3 along its axis.
  const bool has_cylinders = MayBe(objects.settings->Get("type"), "cylinder");
  const double most =
      std::max(TwistOf(objects, 1), has_cylinders ? TwistOf(objects, 4.0 / 3) : 0.0);
  return most > kRounding ? most : 0;
}

}  // namespace

std::optional<Estimate> FastSpin(const SceneFacts& scene, const GroupFacts& objects) {
  const double value = objects.spin * scene.timestep;
  return Estimate{value, kFastSpin, ShorterStep(scene, value, kFastSpin)};
}

std::optional<Estimate> SpinDrift(const SceneFacts& scene, const GroupFacts& objects) {
  if (objects.linked) return std::nullopt;
  const double twist = Twist(objects);
  if (!(twist > 0)) return std::nullopt;
  const double turn = objects.spin * scene.timestep;
  // The fraction of the spin in the energy by which the verdict scales drift.
  const double spin = std::pow(objects.spin * objects.longest_side, 2) / 20;
  const double rest = objects.speed * objects.speed / 2 + scene.g * scene.side;
  const double value = scene.cycles * turn * turn * twist * twist * spin / (spin + rest);
  // Shorter steps need more cycles, so the number is proportional to the step, not to its square.
  return Estimate{value, kSpinDrift, ShorterStep(scene, value, kSpinDrift)};
}

std::optional<Estimate> HugeBox(const SceneFacts& scene, const GroupFacts& objects) {
  const double box = objects.most_sides.norm() + scene.FastestSpeed(objects) * scene.timestep;
  return Estimate{box, analysis::kLargestBox, Harmless(analysis::kLargestBox)};
}

std::optional<Estimate> EarlySleep(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.world->On("sleeping") || scene.Time() < kSleepAfter || (scene.rests && scene.g > 0))
    return std::nullopt;
  const double speed = objects.speed + scene.g * kSleepAfter;
  if (!(speed > 0 || objects.spin > 0)) return std::nullopt;
  // Objects that hit something earlier are not in flight.
  if (scene.MayTouch() && objects.speed * kSleepAfter > scene.side / 4 / std::cbrt(scene.count))
    return std::nullopt;
  const double slow = std::min(speed > 0 ? kSlowSpeed / speed : kInfinity,
                               objects.spin > 0 ? kSlowSpin / objects.spin : kInfinity);
  if (slow < 1) return std::nullopt;
  // Another object may wake it.
  const bool open = scene.MayTouch() && scene.count > 1;
  return Estimate{slow, 1, 0, open};
}

}  // namespace cdb::lints
