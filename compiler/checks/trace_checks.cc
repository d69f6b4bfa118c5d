// A scene whose detector is run on a trace.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "compiler/analysis/trace.h"
#include "compiler/checks/scene_checks.h"
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

void AddRecordFaults(const plan::Scene& scene, bool schema::RecordWord::*is_recordable,
                     std::string_view where, std::vector<LaidFault>& faults) {
  std::vector<std::string_view> recordable;
  for (const schema::RecordWord& word : schema::kRecordWords)
    if (word.*is_recordable) recordable.push_back(word.name);
  for (const std::string& word : scene.world.Words("record"))
    if (std::ranges::find(recordable, word) == recordable.end())
      faults.push_back({&scenario::kContradiction,
                        {"", schema::WorldParameter("record").get()},
                        word,
                        fmt::format("'{}' cannot be recorded {}", word, where),
                        fmt::format("what can be: {}", fmt::join(recordable, ", "))});
}

std::vector<LaidFault> LayTrace(const scenario::Layers& layers, const analysis::TraceFacts& facts,
                                plan::Scene& scene) {
  std::vector<LaidFault> faults;
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

  if (analysis::IsOnPairs(scene)) {
    constexpr schema::WorldParameter kNarrowPhase = "narrow_phase", kDetector = "detector";
    const auto fault = [&](schema::WorldParameter parameter, std::string message,
                           std::string help) {
      faults.push_back({&scenario::kContradiction,
                        {"", parameter.get()},
                        {},
                        std::move(message),
                        std::move(help)});
    };
    if (facts.pairs_sha256.empty())
      fault(kNarrowPhase,
            fmt::format("a narrow phase needs pairs, and '{}' has only boxes",
                        analysis::TraceOf(scene)->path),
            facts.primitives.empty()
                ? "record them: cdb trace FILE --pairs"
                : "a deforming mesh has no poses; time broad phases on it, by `detector`");
    if (is_set(kDetector))
      fault(kDetector,
            "with 'narrow_phase', a run on a trace has the recorded pairs and no detector",
            "remove it, or narrow_phase; the two are timed in benchmarks of their own");
    // All that a narrow phase gets identifies the run, not the boxes alone.
    schema::Call trace = *schema::AsCall(scene.world.Get("trace"));
    trace.arguments[1] = schema::Text{facts.pairs_sha256};
    if (!facts.pairs_sha256.empty()) set("trace", std::move(trace));
  }

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
  AddRecordFaults(scene, &schema::RecordWord::on_traces,
                  "on a trace, which has boxes and no bodies", faults);

  // The trace determines the size of the scene; other settings of objects in the plan have no
  // effect.
  scene.groups.resize(1);
  scene.joints.clear();
  scene.DropQueries();
  scene.groups[0].settings.Set("quantity", facts.bodies);
  scene.seeds.clear();
  set("world.walls", schema::Word{"none"});
  set("timestep", facts.timestep_s);
  set("precision", schema::Word{facts.is_double ? "double" : "single"});
  set("omit", schema::WordList{"none"});
  return faults;
}

}  // namespace cdb::checks
