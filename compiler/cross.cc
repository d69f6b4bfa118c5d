#include "compiler/cross.h"

#include <algorithm>

#include "compiler/analysis/reference.h"
#include "compiler/schema/schema.h"
#include "dsl/text/check.h"

namespace cdb::compiler {
namespace {

/// Adds the plug-ins that the scene does not have yet.
void AddPlugins(std::span<const schema::PluginDetector> plugins, plan::Scene& scene) {
  for (const schema::PluginDetector& plugin : plugins)
    if (std::ranges::find(scene.plugins, plugin.name, &schema::PluginDetector::name) ==
        scene.plugins.end())
      scene.plugins.push_back(plugin);
  std::ranges::sort(scene.plugins, {}, &schema::PluginDetector::name);
}

}  // namespace

plan::Plan Cross(const plan::Plan& plan, schema::WorldParameter parameter,
                 const std::vector<std::string>& words,
                 std::span<const schema::PluginDetector> plugins) {
  CDB_CHECK(std::ranges::all_of(
      words, [&](const auto& word) { return (*parameter).HasWord(word, plugins); }));
  const std::string name(parameter.name());
  if (std::ranges::find(plan.axes, name, &plan::Axis::parameter) != plan.axes.end()) return plan;
  plan::Plan crossed = plan;
  plan::Axis axis{name, name, std::string((*parameter).unit), {}};
  axis.values.assign(words.begin(), words.end());
  crossed.axes.insert(crossed.axes.begin(), std::move(axis));
  crossed.runs.clear();
  crossed.skipped.clear();
  for (std::size_t i = 0; i < words.size(); ++i) {
    for (plan::Run run : plan.runs) {
      run.at.insert(run.at.begin(), i);
      run.scene.world.Set(parameter, schema::Word{words[i]});
      AddPlugins(plugins, run.scene);
      run.scene.KeepUsedPlugins();
      run.id = plan::RunId(run.scene, run.rep);
      crossed.runs.push_back(std::move(run));
    }
    for (std::vector<std::size_t> at : plan.skipped) {
      at.insert(at.begin(), i);
      crossed.skipped.push_back(std::move(at));
    }
  }
  analysis::AddReferences(crossed);
  return crossed;
}

}  // namespace cdb::compiler
