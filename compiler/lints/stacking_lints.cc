// Lints about loads: stacks, objects directly above others, and the time needed to settle.

#include <algorithm>
#include <cmath>
#include <limits>

#include "compiler/analysis/reference.h"
#include "compiler/lints/lint_facts.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::lints {
namespace {

using Eigen::Vector3d;

// Measured.
constexpr double kTallStack = 0.025, kLeaningStack = 0.02, kMassRatio = 12, kNarrowFoot = 30,
                 kOverlap = 0.3;
constexpr double kShortRun = 35, kCreep = 0.25;
/// m/s; boxes at rest creep by up to this in single precision, with any time step, acceleration
/// and number of iterations. Measured.
constexpr double kCreepSpeed = 5e-4;
/// A stack of n objects carries a load worse than one object by this times n. Measured.
constexpr double kLoadedStack = 0.6;

/// The coordinate nearest to `at` on one axis of the square lattice of a stack's columns.
double NearestColumn(double at, double edge, double spacing) {
  const double first = -(edge - 1) / 2;
  return spacing * (first + std::clamp(std::round(at / spacing - first), 0.0, edge - 1));
}

/// True if a known position is above a group that stands on the floor: over one of its columns, as
/// nothing overlaps.
bool IsOverStanding(const Vector3d& above, const GroupFacts& load, const GroupFacts& bearer) {
  const schema::Call* layout = schema::AsCall(bearer.settings->Get("location"));
  if (layout == nullptr || (layout->name != "stack" && layout->name != "pyramid")) return false;
  const Vector3d reach = (load.most_sides + bearer.most_sides) / 2;
  double edge = 1, spacing = 1;
  Vector3d column_reach = reach;
  if (layout->name == "pyramid") {
    // Its base is as many objects wide as the pyramid is high.
    column_reach += (bearer.stacked - 1) / 2 * (bearer.most_sides + Vector3d::Constant(bearer.gap));
  } else {
    edge = std::ceil(std::sqrt(std::ceil(bearer.quantity / bearer.stacked)));
    const schema::Number* given = schema::AsNumber(schema::ArgumentOf(*layout, "spacing"));
    spacing = given != nullptr ? given->AsReal()
                               : 1.5 * std::max(bearer.most_sides.x(), bearer.most_sides.z());
  }
  return std::abs(above.x() - NearestColumn(above.x(), edge, spacing)) < column_reach.x() &&
         std::abs(above.z() - NearestColumn(above.z(), edge, spacing)) < column_reach.z();
}

/// True if a listed object is above one of the other group.
bool IsOver(const GroupFacts& load, const GroupFacts& bearer) {
  const Vector3d reach = (load.most_sides + bearer.most_sides) / 2;
  return std::ranges::any_of(load.places, [&](const Vector3d& above) {
    return std::ranges::any_of(bearer.places, [&](const Vector3d& below) {
      return above.y() > below.y() && std::abs(above.x() - below.x()) < reach.x() &&
             std::abs(above.z() - below.z()) < reach.z();
    });
  });
}

}  // namespace

std::optional<Estimate> TallStack(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.HasWeight(objects) || objects.stacked < 2) return std::nullopt;
  const double n = objects.tower;
  const double value =
      n * n * scene.g * scene.timestep * scene.timestep / (objects.least_side * scene.iterations);
  return Estimate{value, kTallStack, ShorterStepSquared(scene, value, kTallStack)};
}

/// For stacks that should stay although the pull is not straight down.
std::optional<Estimate> LeaningStack(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.HasWeight(objects) || objects.stacked < 2 || !scene.rests || !scene.pull)
    return std::nullopt;
  const double aside = std::hypot(scene.pull->x(), scene.pull->z()) / scene.g, n = objects.tower;
  const double value = n * n * aside * scene.timestep * std::sqrt(scene.g / objects.least_side);
  const bool open = true;  // measured for cubes; wider boxes may hold
  return Estimate{value, kLeaningStack, ShorterStep(scene, value, kLeaningStack), open};
}

/// For objects in one stack, for listed objects of which one is above the other, and for the load
/// of another group on a stack or pyramid. Heaps carry much higher ratios, and the
/// order of objects in them is random.
std::optional<Estimate> MassRatio(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.HasWeight(objects)) return std::nullopt;
  const auto above = FixedPositionOf(objects);
  double ratio = 0;
  for (const GroupFacts& bearer : scene.groups) {
    if (!bearer.moves || !scene.collisions->MayTouch(objects.index, bearer.index)) continue;
    const bool in_one_stack = &objects == &bearer && objects.quantity > 1 && objects.stacked > 1;
    const bool is_above = &objects != &bearer && IsOver(objects, bearer);
    const bool is_on_stack =
        &objects != &bearer && above && IsOverStanding(*above, objects, bearer);
    if (!in_one_stack && !is_above && !is_on_stack) continue;
    const double worse = is_on_stack ? std::max(1.0, kLoadedStack * bearer.stacked) : 1;
    ratio = std::max(ratio, worse * objects.mass.most / bearer.mass.least / scene.iterations);
  }
  return Estimate{ratio, kMassRatio, scene.iterations * Excess(ratio, kMassRatio)};
}

/// For groups at known positions, one directly above the other.
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
  if (!scene.HasWeight(objects) || !scene.rests) return std::nullopt;
  double least_side = std::numeric_limits<double>::infinity();
  for (const GroupFacts& other : scene.groups) least_side = std::min(least_side, other.least_side);
  const double n = objects.stacked;
  const double value =
      std::sqrt(n * least_side / scene.g) * std::max(1.0, n / scene.iterations) / scene.Time();
  return Estimate{value, kShortRun, scene.cycles * Excess(value, kShortRun)};
}

std::optional<Estimate> Creep(const SceneFacts& scene, const GroupFacts& objects) {
  const bool is_round = MayBe(objects.settings->Get("type"), "sphere");
  if (!scene.is_single || !scene.rests || is_round || !scene.HasWeight(objects))
    return std::nullopt;
  const double time =
      scene.world->On("sleeping") ? std::min(scene.Time(), analysis::kSleepAfter) : scene.Time();
  const double value = kCreepSpeed * time / objects.least_side;
  // Some boxes stay where they are.
  const bool open = true;
  return Estimate{value, kCreep, objects.least_side * Excess(value, kCreep), open};
}

}  // namespace cdb::lints
