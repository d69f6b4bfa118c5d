#include "compiler/checks/traced_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/series.h"

namespace cdb::checks {
namespace {

bool IsMeaningful(const schema::Parameter& parameter) {
  return !parameter.IsIgnoredBy(schema::Parameter::kTrace);
}

std::string MeaningfulNames() {
  std::vector<std::string_view> names;
  for (const schema::Parameter& parameter : schema::Schema())
    if (IsMeaningful(parameter)) names.push_back(parameter.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

std::vector<TracedFault> LayTrace(const scenario::Layers& layers, const analysis::TraceFacts& facts,
                                  plan::Scene& scene) {
  std::vector<TracedFault> faults;
  const auto is_set = [&](schema::WorldParameter parameter) {
    return layers.settings.contains({"", parameter.get()});
  };
  const auto set = [&](schema::WorldParameter parameter, schema::Value value) {
    scene.world.Set(parameter, std::move(value));
  };
  for (const auto& [key, setting] : layers.settings)
    if (!IsMeaningful(*key.second))
      faults.push_back({&scenario::kContradiction,
                        key,
                        {},
                        fmt::format("'{}' has no meaning on a trace", setting.node->path.text),
                        "remove it; a benchmark on a trace can set " + MeaningfulNames()});

  const std::uint64_t warmup = scene.world.Count("warmup");
  const schema::WorldParameter of_cycles = "cycles", of_warmup = "warmup";
  if (!is_set("cycles")) set("cycles", facts.cycles - std::min(facts.cycles - 1, warmup));
  const std::uint64_t cycles = scene.world.Count("cycles");
  if (warmup > facts.cycles || cycles > facts.cycles - warmup)
    faults.push_back({&scenario::kCapacity,
                      {"", (is_set(of_cycles) ? of_cycles : of_warmup).get()},
                      {},
                      fmt::format("the trace has {} cycles, but this asks for {}", facts.cycles,
                                  warmup + cycles),
                      is_set("cycles") ? "without cycles, all of them are used"
                                       : "warmup must leave at least one cycle to time"});

  if (!is_set("record")) set("record", schema::WordList{"counts", "timing"});
  std::vector<std::string_view> recorded;
  for (const schema::RecordWord& word : schema::kRecordWords)
    if (word.on_traces) recorded.push_back(word.name);
  for (const std::string& word : scene.world.Words("record"))
    if (std::ranges::find(recorded, word) == recorded.end())
      faults.push_back({&scenario::kContradiction,
                        {"", schema::WorldParameter("record").get()},
                        word,
                        fmt::format("'{}' cannot be recorded on a trace, which has boxes and no "
                                    "bodies",
                                    word),
                        fmt::format("what can be: {}", fmt::join(recorded, ", "))});

  // The trace determines the size of the scene; other settings of objects in the plan have no
  // effect.
  scene.groups.resize(1);
  scene.groups[0].settings.Set("quantity", facts.bodies);
  scene.seeds.clear();
  set("world.walls", schema::Word{"none"});
  set("timestep", facts.timestep_s);
  set("precision", schema::Word{facts.is_double ? "double" : "single"});
  set("omit", schema::WordList{"none"});
  return faults;
}

}  // namespace cdb::checks
