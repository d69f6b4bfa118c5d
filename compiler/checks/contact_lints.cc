// Lints about contacts: too deep, too soft, or missed between two steps.
#include "compiler/checks/lint_formulae.h"
#include "compiler/plan/engine_constants.h"

namespace cdb::checks {
namespace {

using Eigen::Vector3d;

// Measured.
constexpr double kLongStepOnPlane = 0.04, kLongStepOnBox = 0.3;
constexpr double kThinWall = 1.5, kFastHit = 2, kSoftContact = 0.04, kThinShape = 30;

bool IsAlongOneAxis(const Vector3d& v) { return (v.array() != 0).count() <= 1; }

bool IsBall(const GroupFacts& objects) {
  const auto* type = std::get_if<schema::Word>(&objects.settings->Get("type"));
  return type != nullptr && type->text == "sphere" && objects.least_side == objects.longest_side;
}

}  // namespace

std::optional<Estimate> LongStep(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.HasWeight()) return std::nullopt;
  const double value = scene.g * scene.timestep * scene.timestep / objects.least_side;
  const double threshold =
      !scene.has_walls || scene.has_box_walls ? kLongStepOnBox : kLongStepOnPlane;
  return Estimate{value, threshold, ShorterStepSquared(scene, value, threshold)};
}

std::optional<Estimate> ThinWall(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.has_box_walls || MayBeOn(objects, "ccd")) return std::nullopt;
  // Walls stand across the axes.
  const double value = scene.FastestComponent(objects) * scene.timestep /
                       (objects.least_side + plan::kWallThickness * scene.side);
  return Estimate{value, kThinWall, ShorterStep(scene, value, kThinWall)};
}

std::optional<Estimate> FastHit(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.MayTouch() || MayBeOn(objects, "ccd")) return std::nullopt;
  // Falling or hitting head-on does not spin a ball.
  const bool is_ball = IsBall(objects);
  if (is_ball && scene.count == 1 && IsAlongOneAxis(objects.velocity)) return std::nullopt;
  const double speed = is_ball ? objects.velocity.maxCoeff() : scene.FastestComponent(objects);
  const double value = speed * scene.timestep / objects.least_side;
  // Objects that do not cross the room may hit nothing.
  const bool open = speed * scene.Time() < scene.side;
  return Estimate{value, kFastHit, ShorterStep(scene, value, kFastHit), open};
}

std::optional<Estimate> SoftContact(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.HasWeight()) return std::nullopt;
  const double softest = PositiveBounds(objects.settings->Get("contact_stiffness")).least;
  if (!(softest > 0)) return std::nullopt;
  const double sinks = objects.stacked * objects.mass.most * scene.g / softest;
  // Half of the scenes come to rest in which the damper is stronger than the spring.
  const double damper = PositiveBounds(objects.settings->Get("contact_damping")).least;
  const bool open = damper * damper > 4 * softest * objects.mass.most;
  return Estimate{sinks, kSoftContact, softest * Excess(sinks, kSoftContact), open};
}

std::optional<Estimate> ThinShape(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.MayTouch()) return std::nullopt;
  const schema::Value& type = objects.settings->Get("type");
  const bool is_round = MayBe(type, "sphere") && objects.least_side == objects.longest_side;
  if (is_round) return std::nullopt;
  // Contacts with planes are found without GJK.
  if (scene.count < 2 && !scene.has_box_walls) return std::nullopt;
  // The depth of contacts becomes wrong, and only some runs fail of it.
  const bool open = true;
  return Estimate{objects.longest_side / objects.least_side, kThinShape, Harmless(kThinShape),
                  open};
}

}  // namespace cdb::checks
