#include "compiler/cross.h"

#include <algorithm>

#include "compiler/reference.h"
#include "compiler/schema.h"
#include "dsl/check.h"

namespace cdb::compiler {
namespace {

/// Those that it has not got.
void AddPlugins(std::span<const PluginDetector> plugins, Scene& scene) {
  for (const PluginDetector& plugin : plugins)
    if (std::ranges::find(scene.plugins, plugin.name, &PluginDetector::name) == scene.plugins.end())
      scene.plugins.push_back(plugin);
  std::ranges::sort(scene.plugins, {}, &PluginDetector::name);
}

}  // namespace

Plan Cross(const Plan& plan, std::string_view parameter, const std::vector<std::string>& words,
           std::span<const PluginDetector> plugins) {
  const Parameter* row = FindParameter(parameter, false);
  CDB_CHECK(row != nullptr && std::ranges::all_of(words, [&](const auto& word) {
              return row->HasWord(word, plugins);
            }));
  if (std::ranges::find(plan.axes, parameter, &Axis::parameter) != plan.axes.end()) return plan;
  Plan crossed = plan;
  Axis axis{std::string(parameter), std::string(parameter), std::string(row->unit), {}};
  axis.values.assign(words.begin(), words.end());
  crossed.axes.insert(crossed.axes.begin(), std::move(axis));
  crossed.runs.clear();
  crossed.skipped.clear();
  for (std::size_t i = 0; i < words.size(); ++i) {
    for (Run run : plan.runs) {
      run.at.insert(run.at.begin(), i);
      run.scene.world.values.insert_or_assign(std::string(parameter), Word{words[i]});
      AddPlugins(plugins, run.scene);
      run.scene.KeepUsedPlugins();
      run.id = RunId(run.scene, run.rep);
      crossed.runs.push_back(std::move(run));
    }
    for (std::vector<std::size_t> at : plan.skipped) {
      at.insert(at.begin(), i);
      crossed.skipped.push_back(std::move(at));
    }
  }
  AddReferences(crossed);
  return crossed;
}

}  // namespace cdb::compiler
