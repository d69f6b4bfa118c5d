#include "compiler/checks/traced_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::checks {
namespace {

constexpr std::string_view kMeaningful[] = {"trace",  "detector", "threads", "repeats",
                                            "warmup", "cycles",   "timeout", "record"};
constexpr std::string_view kRecorded[] = {"timing", "counts", "memory", "pairs"};

template <typename Names>
bool Holds(const Names& names, std::string_view name) {
  return std::ranges::find(names, name) != std::end(names);
}

}  // namespace

std::vector<TracedFault> LayTrace(const scenario::Layers& layers, const plan::TraceFacts& facts,
                                  plan::Scene& scene) {
  std::vector<TracedFault> faults;
  const auto is_set = [&](std::string_view name) {
    return layers.settings.contains({"", schema::FindParameter(name, false)});
  };
  const auto set = [&](const char* name, schema::Value value) {
    scene.world.values.insert_or_assign(name, std::move(value));
  };
  for (const auto& [key, setting] : layers.settings)
    if (key.second->grouped || !Holds(kMeaningful, key.second->name))
      faults.push_back(
          {&scenario::kContradiction,
           key,
           {},
           fmt::format("'{}' means nothing on a trace", setting.node->path.text),
           fmt::format("leave it out; what can be set there: {}", fmt::join(kMeaningful, ", "))});

  const std::uint64_t warmup = scene.world.Count("warmup");
  const char* which = is_set("cycles") ? "cycles" : "warmup";
  if (!is_set("cycles")) set("cycles", facts.cycles - std::min(facts.cycles - 1, warmup));
  const std::uint64_t cycles = scene.world.Count("cycles");
  if (warmup > facts.cycles || cycles > facts.cycles - warmup)
    faults.push_back({&scenario::kCapacity,
                      {"", schema::FindParameter(which, false)},
                      {},
                      fmt::format("the trace has {} cycles, and this asks for {}", facts.cycles,
                                  warmup + cycles),
                      is_set("cycles") ? "cycles left out takes all that there are"
                                       : "warmup leaves at least one to time"});

  if (!is_set("record")) set("record", schema::WordList{"counts", "timing"});
  for (const std::string& word : std::get<schema::WordList>(scene.world.Get("record")))
    if (!Holds(kRecorded, word))
      faults.push_back({&scenario::kContradiction,
                        {"", schema::FindParameter("record", false)},
                        word,
                        fmt::format("'{}' cannot be recorded on a trace, which has boxes and no "
                                    "bodies",
                                    word),
                        fmt::format("what can be: {}", fmt::join(kRecorded, ", "))});

  // The plan says of its own accord how large the scene is; what it says of objects beside that has
  // no effect.
  scene.groups.resize(1);
  scene.groups[0].settings.values.insert_or_assign("quantity", facts.bodies);
  scene.seeds.clear();
  set("world.walls", schema::Word{"none"});
  set("timestep", facts.timestep_s);
  set("precision", schema::Word{facts.is_double ? "double" : "single"});
  set("omit", schema::WordList{"none"});
  return faults;
}

}  // namespace cdb::checks
