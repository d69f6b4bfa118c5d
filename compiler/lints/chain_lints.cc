// Lints about chains of objects: joints that open, springs that explode.
#include <cmath>
#include <numbers>

#include "compiler/lints/lint_formulae.h"

namespace cdb::lints {
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
