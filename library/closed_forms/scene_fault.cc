#include "library/closed_forms/scene_fault.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/analysis/model.h"
#include "compiler/analysis/reference.h"
#include "compiler/analysis/trace.h"
#include "compiler/plan/input_file.h"
#include "compiler/schema/parametrised_words.h"
#include "library/closed_forms/closed_form.h"
#include "library/layouts/exact_layouts.h"
#include "library/layouts/number_range.h"
#include "library/layouts/placement.h"
#include "library/layouts/region.h"
#include "library/objects/solid_factory.h"
#include "library/scene_error.h"

namespace cdb::closed_forms {
namespace {

/// False if a type names a file that is not here: the compiler may have read it elsewhere.
bool AreFilesHere(const plan::Group& group) {
  return std::ranges::none_of(analysis::TypesOf(group.settings), [](const schema::Value& type) {
    const schema::Call* call = schema::AsCall(type);
    return call != nullptr &&
           std::ranges::any_of(schema::FilesOf(*call), [](std::string_view file) {
             return !plan::WhyNotReadable(std::string(file)).empty();
           });
  });
}

/// True if no object of the group needs a decomposition, which takes seconds.
bool IsMadeAtOnce(const plan::Group& group) {
  return AreFilesHere(group) &&
         std::ranges::none_of(analysis::TypesOf(group.settings), objects::IsDecomposed);
}

/// Bullet sweeps only convex shapes.
void CheckCcd(const plan::Scene& scene) {
  objects::SolidFactory factory;
  for (const plan::Group& group : scene.groups) {
    const auto* ccd = std::get_if<bool>(&group.settings.Get("ccd"));
    if ((ccd != nullptr && !*ccd) || !AreFilesHere(group)) continue;
    for (const schema::Value& type : analysis::TypesOf(group.settings)) {
      const objects::Solid solid =
          factory.Make(type, Eigen::Vector3d::Ones(),
                       std::get<schema::Ratio>(group.settings.Get("aspect")).parts);
      if (solid.compound == nullptr ||
          (!solid.IsSurface() && solid.compound->form().pieces.size() == 1))
        continue;
      throw library::SceneError(
          fmt::format("ccd is for convex types, but the {} of `{}` is a {}", schema::ToText(type),
                      group.name, solid.IsSurface() ? "surface" : "compound"),
          "set ccd off for this group", group.name, "ccd");
    }
  }
}

/// A pile settles on the floor, under a constant acceleration.
void CheckPiles(const plan::Scene& scene) {
  const auto* g = std::get_if<Eigen::Vector3d>(&scene.world.Get("acceleration"));
  const bool falls_aside =
      g != nullptr &&
      !(g->y() < 0 && std::hypot(g->x(), g->z()) <= analysis::kMostTiltOfPiles * -g->y());
  for (const plan::Group& group : scene.groups) {
    if (group.settings.Count("quantity") == 0 || !layouts::IsPile(group)) continue;
    const auto refuse = [&](const char* cause, const char* remedy) {
      throw library::SceneError(cause, remedy, group.name, "location");
    };
    if (group.settings.WordOr("mass") == "fixed")
      refuse("fixed objects cannot settle into a pile", "give them a mass, or another layout");
    if (scene.world.WordOr("world.walls") == "none")
      refuse("a pile needs a floor", "set world.walls to floor or all");
    if (falls_aside)
      refuse("a pile needs an acceleration that points down to the floor", "such as (0, -9.8, 0)");
  }
}

/// Places what needs no decomposition of a mesh.
void CheckPlacement(plan::Scene scene, std::uint64_t& draws) {
  std::set<std::string> left_out;
  for (plan::Group& group : scene.groups) {
    if (IsMadeAtOnce(group) && !left_out.contains(layouts::GroupOfRegion(group)) &&
        !left_out.contains(layouts::GroupOfLayout(group)))
      continue;
    left_out.insert(group.name);
    group.settings.Set("quantity", schema::Number::Whole(0));
  }
  layouts::CheckPlacement(scene, draws);
}

/// The requested errors that the closed form does not determine.
std::string UnknownErrors(const ClosedForm& form, const plan::Scene& scene) {
  const Truth truth = form.At(0);
  const auto knows = [&](schema::ErrorKind kind) {
    using enum schema::ErrorKind;
    switch (kind) {
      case kVelocity:
        return !truth.velocities.empty();
      case kRotation:
        return !truth.orientations.empty();
      case kEnergy:
        return truth.energy.has_value();
      case kMomentum:
        return truth.momentum.has_value();
      case kAngularMomentum:
        return truth.angular_momentum.has_value();
      case kContacts:
        return false;
      default:
        return !truth.positions.empty();
    }
  };
  std::string unknown;
  for (const schema::ErrorInfo* error : analysis::ErrorsOf(scene))
    if (error->needs_truth && !knows(error->kind))
      unknown += fmt::format("{}{}", unknown.empty() ? "" : ", ", error->name);
  return unknown;
}

analysis::SceneFault FaultOf(const library::SceneError& error, analysis::SceneFault::Kind kind) {
  return {kind, error.group(), error.cause(), error.remedy(), error.parameter()};
}

}  // namespace

std::optional<analysis::SceneFault> FindSceneFault(const plan::Scene& scene, std::uint64_t& draws) {
  using enum analysis::SceneFault::Kind;
  const std::string_view form = scene.world.WordOr("accuracy.closed_form");
  if (form == "none" || analysis::ErrorsOf(scene).empty()) {
    try {
      CheckCcd(scene);
      CheckPiles(scene);
      CheckPlacement(scene, draws);
    } catch (const library::SceneError& error) {
      return FaultOf(error, kPlacement);
    }
    return std::nullopt;
  }
  layouts::InitialState state;
  try {
    state = layouts::MakeInitialState(scene);
    layouts::CheckRange(scene, state);
  } catch (const library::SceneError& error) {
    return FaultOf(error, kPlacement);
  }
  try {
    const auto made = MakeClosedForm(form, scene, state);
    if (const std::string unknown = UnknownErrors(*made, scene); !unknown.empty())
      return analysis::SceneFault{
          kClosedForm,
          {},
          fmt::format("closed_form {} does not determine {}", form, unknown),
          "remove them from accuracy.metrics, or closed_form for a reference run"};
  } catch (const library::SceneError& error) {
    return FaultOf(error, kClosedForm);
  }
  return std::nullopt;
}

}  // namespace cdb::closed_forms
