// Effect on the cycles of sampling a run's series between them: each scene twice in one program,
// timed alone and timed with `record timing, counts, stability`, in blocks of cycles in turn, so
// that each has the caches to itself. Both go through the same states; a cycle is compared with
// itself. Scenes come from .cdb files; the last run of each benchmark is taken.
// Usage: bench_probes_f32 [-r ROUNDS] [-c CYCLES] [FILE.cdb ...]

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "library/layouts/initial_state.h"
#include "runtime/engine/probes/probes.h"
#include "runtime/engine/probes/state_hash.h"
#include "runtime/engine/world/engine.h"
#include "tests/bench/median.h"
#include "tests/bench/scenario_runs.h"

namespace cdb::bench {
namespace {

constexpr std::uint64_t kBlock = 25;
/// The first cycles of a block find the caches as the other world left them.
constexpr std::uint64_t kSettle = 5;

/// One of the two worlds, and the times of its cycles.
class Side {
 public:
  Side(plan::Scene scene, const layouts::InitialState& state, schema::WordList record)
      : scene_(With(std::move(scene), std::move(record))),
        recording_(protocol::Recording::Create(scene_)),
        engine_(scene_, state, omissions::KeepEverything(scene_)),
        probes_(scene_, engine_, recording_, -1) {
    probes_.Begin();
  }
  void Step(std::uint64_t cycle) {
    engine_.Step();
    const auto begin = world::Now();
    probes_.Record(cycle);
    probe_ns.push_back(static_cast<double>(world::Now() - begin));
    steps.push_back(engine_.timed_world()->Durations()[protocol::IndexOf(protocol::Phase::kStep)]);
  }
  std::string Hash() const { return probes::StateHash(engine_); }

  std::vector<double> steps, probe_ns;

 private:
  static plan::Scene With(plan::Scene scene, schema::WordList record) {
    scene.world.Set("record", std::move(record));
    return scene;
  }
  const plan::Scene scene_;
  protocol::Recording recording_;
  world::Engine engine_;
  probes::Probes probes_;
};

struct Result {
  double alone_us, probes_us;
  double change;  ///< of the median cycle
};

Result RunRound(const plan::Scene& scene, std::uint64_t cycles, std::uint64_t round) {
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  std::optional<Side> alone_side, probed_side;
  // Whoever comes first gets the smoother memory.
  if (round % 2 == 0) alone_side.emplace(scene, state, schema::WordList{"timing"});
  probed_side.emplace(scene, state, schema::WordList{"timing", "counts", "stability"});
  if (round % 2 == 1) alone_side.emplace(scene, state, schema::WordList{"timing"});
  Side &alone = *alone_side, &probed = *probed_side;
  std::vector<double> ratios;
  for (std::uint64_t begin = 0; begin < cycles; begin += kBlock) {
    const std::uint64_t end = std::min(begin + kBlock, cycles);
    const auto block = [&](Side& side) {
      for (std::uint64_t cycle = begin; cycle < end; ++cycle) side.Step(cycle);
    };
    const bool alone_first = (begin / kBlock + round / 2) % 2 == 0;
    block(alone_first ? alone : probed);
    block(alone_first ? probed : alone);
    for (std::uint64_t cycle = begin + kSettle; cycle < end; ++cycle)
      ratios.push_back(probed.steps[cycle] / alone.steps[cycle]);
  }
  if (alone.Hash() != probed.Hash()) {
    fmt::print(stderr, "the two worlds went different ways\n");
    std::exit(1);
  }
  return {Median(alone.steps) / 1e3, Median(probed.probe_ns) / 1e3, Median(ratios) - 1};
}

void RunScene(const std::string& name, plan::Scene scene, std::uint64_t rounds,
              std::uint64_t cycles) {
  scene.world.Set("precision", schema::Word{std::string(world::EnginePrecision())});
  cycles = std::min(cycles, scene.world.Count("cycles"));
  std::vector<double> changes, steps, probes;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    const Result result = RunRound(scene, cycles, round);
    changes.push_back(100 * result.change);
    steps.push_back(result.alone_us);
    probes.push_back(result.probes_us);
  }
  const auto [least, most] = std::ranges::minmax(changes);
  fmt::print("{:<18} {:>6} {:>10.1f} {:>10.1f} {:>+9.2f} {:>+7.2f} .. {:<+6.2f}\n", name,
             scene.ObjectCount(), Median(steps), Median(probes), Median(changes), least, most);
  std::fflush(stdout);
}

}  // namespace
}  // namespace cdb::bench

using namespace cdb;
using namespace cdb::bench;

int main(int argc, char** argv) {
  const ScenarioRuns runs(argc, argv, {8, 400, CDB_SOURCE_DIR "/tests/bench/probes.cdb"});
  fmt::print("{} precision, {} rounds of up to {} cycles; medians, and the range of the rounds\n",
             world::EnginePrecision(), runs.rounds, runs.cycles);
  fmt::print("{:<18} {:>6} {:>10} {:>10} {:>9} {:>17}\n", "scene", "N", "step, us", "probes, us",
             "change, %", "range");
  const bool good = runs.ForEach([&](const std::string& name, const plan::Scene& scene) {
    RunScene(name, scene, runs.rounds, runs.cycles);
  });
  return good ? 0 : 1;
}
