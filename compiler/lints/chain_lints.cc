// Lints about chains of objects: joints that open or lose energy, springs that explode.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "compiler/lints/lint_facts.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::lints {
namespace {

using Eigen::Vector3d;

// Measured.
constexpr double kHeavyEnd = 0.1, kStiffSpring = 2;
constexpr double kHangingChain = 0.2, kSwingingChain = 0.05, kBeam = 1e-3;
constexpr double kSwing = 3;
/// Of 222 random trees without weight in which a joint turns, 58 were beyond it, and 49 of them
/// gained more energy than the verdict permits; of 135 below a third of it, 9 did.
constexpr double kTumble = 0.2;
/// From here on, a chain that is let go aside of its anchor has lost a tenth of its energy.
constexpr double kCertainSwing = 8;

/// True for a chain of joints that is held at one end, in a field of gravity, by constraints.
bool IsHeldChain(const SceneFacts& scene, const GroupFacts& objects) {
  return scene.g > 0 && objects.chained && !objects.springs &&
         objects.settings->On("links.anchor") && scene.world->WordOr("coordinates") == "maximal";
}

/// True if the chain begins straight below its anchor.
bool Hangs(const SceneFacts& scene, const GroupFacts& objects) {
  if (objects.quantity < 2) return true;  // from a point above it
  const schema::Call* layout = schema::AsCall(objects.settings->Get("location"));
  if (layout == nullptr || layout->name != "line" || !scene.pull) return false;
  const Vector3d* given = schema::AsVector(schema::ArgumentOf(*layout, "along"));
  const Vector3d along = given != nullptr ? *given : Vector3d(0, -1, 0);
  constexpr double kStraight = 0.999;
  return along.normalized().dot(scene.pull->normalized()) > kStraight;
}

}  // namespace

/// The distance that joints open in one step, divided by the distance corrected in one step. Of 500
/// random chains and trees of joints that the world holds, with masses from 0.01 to 100 kg, all 117
/// beyond the limit came apart, 33 of 49 from a third of it to it, and 25 of 334 below.
std::optional<Estimate> HeavyEnd(const SceneFacts& scene, const GroupFacts& objects) {
  const bool is_end = IsHeldChain(scene, objects) && objects.quantity >= 2;
  const bool is_joined = scene.g > 0 && objects.joined_load > 0 &&
                         (!objects.is_load_open || (scene.has_ground && !scene.rests));
  if (!is_end && !is_joined) return std::nullopt;
  // The joints open no faster than the end falls.
  const bool open = scene.g * scene.Time() * scene.Time() < objects.least_side ||
                    (!is_end && objects.is_load_open);
  const double load = is_end ? objects.load : objects.joined_load;
  const double sag = scene.g * scene.timestep * scene.timestep / objects.least_side;
  const double value = load * sag / (scene.iterations * scene.world->Real("solver.erp"));
  return Estimate{value, kHeavyEnd, ShorterStepSquared(scene, value, kHeavyEnd), open};
}

/// The weight of n links, which the iterations pass on from joint to joint; a beam multiplies it by
/// its length.
std::optional<Estimate> LongChain(const SceneFacts& scene, const GroupFacts& objects) {
  if (!IsHeldChain(scene, objects) || objects.quantity < 2) return std::nullopt;
  const bool hangs = Hangs(scene, objects);
  const bool is_beam = !hangs && objects.settings->WordOr("links.type") == "fixed";
  const double n = is_beam ? std::pow(objects.quantity, 2) : objects.quantity;
  const double value =
      n * n * scene.g * scene.timestep * scene.timestep / (objects.least_side * scene.iterations);
  const double threshold = is_beam ? kBeam : hangs ? kHangingChain : kSwingingChain;
  // Within the time of a fall by its own length, a chain has not loaded its joints.
  const bool open = scene.g * scene.Time() * scene.Time() < objects.quantity * objects.least_side;
  return Estimate{value, threshold, ShorterStepSquared(scene, value, threshold), open};
}

/// Each step takes a part (w dt)^2 of the energy of a pendulum, more if it is a chain.
std::optional<Estimate> SwingingJoint(const SceneFacts& scene, const GroupFacts& objects) {
  if (!IsHeldChain(scene, objects) || !scene.only_contacts_take_energy ||
      objects.settings->WordOr("links.type") == "fixed")
    return std::nullopt;
  const bool hangs = Hangs(scene, objects);
  if (hangs && !(objects.speed > 0)) return std::nullopt;
  const double n = objects.quantity;
  const double length = objects.least_side * (n - 0.5);
  const double rate =
      std::max(std::sqrt(scene.g / length), objects.speed / length) * scene.timestep;
  const double value = scene.cycles * rate * rate * n * n;
  const bool open = hangs || value < kCertainSwing;
  return Estimate{value, kSwing, ShorterStep(scene, value, kSwing), open};
}

/// Coriolis and gyroscopic terms of the start of a step add a part (w dt)^2 of the energy in each.
std::optional<Estimate> TumblingTree(const SceneFacts& scene, const GroupFacts& objects) {
  const double turn = objects.tumble * scene.timestep;
  const double value = scene.cycles * turn * turn;
  return Estimate{value, kTumble, ShorterStep(scene, value, kTumble)};
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
