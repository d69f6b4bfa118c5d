#include "runtime/cli/plans/suite_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <tuple>
#include <utility>

#include "compiler/analysis/reference.h"
#include "runtime/cli/options/exit_status.h"
#include "runtime/cli/options/inputs.h"

namespace cdb::plans {
namespace {

using plan::Plan;

void SetSeed(std::uint64_t seed, plan::Scene& scene) {
  scene.world.Set("seed", seed);
  for (auto& [name, stream] : scene.seeds) stream = plan::StreamSeed(seed, name);
}

/// The first repeat of each point, changed by `change`, once for each new repeat.
template <typename Change>
std::vector<plan::Run> Repeated(const Plan& plan, std::uint64_t repeats, Change change) {
  std::vector<plan::Run> runs;
  for (const plan::Run& first : plan.runs) {
    if (first.rep != 0) continue;
    plan::Run run = first;
    run.scene.world.Set("repeats", repeats);
    change(run);
    for (run.rep = 0; run.rep < repeats; ++run.rep) {
      run.id = plan::RunId(run.scene, run.rep);
      runs.push_back(run);
    }
  }
  return runs;
}

/// Puts an axis of seeds in front.
Plan MakeLong(const Plan& plan) {
  Plan made = plan;
  plan::Axis axis{"seed", "seed", "", {}};
  made.repeats = kLongRepeats;
  made.runs.clear();
  for (const std::uint64_t seed : kLongSeeds) {
    const std::size_t place = axis.values.size();
    axis.values.emplace_back(static_cast<double>(seed));
    for (plan::Run& run : Repeated(plan, kLongRepeats, [&](plan::Run& of) {
           SetSeed(seed, of.scene);
           of.at.insert(of.at.begin(), place);
         }))
      made.runs.push_back(std::move(run));
  }
  made.axes.insert(made.axes.begin(), std::move(axis));
  return made;
}

Plan WithSeed(const Plan& plan, std::uint64_t seed) {
  Plan made = plan;
  made.runs = Repeated(plan, plan.repeats, [&](plan::Run& run) { SetSeed(seed, run.scene); });
  return made;
}

/// Adds runs of these detectors, like those of the baseline.
void AddDetectors(const std::vector<std::string>& names,
                  const std::vector<schema::PluginDetector>& plugins, Plan& plan) {
  const auto axis = std::ranges::find(plan.axes, "detector", &plan::Axis::parameter);
  if (axis == plan.axes.end()) return;
  const auto place = static_cast<std::size_t>(axis - plan.axes.begin());
  for (const std::string& name : names) {
    if (std::ranges::find(axis->values, plan::Coordinate(name)) != axis->values.end())
      throw options::CommandError(fmt::format("--detector {}: it is already in the suite", name));
    const std::vector<plan::Run> before = plan.runs;
    for (plan::Run run : before) {
      if (run.at[place] != 0) continue;
      run.at[place] = axis->values.size();
      run.scene.world.Set("detector", schema::Word{name});
      for (const schema::PluginDetector& plugin : plugins)
        if (plugin.name == name) run.scene.plugins.push_back(plugin);
      run.id = plan::RunId(run.scene, run.rep);
      plan.runs.push_back(std::move(run));
    }
    axis->values.emplace_back(name);
  }
  std::ranges::sort(plan.runs, {}, [](const plan::Run& run) { return std::tie(run.at, run.rep); });
}

}  // namespace

Plan StandardPlan(const figures::StandardScene& scene, const SuiteChoice& choice) {
  const std::filesystem::path library = options::ScenarioLibrary();
  const std::filesystem::path file = library / (scene.File() + ".cdb");
  std::error_code error;
  if (library.empty() || !std::filesystem::is_regular_file(file, error))
    throw options::CommandError(fmt::format(
        "the scene {} of the standard suite is not installed beside this program; install cdb",
        scene.Id()));
  std::vector<schema::PluginDetector> named;
  // No lints: the suite measures these weaknesses of Bullet on purpose.
  auto plans =
      options::LoadPlans(file.string(), {}, options::LintText::kNone, choice.plugins, &named);
  if (plans.size() != 1 || plans[0].benchmark + ".h5" != scene.ResultName())
    throw options::CommandError(
        fmt::format("'{}' is not the scene {} of the standard suite; install cdb "
                    "again",
                    file.string(), scene.Id()));
  options::CheckWords("detector", choice.detectors, named);
  Plan plan = std::move(plans[0]);
  if (choice.is_long) plan = MakeLong(plan);
  if (choice.seed) plan = WithSeed(plan, *choice.seed);
  AddDetectors(choice.detectors, named, plan);
  analysis::AddReferences(plan);
  return plan;
}

}  // namespace cdb::plans
