#include "compiler/yaml/pile.h"

#include <algorithm>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "compiler/schema/schema.h"
#include "compiler/yaml/plan_yaml.h"

namespace cdb::yaml {
namespace {

/// These determine the length of a run, its outputs and its comparison, but not its piles.
bool IsOfTheRun(const schema::Parameter& parameter) {
  constexpr std::string_view kNames = "cycles warmup timeout memory repeats expect seed timestep";
  return schema::ListsWord(kNames, parameter.name) || parameter.name.starts_with("accuracy.");
}

/// Settling uses its own damping, margins and velocities, and no bounces.
constexpr std::initializer_list<schema::GroupParameter> kReplaced = {
    "restitution", "linear_damping",  "angular_damping", "margin",
    "ccd",         "linear_velocity", "angular_velocity"};

}  // namespace

bool HasPile(const plan::Group& group) {
  const schema::Call* layout = schema::AsCall(group.settings.Get("location"));
  return layout != nullptr && layout->name == "pile" && group.settings.Count("quantity") > 0;
}

bool HasPile(const plan::Scene& scene) {
  return std::ranges::any_of(scene.groups, [](const plan::Group& group) { return HasPile(group); });
}

plan::Scene SettlingScene(const plan::Scene& scene) {
  plan::Scene settling = scene;
  settling.role = plan::Role::kMeasured;
  const auto set = [&](schema::WorldParameter parameter, schema::Value value) {
    settling.world.Set(parameter, std::move(value));
  };
  set("precision", schema::Word{"double"});
  set("detector", schema::Word{"dbvt"});
  set("narrow_phase", schema::Word{"own"});
  set("pair_order", schema::Word{"listed"});
  set("threads", std::uint64_t{1});
  set("contact", schema::Word{"bullet"});
  set("omit", schema::WordList{"none"});
  set("record", schema::WordList{});
  set("sleeping", false);
  // Bullet's defaults, so that a sweep of the solver, and a reference run, begin with the same
  // heap.
  set("solver.iterations", std::uint64_t{10});
  set("solver.erp", 0.2);
  set("solver.warm_start", 0.85);
  set("accuracy.reference.detector", schema::Word{"dbvt"});
  settling.KeepUsedPlugins();
  return settling;
}

std::string PileText(const plan::Scene& scene) {
  plan::Run run;
  plan::Scene& pile = run.scene;
  pile = SettlingScene(scene);
  for (const schema::Parameter& parameter : schema::Schema())
    if (!parameter.grouped && IsOfTheRun(parameter)) pile.world.EraseValue(parameter);
  for (plan::Group& group : pile.groups) {
    if (!HasPile(group)) continue;
    for (const schema::GroupParameter parameter : kReplaced) {
      group.settings.EraseValue(*parameter);
      pile.seeds.erase(group.name + "." + std::string(parameter.name()));
    }
  }
  pile.seeds.erase(
      "nudge");  // of a perturbed run, whose objects are moved after the pile has settled
  return RunToYaml(run);
}

}  // namespace cdb::yaml
