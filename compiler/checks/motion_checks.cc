// Settings that kinematic objects cannot have, those that only they can have, and those of
// surfaces, which cannot move.
#include <fmt/format.h>

#include "compiler/analysis/kinematic.h"
#include "compiler/analysis/poses.h"
#include "compiler/analysis/surface.h"
#include "compiler/checks/scene_checks.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::checks {
namespace {

struct MotionFault {
  schema::GroupParameter parameter;
  std::string message, help;
};

/// Bullet's treatment of a margin differs from shape to shape.
std::optional<MotionFault> FindMarginFault(const plan::Group& group) {
  // The default means no margin here.
  if (!group.settings.Has(*schema::GroupParameter("margin"))) return std::nullopt;
  const schema::Value& given = group.settings.Get("margin");
  return MotionFault{"margin",
                     fmt::format("a surface has no margin, but that of {} is {}", group.name,
                                 schema::ToText(given)),
                     "remove the margin"};
}

std::optional<MotionFault> FindMotionFault(const plan::Group& group) {
  const plan::GroupSettings& settings = group.settings;
  if (settings.Count("quantity") == 0) return std::nullopt;
  if (analysis::HasSurface(settings) && settings.WordOr("mass") != "fixed")
    return MotionFault{
        settings.WordOr("mass") == analysis::kKinematicWord ? schema::GroupParameter("mass")
                                                            : schema::GroupParameter("type"),
        fmt::format("a surface has no inside and does not move, but the mass of {} is {}",
                    group.name, schema::ToText(settings.Get("mass"))),
        "write mass fixed, or type mesh(…) for a solid that moves"};
  if (analysis::HasSurface(settings))
    if (auto fault = FindMarginFault(group)) return fault;
  if (analysis::PathOf(group) != nullptr && settings.WordOr("mass") != analysis::kKinematicWord)
    return MotionFault{
        "location",
        fmt::format("only a kinematic object can move along a path, but the mass of {} is {}",
                    group.name, schema::ToText(settings.Get("mass"))),
        "write mass kinematic"};
  if (!analysis::HasKinematic(group)) return std::nullopt;
  for (const auto parameter :
       {schema::GroupParameter("linear_velocity"), schema::GroupParameter("angular_velocity")})
    if (const schema::Call* schedule = schema::AsCall(settings.Get(parameter)))
      return MotionFault{
          parameter,
          fmt::format("'{}' changes a velocity, but kinematic objects keep theirs", schedule->name),
          "write one velocity, or their motion in a file: location path(\"motion.csv\")"};
  const schema::Call* layout = schema::AsCall(settings.Get("location"));
  if (layout != nullptr && layout->name == "pile")
    return MotionFault{
        "location", fmt::format("the {} are kinematic and cannot settle into a pile", group.name),
        "give them a mass, or another location"};
  return std::nullopt;
}

}  // namespace

bool SceneChecks::CheckMotion(configure::Configuration& configuration, const plan::Scene& scene) {
  bool good = true;
  for (const plan::Group& group : scene.groups) {
    const auto fault = FindMotionFault(group);
    if (!fault) continue;
    good = false;
    if (misplaced_.emplace(group.name, fault->message).second)
      diagnostics_.Report(scenario::kContradiction,
                          configuration.SpanOf({group.name, fault->parameter.get()}, benchmark_),
                          fault->message, fault->help);
  }
  return good;
}

}  // namespace cdb::checks
