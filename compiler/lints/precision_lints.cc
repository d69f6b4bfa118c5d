// Lints about rounding: positions, motion and masses below the resolution of the precision.
#include <algorithm>
#include <cmath>

#include "compiler/lints/lint_formulae.h"

namespace cdb::lints {
namespace {

using Eigen::Vector3d;

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
  if (!scene.MayTouch()) return std::nullopt;
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
  const double place = objects.position.maxCoeff();
  const double value = StepAt(place, scene.epsilon) / way;
  return Estimate{value, kLostFall, place / Excess(value, kLostFall)};
}

std::optional<Estimate> HeavyMass(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.MayTouch()) return std::nullopt;
  const double limit = scene.is_single ? kHeavySingle : kHeavyDouble;
  return Estimate{objects.mass.most, limit, Harmless(limit)};
}

}  // namespace cdb::lints
