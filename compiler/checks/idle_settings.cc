#include "compiler/checks/idle_settings.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/analysis/expectation.h"
#include "compiler/analysis/kinematic.h"
#include "compiler/analysis/poses.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::checks {
namespace {

using schema::IsZero;

bool IsStill(const plan::Group& group) {
  return analysis::PathOf(group) == nullptr && IsZero(group.settings.Get("linear_velocity")) &&
         IsZero(group.settings.Get("angular_velocity"));
}

}  // namespace

void IdleSettings::Look(configure::Configuration& configuration, const scenario::ParameterKey& key,
                        bool is_idle, const std::string& message, const std::string& help) {
  if (!configuration.IsSet(key)) return;
  if (!is_idle)
    useful_.insert(key);
  else if (!idle_.contains(key))
    idle_.emplace(key, Finding{configuration.SpanOf(key, benchmark_), message, help});
}

void IdleSettings::Add(configure::Configuration& configuration, const plan::Scene& scene) {
  for (const plan::Group& group : scene.groups) {
    if (group.settings.Count("quantity") == 0) continue;
    for (const auto velocity :
         {schema::GroupParameter("linear_velocity"), schema::GroupParameter("angular_velocity")}) {
      if (IsZero(group.settings.Get(velocity))) continue;
      Look(configuration, {group.name, velocity.get()}, group.settings.WordOr("mass") == "fixed",
           fmt::format("'{}' is fixed, and {} does not move it", group.name, velocity.name()),
           "remove it, or write mass kinematic: such objects move with their velocity, whatever "
           "they meet");
    }
    if (analysis::HasKinematic(group))
      Look(configuration, {group.name, schema::GroupParameter("mass").get()}, IsStill(group),
           fmt::format("'{}' is kinematic, and nothing moves it", group.name),
           "give it a velocity that is not 0, or location path(\"motion.csv\"); or write mass "
           "fixed");
  }
  // These have a warning already.
  if (std::ranges::any_of(scene.groups, [](const plan::Group& group) {
        return analysis::HasKinematic(group) && IsStill(group);
      }))
    return;
  const std::string_view said = scene.world.WordOr("expect");
  if (said == "rest" || said == "energy")
    Look(configuration, {"", schema::WorldParameter("expect").get()},
         analysis::ExpectationOf(scene) == analysis::Expectation::kDriven,
         fmt::format("'expect {}' has no effect here: a schedule or kinematic objects drive the "
                     "scene, so that {}",
                     said,
                     said == "rest" ? "it need not rest" : "its energy may change at any time"),
         "remove it");
}

void IdleSettings::Report() const {
  for (const auto& [key, finding] : idle_)
    if (!useful_.contains(key))
      diagnostics_.Report(scenario::kNoEffect, finding.span, finding.message, finding.help);
}

}  // namespace cdb::checks
