// Lints about motion in flight: spin, long distances in one step, and sleep.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "compiler/analysis/reference.h"
#include "compiler/lints/lint_facts.h"

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

/// About the axes of a box, in an arbitrary unit.
Vector3d InertiaOf(const GroupFacts& objects) {
  const Vector3d squares = objects.most_sides.cwiseAbs2();
  return Vector3d::Constant(squares.sum()) - squares;
}

/// The rate, 1/s, at which a deviation from a spin about the middle axis grows; 0 for other spins.
double GrowthOfTwist(const GroupFacts& objects) {
  const auto* spin = std::get_if<Vector3d>(&objects.settings->Get("angular_velocity"));
  if (spin == nullptr) return 0;
  const Vector3d inertia = InertiaOf(objects);
  int axis = 0;
  spin->cwiseAbs().maxCoeff(&axis);
  const double least = inertia.minCoeff(), most = inertia.maxCoeff();
  const double square = (most - inertia[axis]) * (inertia[axis] - least) / (least * most);
  return std::abs((*spin)[axis]) * std::sqrt(square);
}

/// The largest twist in `time` of the shapes that may be drawn. 0 about an axis of the body.
double Twist(const GroupFacts& objects, double time) {
  if (!(objects.spin > 0)) return 0;
  // The second moment of a cylinder is larger by 4/3 along its axis.
  const bool has_cylinders = MayBe(objects.settings->Get("type"), "cylinder");
  const double most =
      std::max(TwistOf(objects, 1), has_cylinders ? TwistOf(objects, 4.0 / 3) : 0.0);
  if (!(most > kRounding)) return 0;
  constexpr double kMostGrowth = 50;
  const double grown = most * std::exp(std::min(kMostGrowth, GrowthOfTwist(objects) * time));
  const double worst = 1 - InertiaOf(objects).minCoeff() / InertiaOf(objects).maxCoeff();
  return std::min(grown, std::max(most, worst));
}

}  // namespace

std::optional<Estimate> FastSpin(const SceneFacts& scene, const GroupFacts& objects) {
  // A motor may lack the effort to reach its speed.
  const bool is_driven = objects.driven_spin > objects.spin;
  const double value = std::max(objects.spin, objects.driven_spin) * scene.timestep;
  return Estimate{value, kFastSpin, ShorterStep(scene, value, kFastSpin), is_driven};
}

std::optional<Estimate> SpinDrift(const SceneFacts& scene, const GroupFacts& objects) {
  if (objects.linked) return std::nullopt;
  const double twist = Twist(objects, scene.Time());
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

namespace {

/// Of a ball that rolls down a slope, at 5/7 of the acceleration along it.
std::optional<Estimate> RollsSlowly(const SceneFacts& scene, const GroupFacts& objects) {
  if (!IsBall(objects) || !scene.HasWeight(objects) || !scene.pull) return std::nullopt;
  if (BoundsOf(*objects.settings, "rolling_friction").most > 0) return std::nullopt;
  const double along = std::hypot(scene.pull->x(), scene.pull->z());
  const double speed = objects.speed + 5.0 / 7 * along * kSleepAfter;
  if (!(along > 0)) return std::nullopt;
  const double slow = std::min(kSlowSpeed, kSlowSpin * objects.least_side / 2) / speed;
  if (slow < 1) return std::nullopt;
  const bool open = true;  // it may be held by other objects
  return Estimate{slow, 1, 0, open};
}

/// Of an object that nothing brakes on the floor: a ball, which rolls or spins, or any without
/// friction.
std::optional<Estimate> KeepsMoving(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.HasWeight(objects) || !scene.pull) return std::nullopt;
  const auto has = [&](const char* name) { return BoundsOf(*objects.settings, name).most > 0; };
  const bool resists = has("linear_damping") || has("angular_damping") || has("rolling_friction") ||
                       has("spinning_friction") || (!IsBall(objects) && has("friction"));
  if (resists) return std::nullopt;
  const double speed = std::hypot(objects.velocity.x(), objects.velocity.z());
  // Friction may turn all of the speed of a ball into rolling, and all of its spin into speed.
  const double spin = std::max(objects.spin, has("friction") ? 2 * speed / objects.least_side : 0);
  if (!(std::max(speed, spin) > 0)) return std::nullopt;
  const double slow = std::min(kSlowSpeed / speed, kSlowSpin / spin);
  if (slow < 1) return std::nullopt;
  const bool open = true;  // it may bounce, or meet others
  return Estimate{slow, 1, 0, open};
}

}  // namespace

std::optional<Estimate> EarlySleep(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.world->On("sleeping") || scene.Time() < kSleepAfter || (scene.rests && scene.g > 0))
    return std::nullopt;
  if (const auto rolling = RollsSlowly(scene, objects)) return rolling;
  if (const auto moving = KeepsMoving(scene, objects)) return moving;
  const double speed = objects.speed + scene.g * kSleepAfter;
  if (!(speed > 0 || objects.spin > 0)) return std::nullopt;
  // Objects that hit something earlier are not in flight.
  if (objects.may_touch && objects.speed * kSleepAfter > scene.side / 4 / std::cbrt(scene.count))
    return std::nullopt;
  const double slow = std::min(speed > 0 ? kSlowSpeed / speed : kInfinity,
                               objects.spin > 0 ? kSlowSpin / objects.spin : kInfinity);
  if (slow < 1) return std::nullopt;
  // Links may hold it, or another object may wake it.
  const bool open = objects.linked || (objects.may_touch && scene.count > 1);
  return Estimate{slow, 1, 0, open};
}

// Lints about rounding: positions, motion and masses below the resolution of the precision.

namespace {

// Measured.
constexpr double kCoarsePlace = 0.012, kLostMotion = 0.4, kLostFall = 0.3;
constexpr double kHeavySingle = 1.45e7, kHeavyDouble = 7e15;
/// Gravity is lost if its gain is below half a step; motion is wrong long before.
constexpr double kGainOverPlace = 0.2;
constexpr double kHopelesslyCoarse = 0.5;
/// The distance, in sides, that an object must move for its motion to count.
constexpr double kNoticed = 0.01;
/// The distance between neighbouring floating-point numbers at `value`.
double StepAt(double value, double epsilon) {
  return value > 0 ? std::exp2(std::floor(std::log2(value))) * epsilon : 0;
}

}  // namespace

std::optional<Estimate> CoarsePlace(const SceneFacts& scene, const GroupFacts& objects) {
  if (!objects.may_touch) return std::nullopt;
  const double place = objects.position.maxCoeff();
  const double coarse = StepAt(place, scene.epsilon) / objects.least_side;
  // At half a side, rounding alone moves an object by a quarter of it. Below, many objects stay in
  // place.
  const bool open = coarse < kHopelesslyCoarse;
  return Estimate{coarse, kCoarsePlace, place / Excess(coarse, kCoarsePlace), open};
}

std::optional<Estimate> LostMotion(const SceneFacts& scene, const GroupFacts& objects) {
  if (objects.linked) return std::nullopt;
  // Objects that hardly move lose nothing.
  const double noticed = kNoticed * 0.99 * objects.least_side;
  double worst = 0;
  bool open = false;
  Vector3d means = objects.velocity + scene.acceleration * scene.Time() / 2;
  Vector3d ways = means * scene.Time();
  if (scene.rests) {
    ways.setConstant(objects.gap);
    means = means.cwiseMin(4 * (scene.acceleration * objects.gap / 2).cwiseSqrt());
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double mean = means[axis], way = ways[axis];
    if (!(way > noticed) || !(mean > 0)) continue;
    const double step = StepAt(objects.position[axis], scene.epsilon);
    // Relative to the whole motion: losses in a slow component do not matter.
    const double lost = step / (means.maxCoeff() * scene.timestep);
    // An object that starts within a few steps of its support may not fall.
    if (lost > worst) open = scene.rests && way < 3 * step;
    worst = std::max(worst, lost);
    if (scene.acceleration[axis] > 0)
      worst = std::max(worst, kGainOverPlace * StepAt(mean, scene.epsilon) /
                                  (scene.acceleration[axis] * scene.timestep));
  }
  const double place = objects.position.maxCoeff();
  return Estimate{worst, kLostMotion, place / Excess(worst, kLostMotion), open};
}

/// For objects that fall from rest.
std::optional<Estimate> LostFall(const SceneFacts& scene, const GroupFacts& objects) {
  if (!(scene.g > 0) || scene.rests || objects.linked || objects.speed > 0) return std::nullopt;
  const double noticed = kNoticed * objects.least_side;
  // Objects on the floor do not fall.
  if (scene.has_walls && scene.FallHeight(objects) <= noticed) return std::nullopt;
  const double way = std::max(noticed, scene.g * scene.timestep * scene.timestep);
  // Along the axes of the fall.
  double place = 0;
  for (int axis = 0; axis < 3; ++axis)
    if (scene.acceleration[axis] > kNoticed * scene.g)
      place = std::max(place, objects.position[axis]);
  const double value = StepAt(place, scene.epsilon) / way;
  return Estimate{value, kLostFall, place / Excess(value, kLostFall)};
}

std::optional<Estimate> HeavyMass(const SceneFacts& scene, const GroupFacts& objects) {
  if (!objects.may_touch) return std::nullopt;
  const double limit = scene.is_single ? kHeavySingle : kHeavyDouble;
  return Estimate{objects.mass.most, limit, Harmless(limit)};
}

}  // namespace cdb::lints
