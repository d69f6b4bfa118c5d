// Lints about loads: stacks, objects directly above others, and the time needed to settle.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "compiler/lints/lint_facts.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::lints {
namespace {

using Eigen::Vector3d;

// Measured.
constexpr double kTallStack = 0.025, kMassRatio = 12, kNarrowFoot = 30, kOverlap = 0.3;
constexpr double kShortRun = 35;
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

}  // namespace

std::optional<Estimate> TallStack(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.HasWeight() || objects.stacked < 2) return std::nullopt;
  const double n = objects.tower;
  const double value =
      n * n * scene.g * scene.timestep * scene.timestep / (objects.least_side * scene.iterations);
  return Estimate{value, kTallStack, ShorterStepSquared(scene, value, kTallStack)};
}

/// For objects in one stack, for groups at known positions, of which the higher is the load, and
/// for the load of another group on a stack or pyramid. Heaps carry much higher ratios, and the
/// order of objects in them is random.
std::optional<Estimate> MassRatio(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.HasWeight()) return std::nullopt;
  const auto above = FixedPositionOf(objects);
  double ratio = 0;
  for (const GroupFacts& bearer : scene.groups) {
    if (!bearer.moves) continue;
    const auto below = FixedPositionOf(bearer);
    const bool in_one_stack = &objects == &bearer && objects.quantity > 1 && objects.stacked > 1;
    const bool is_above = &objects != &bearer && above && below && above->y() > below->y();
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
  if (!scene.HasWeight() || !scene.rests) return std::nullopt;
  double least_side = std::numeric_limits<double>::infinity();
  for (const GroupFacts& other : scene.groups) least_side = std::min(least_side, other.least_side);
  const double n = objects.stacked;
  const double value =
      std::sqrt(n * least_side / scene.g) * std::max(1.0, n / scene.iterations) / scene.Time();
  return Estimate{value, kShortRun, scene.cycles * Excess(value, kShortRun)};
}

// Lints about chains of objects: joints that open, springs that explode.

namespace {

// Measured.
constexpr double kHeavyEnd = 0.1, kStiffSpring = 2;

}  // namespace

/// The distance that joints open in one step, divided by the distance corrected in one step.
std::optional<Estimate> HeavyEnd(const SceneFacts& scene, const GroupFacts& objects) {
  if (!(scene.g > 0) || !objects.linked || objects.springs ||
      !objects.settings->On("links.anchor") || objects.quantity < 2)
    return std::nullopt;
  // The joints open no faster than the end falls.
  const bool open = scene.g * scene.Time() * scene.Time() < objects.least_side;
  const double sag = scene.g * scene.timestep * scene.timestep / objects.least_side;
  const double value = objects.load * sag / (scene.iterations * scene.world->Real("solver.erp"));
  return Estimate{value, kHeavyEnd, ShorterStepSquared(scene, value, kHeavyEnd), open};
}

/// The highest frequency of a chain of n equal masses is 2 sqrt(k/m) times a sine, and explicit
/// integration diverges if (w dt)^2 + 2 c dt / m exceeds 4.
std::optional<Estimate> StiffSpring(const SceneFacts& scene, const GroupFacts& objects) {
  if (!objects.springs) return std::nullopt;
  const double n = objects.quantity;
  const bool anchored = objects.settings->On("links.anchor");
  if (!anchored && n < 2) return std::nullopt;
  const double fastest =
      2 * std::sin(std::numbers::pi / 2 * (anchored ? (2 * n - 1) / (2 * n + 1) : (n - 1) / n));
  const double k = objects.settings->Real("links.stiffness");
  const double c = objects.settings->Real("links.damping");
  const double value =
      fastest * std::sqrt((k * scene.timestep + 2 * c) * scene.timestep / objects.mass.least);
  return Estimate{value, kStiffSpring, ShorterStep(scene, value, kStiffSpring)};
}

}  // namespace cdb::lints
