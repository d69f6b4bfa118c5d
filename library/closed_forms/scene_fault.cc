#include "library/closed_forms/scene_fault.h"

#include <algorithm>
#include <string_view>

#include "compiler/analysis/reference.h"
#include "compiler/analysis/trace.h"
#include "library/closed_forms/closed_form.h"
#include "library/layouts/placement.h"
#include "library/meshes/models.h"
#include "library/scene_error.h"

namespace cdb::closed_forms {
namespace {

/// Decomposing a mesh takes seconds; a surface is only read.
bool MayBeMesh(const schema::Value& type) {
  if (const schema::Call* call = schema::AsCall(type)) return !analysis::IsSurface(*call);
  if (const auto* word = std::get_if<schema::Word>(&type))
    return meshes::FindModel(word->text) != nullptr;
  const auto* drawn = std::get_if<schema::Distribution>(&type);
  return drawn == nullptr || std::ranges::any_of(drawn->arguments, MayBeMesh);
}

bool HasMeshes(const plan::Scene& scene) {
  return std::ranges::any_of(scene.groups, [](const plan::Group& group) {
    return group.settings.Count("quantity") > 0 && MayBeMesh(group.settings.Get("type"));
  });
}

analysis::SceneFault FaultOf(const library::SceneError& error, analysis::SceneFault::Kind kind) {
  return {kind, error.group(), error.cause(), error.remedy(), error.parameter()};
}

}  // namespace

std::optional<analysis::SceneFault> FindSceneFault(const plan::Scene& scene) {
  using enum analysis::SceneFault::Kind;
  const std::string_view form = scene.world.WordOr("accuracy.closed_form");
  if (form == "none" || analysis::ErrorsOf(scene).empty()) {
    try {
      if (!HasMeshes(scene)) layouts::CheckPlacement(scene);
    } catch (const library::SceneError& error) {
      return FaultOf(error, kPlacement);
    }
    return std::nullopt;
  }
  layouts::InitialState state;
  try {
    state = layouts::MakeInitialState(scene);
  } catch (const library::SceneError& error) {
    return FaultOf(error, kPlacement);
  }
  try {
    MakeClosedForm(form, scene, state);
  } catch (const library::SceneError& error) {
    return FaultOf(error, kClosedForm);
  }
  return std::nullopt;
}

}  // namespace cdb::closed_forms
