// Lints about what objects bear: stacks, objects right above others, and the time they take to
// settle.
#include <algorithm>
#include <cmath>
#include <limits>

#include "compiler/checks/lint_formulae.h"

namespace cdb::checks {
namespace {

using Eigen::Vector3d;

// Measured.
constexpr double kTallStack = 0.025, kMassRatio = 12, kNarrowFoot = 30, kOverlap = 0.3;
constexpr double kShortRun = 35;

}  // namespace

std::optional<Estimate> TallStack(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.HasWeight() || objects.stacked < 2) return std::nullopt;
  const double n = objects.tower;
  const double value =
      n * n * scene.g * scene.timestep * scene.timestep / (objects.least_side * scene.iterations);
  return Estimate{value, kTallStack, ShorterStepSquared(scene, value, kTallStack)};
}

/// Of objects in one stack, and of groups at known positions of which the higher one is the load.
/// Heaps bear much higher ratios, and which object lies on which is chance.
std::optional<Estimate> MassRatio(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.HasWeight()) return std::nullopt;
  const auto above = FixedPositionOf(objects);
  double ratio = 0;
  for (const GroupFacts& bearer : scene.groups) {
    if (!bearer.moves) continue;
    const auto below = FixedPositionOf(bearer);
    const bool in_one_stack = &objects == &bearer && objects.quantity > 1 && objects.stacked > 1;
    const bool is_above = &objects != &bearer && above && below && above->y() > below->y();
    if (in_one_stack || is_above)
      ratio = std::max(ratio, objects.mass.most / bearer.mass.least / scene.iterations);
  }
  return Estimate{ratio, kMassRatio, scene.iterations * Excess(ratio, kMassRatio)};
}

/// Of groups at known positions, one right above the other.
std::optional<Estimate> NarrowFoot(const SceneFacts& scene, const GroupFacts& objects) {
  const auto above = FixedPositionOf(objects);
  if (!(scene.g > 0) || !scene.rests || !above) return std::nullopt;
  double narrowest = std::numeric_limits<double>::infinity();
  for (const GroupFacts& foot : scene.groups) {
    const auto below = FixedPositionOf(foot);
    if (!below || above->y() <= below->y()) continue;
    const Vector3d aside = (*above - *below).cwiseAbs(), half = foot.most_sides / 2;
    if (aside.x() > half.x() || aside.z() > half.z()) continue;
    narrowest = std::min({narrowest, foot.most_sides.x(), foot.most_sides.z()});
  }
  const double value = std::min(objects.most_sides.x(), objects.most_sides.z()) / narrowest;
  return Estimate{value, kNarrowFoot, narrowest * Excess(value, kNarrowFoot)};
}

std::optional<Estimate> Overlap(const SceneFacts&, const GroupFacts& objects) {
  if (objects.linked || objects.quantity < 2) return std::nullopt;
  const double value = objects.overlap / objects.least_side;
  return Estimate{value, kOverlap, objects.overlap / Excess(value, kOverlap)};
}

std::optional<Estimate> ShortRun(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.HasWeight() || !scene.rests) return std::nullopt;
  double least_side = std::numeric_limits<double>::infinity();
  for (const GroupFacts& other : scene.groups) least_side = std::min(least_side, other.least_side);
  const double n = objects.stacked;
  const double value =
      std::sqrt(n * least_side / scene.g) * std::max(1.0, n / scene.iterations) / scene.Time();
  return Estimate{value, kShortRun, scene.cycles * Excess(value, kShortRun)};
}

}  // namespace cdb::checks
