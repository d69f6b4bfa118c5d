#include "compiler/checks/configuration_checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "compiler/analysis/configurations.h"
#include "compiler/plan/text_table.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/series.h"

namespace cdb::checks {
namespace {

const schema::Parameter* Positions() {
  return schema::WorldParameter("configurations.positions").get();
}

/// What to do about a setting without a meaning.
std::string AdviceOn(const schema::Parameter& parameter) {
  if (parameter.name.starts_with("joints.motor")) return "remove the motor; of a robot, hold";
  if (parameter.name.starts_with("links."))
    return "remove it: configurations are of joints, joints { … } or robot { … }";
  if (parameter.name == "trace") return "remove it, or configurations";
  return "remove it: configurations are checked for collisions, and nothing is simulated";
}

}  // namespace

std::vector<LaidFault> LayConfigurations(const scenario::Scenario& scenario,
                                         const scenario::Layers& layers, plan::Scene& scene) {
  std::vector<LaidFault> faults;
  const auto is_set = [&](schema::WorldParameter parameter) {
    return layers.settings.contains({"", parameter.get()});
  };
  const auto set = [&](schema::WorldParameter parameter, schema::Value value) {
    scene.world.Set(parameter, std::move(value));
  };
  for (const auto& [key, setting] : layers.settings)
    if (key.second->IsIgnoredBy(schema::Parameter::kConfigurations))
      faults.push_back(
          {&scenario::kContradiction,
           key,
           {},
           fmt::format("'{}' has no meaning for configurations", setting.node->path.text),
           AdviceOn(*key.second)});
  if (!scene.queries.empty())
    faults.push_back({&scenario::kContradiction,
                      {"", schema::WorldParameter("configurations.positions").get()},
                      {},
                      "queries are of scenes in motion, and configurations are checked one by one",
                      "remove one of the two blocks"});
  if (!is_set("record")) set("record", schema::WordList{"counts", "timing"});
  AddRecordFaults(scene, &schema::RecordWord::on_configurations,
                  "for configurations: nothing is simulated", faults);
  if (!is_set("world.walls")) set("world.walls", schema::Word{"none"});
  set("omit", schema::WordList{"none"});
  const schema::Call* list = analysis::ConfigurationListOf(scene);
  if (list == nullptr) return faults;
  std::string why;
  const auto text = scenario.TextOf(analysis::FileOfList(*list), why);
  if (!text) return faults;  // which has been reported
  try {
    const auto read = analysis::ReadConfigurationList(*list, *text, analysis::FreedomsOf(scene));
    if (!is_set("cycles")) set("cycles", std::uint64_t{read.count});
    if (scene.world.Count("cycles") > read.count)
      faults.push_back({&scenario::kCapacity,
                        {"", schema::WorldParameter("cycles").get()},
                        {},
                        fmt::format("the list has {} configurations, but this asks for {}",
                                    read.count, scene.world.Count("cycles")),
                        "without cycles, all of them are used"});
  } catch (const plan::TableError& error) {
    faults.push_back({&scenario::kOutOfDomain, {"", Positions()}, {}, error.what(), error.remedy});
  }
  return faults;
}

std::vector<LaidFault> FindFaultsOfConfigurations(const plan::Scene& scene) {
  const auto fault = analysis::FindConfigurationFault(scene);
  if (!fault) return {};
  return {{&scenario::kContradiction,
           {fault->group, fault->parameter},
           {},
           fault->message,
           fault->help}};
}

}  // namespace cdb::checks
