#include "compiler/yaml/pile.h"

#include <algorithm>

#include "compiler/schema/schema.h"
#include "compiler/yaml/plan_yaml.h"

namespace cdb::yaml {
namespace {

void EraseIgnored(bool grouped, plan::Settings& settings) {
  for (const schema::Parameter& parameter : schema::Schema())
    if (parameter.grouped == grouped && parameter.IsIgnoredBy(schema::Parameter::kPile))
      settings.EraseValue(parameter);
}

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
  EraseIgnored(false, settling.world);
  settling.world.Set("precision", schema::Word{"double"});
  settling.world.Set("omit", schema::WordList{"none"});
  settling.world.Set("record", schema::WordList{});
  settling.world.Set("sleeping", false);
  settling.KeepUsedPlugins();
  return settling;
}

std::string PileText(const plan::Scene& scene) {
  plan::Run run;
  plan::Scene& pile = run.scene;
  pile = SettlingScene(scene);
  for (plan::Group& group : pile.groups) {
    if (!HasPile(group)) continue;
    EraseIgnored(true, group.settings);
    for (const schema::Parameter& parameter : schema::Schema())
      if (parameter.grouped && parameter.IsIgnoredBy(schema::Parameter::kPile))
        pile.seeds.erase(group.name + "." + std::string(parameter.name));
  }
  pile.seeds.erase(
      "nudge");  // of a perturbed run, whose objects are moved after the pile has settled
  return RunToYaml(run);
}

}  // namespace cdb::yaml
