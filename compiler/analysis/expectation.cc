#include "compiler/analysis/expectation.h"

#include <fmt/format.h>

#include <algorithm>
#include <variant>

#include "compiler/analysis/joints.h"
#include "compiler/analysis/population.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/standing.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"

namespace cdb::analysis {
namespace {

using schema::IsZero;

bool IsDriven(const plan::Scene& scene) { return !DriverText(scene).empty(); }

/// The reason why the settings of the scene do not make it rest.
std::optional<std::string> WhyMayMove(const plan::Scene& scene) {
  const auto* down = std::get_if<Eigen::Vector3d>(&scene.world.Get("acceleration"));
  if (scene.ObjectCount() == 0) return "there are no objects";
  if (down == nullptr || !(down->y() < 0 && down->x() == 0 && down->z() == 0))
    return "gravity does not point straight down";
  if (scene.world.WordOr("world.walls") == "none") return "there are no walls";
  if (!Collisions(scene).AllMayTouch()) return "some objects cannot touch others";
  for (const plan::Group& group : scene.groups) {
    if (group.settings.Count("quantity") == 0) continue;
    if (!Stands(group) && !StandsOnOthers(scene, group)) {
      const schema::Call* layout = schema::AsCall(group.settings.Get("location"));
      return fmt::format("group {} is placed by {}{}", group.name,
                         layout != nullptr ? std::string_view(layout->name)
                                           : group.settings.WordOr("location", "coordinates"),
                         IsInBox(group.settings) ? " in a region" : "");
    }
    if (!IsZero(group.settings.Get("linear_velocity")) ||
        !IsZero(group.settings.Get("angular_velocity")))
      return fmt::format("group {} moves at the start", group.name);
    if (HasPush(group)) return fmt::format("a force or a torque acts on group {}", group.name);
  }
  if (const plan::Joint* joint = FindTorqueMotor(scene)) return "a motor drives " + TextOf(*joint);
  return std::nullopt;
}

/// Bullet multiplies the friction and the restitution of both sides of a contact.
bool KeepsEnergy(const plan::Scene& scene) {
  if (scene.world.WordOr("world.walls") != "none" &&
      scene.world.Real("world.wall_restitution") != 1)
    return false;
  return std::ranges::all_of(scene.groups, [](const plan::Group& group) {
    const schema::Number* bounce = schema::AsNumber(group.settings.Get("restitution"));
    return bounce != nullptr && bounce->AsReal() == 1 && IsZero(group.settings.Get("friction")) &&
           IsZero(group.settings.Get("rolling_friction")) &&
           IsZero(group.settings.Get("spinning_friction")) &&
           group.settings.WordOr("contact_stiffness") == "rigid";
  });
}

}  // namespace

std::string_view ExpectationName(Expectation expectation) {
  constexpr std::string_view kNames[] = {"anything", "rest", "energy", "driven"};
  return kNames[static_cast<std::size_t>(expectation)];
}

Expectation ExpectationOf(const plan::Scene& scene) {
  if (IsDriven(scene)) return Expectation::kDriven;
  const std::string_view said = scene.world.WordOr("expect");
  if (said == "anything") return Expectation::kAnything;
  if (said == "rest") return Expectation::kRest;
  if (said == "energy") return Expectation::kEnergy;
  CDB_CHECK(said == "auto");
  if (!WhyMayMove(scene)) return Expectation::kRest;
  if (KeepsEnergy(scene) && FliesFreely(scene)) return Expectation::kEnergy;
  return Expectation::kAnything;
}

bool Stands(const plan::Group& group) {
  const schema::Call* layout = schema::AsCall(group.settings.Get("location"));
  return layout != nullptr && !IsInBox(group.settings) &&
         (layout->name == "stack" || layout->name == "pyramid" || layout->name == "pile");
}

std::optional<std::string> WhyNotAtRest(const plan::Scene& scene) {
  if (std::string driver = DriverText(scene); !driver.empty()) return driver;
  const std::string_view said = scene.world.WordOr("expect");
  if (said == "rest") return std::nullopt;
  if (said != "auto") return fmt::format("the scene says expect {}", said);
  return WhyMayMove(scene);
}

std::string DriverText(const plan::Scene& scene) {
  if (schema::AsCall(scene.world.Get("acceleration")) != nullptr)
    return "a schedule changes the acceleration";
  for (const plan::Group& group : scene.groups) {
    // Kinematic objects do work on the objects that they push.
    if (HasKinematic(group)) return fmt::format("group {} is kinematic", group.name);
    if (HasDrivenPins(group)) return fmt::format("pins move the nodes of group {}", group.name);
    if (HasSchedule(group)) return fmt::format("a schedule moves group {}", group.name);
  }
  if (const plan::Joint* joint = FindMotor(scene)) return "a motor drives " + TextOf(*joint);
  if (const plan::Group* group = FindChanging(scene))
    return fmt::format("the objects of group {} come and go", group->name);
  return {};
}

bool FliesFreely(const plan::Scene& scene) {
  return !IsDriven(scene) && FindLosses(scene) == nullptr &&
         std::ranges::all_of(scene.groups, [](const plan::Group& group) {
           return IsZero(group.settings.Get("linear_damping")) &&
                  IsZero(group.settings.Get("angular_damping")) &&
                  (group.settings.WordOr("links.type") != "spring" ||
                   IsZero(group.settings.Get("links.damping")));
         });
}

namespace {

bool Allows(const plan::Group& group, std::string_view name) {
  return group.settings.Lists("collides_with", "all") ||
         group.settings.Lists("collides_with", name);
}

}  // namespace

Collisions::Collisions(const plan::Scene& scene) {
  const std::vector<plan::Group>& groups = scene.groups;
  for (const plan::Group& a : groups) {
    walls_.push_back(Allows(a, kWallsWord));
    for (const plan::Group& b : groups) touches_.push_back(Allows(a, b.name) && Allows(b, a.name));
  }
  std::vector<std::size_t> firsts;  // the first group of each class
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const auto same =
        std::ranges::find_if(firsts, [&](std::size_t first) { return AreAlike(i, first); });
    classes_.push_back(static_cast<std::size_t>(same - firsts.begin()));
    if (same == firsts.end()) firsts.push_back(i);
  }
  class_count_ = firsts.size();
}

bool Collisions::AreAlike(std::size_t group, std::size_t other) const {
  if (walls_[group] != walls_[other]) return false;
  for (std::size_t i = 0; i < walls_.size(); ++i)
    if (MayTouch(group, i) != MayTouch(other, i)) return false;
  return true;
}

namespace {

bool MayBeKinematic(const schema::Value& mass) {
  if (const schema::Word* word = schema::AsWord(mass)) return word->text == kKinematicWord;
  const schema::Distribution* drawn = schema::AsDistribution(mass);
  return drawn != nullptr && std::ranges::any_of(drawn->arguments, MayBeKinematic);
}

}  // namespace

bool HasSchedule(const plan::Group& group) {
  return schema::AsCall(group.settings.Get("linear_velocity")) != nullptr ||
         schema::AsCall(group.settings.Get("angular_velocity")) != nullptr;
}

bool HasPush(const plan::Group& group) {
  return group.settings.Count("quantity") > 0 &&
         (!IsZero(group.settings.Get("force")) || !IsZero(group.settings.Get("torque")));
}

bool HasKinematic(const plan::Group& group) {
  return group.settings.Count("quantity") > 0 && MayBeKinematic(group.settings.Get("mass"));
}

}  // namespace cdb::analysis
