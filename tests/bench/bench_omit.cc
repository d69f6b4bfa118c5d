// Time saved by omissions: each scene twice in one program, whole and pruned by `omit`, cycle by
// cycle in strict alternation, the order swapped each time. Both must be in the same state after
// every cycle. Scenes come from .cdb files; the last run of each benchmark is taken.
// Usage: bench_omit_f32 [-r ROUNDS] [-c CYCLES] [FILE.cdb ...]

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "library/layouts/initial_state.h"
#include "runtime/engine/probes/state_hash.h"
#include "runtime/engine/world/engine.h"
#include "runtime/engine/world/omission_guard.h"
#include "tests/bench/median.h"
#include "tests/bench/scenario_runs.h"

namespace cdb::bench {
namespace {

double HeapBytes() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

/// One of the two worlds, and its times.
struct Side {
  std::unique_ptr<world::Engine> engine;
  double build_ns = 0, heap = 0;
  std::vector<double> steps;

  void Build(const plan::Scene& scene, const layouts::InitialState& state, bool lean) {
    const double before = HeapBytes();
    const auto begin = world::Now();
    auto omissions =
        lean ? omissions::DecideOmissions(scene, state) : omissions::KeepEverything(scene);
    engine = std::make_unique<world::Engine>(scene, state, std::move(omissions));
    build_ns = static_cast<double>(world::Now() - begin);
    heap = HeapBytes() - before;
  }
  void Step() {
    engine->Step();
    steps.push_back(engine->timed_world()->Durations()[protocol::IndexOf(protocol::Phase::kStep)]);
  }
};

struct Result {
  double whole_us, lean_us, ratio;       ///< of a cycle
  double whole_build_us, lean_build_us;  ///< start-up
  double whole_heap, lean_heap;          ///< bytes
  std::string note;
};

Result RunRound(const plan::Scene& scene, std::uint64_t cycles, std::uint64_t round) {
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  Side whole, lean;
  // Whoever comes first gets the smoother memory.
  if (round % 2 == 0) whole.Build(scene, state, false);
  lean.Build(scene, state, true);
  if (round % 2 == 1) whole.Build(scene, state, false);
  world::OmissionGuard guard(*lean.engine);
  std::string note = analysis::OmittedNames(lean.engine->omissions().decisions);
  for (std::uint64_t cycle = 0; cycle < cycles; ++cycle) {
    if (cycle % 2 == 0) whole.Step();
    try {
      guard.BeforeStep();
      lean.Step();
      guard.AfterStep();
    } catch (const world::OmissionGuardTripped& tripped) {
      note = fmt::format("starts again in cycle {} with all walls: {}", cycle, tripped.what());
      if (cycle % 2 == 1) whole.Step();
      break;
    }
    if (cycle % 2 == 1) whole.Step();
    if (probes::StateHash(*whole.engine) != probes::StateHash(*lean.engine)) {
      fmt::print(stderr, "cycle {}: the two worlds went different ways\n", cycle);
      std::exit(1);
    }
  }
  const double a = Median(whole.steps), b = Median(lean.steps);
  return {a / 1e3,    b / 1e3,   a / b, whole.build_ns / 1e3, lean.build_ns / 1e3,
          whole.heap, lean.heap, note};
}

void RunScene(const std::string& name, plan::Scene scene, std::uint64_t rounds,
              std::uint64_t cycles) {
  if (scene.world.WordOr("precision") != world::EnginePrecision()) return;
  scene.world.Set("record", schema::WordList{"timing"});
  scene.world.Set("omit", schema::WordList{"auto"});
  cycles = std::min(cycles, scene.world.Count("cycles"));
  std::vector<Result> results;
  for (std::uint64_t round = 0; round < rounds; ++round)
    results.push_back(RunRound(scene, cycles, round));
  const auto median = [&](auto member) {
    std::vector<double> values;
    for (const Result& result : results) values.push_back(result.*member);
    return Median(values);
  };
  const auto [least, most] = std::ranges::minmax(results, {}, &Result::ratio);
  fmt::print(
      "{:<18} {:>6} {:>9.1f} {:>9.1f} {:>6.2f} {:>6.2f} .. {:<5.2f} {:>8.0f} {:>8.0f} "
      "{:>8.0f} {:>8.0f}  {}\n",
      name, scene.ObjectCount(), median(&Result::whole_us), median(&Result::lean_us),
      median(&Result::ratio), least.ratio, most.ratio, median(&Result::whole_build_us),
      median(&Result::lean_build_us), median(&Result::whole_heap) / 1024,
      median(&Result::lean_heap) / 1024, results.front().note);
  std::fflush(stdout);
}

}  // namespace
}  // namespace cdb::bench

using namespace cdb;
using namespace cdb::bench;

int main(int argc, char** argv) {
  const ScenarioRuns runs(argc, argv, {5, 200, CDB_SOURCE_DIR "/tests/bench/omit.cdb"});
  fmt::print(
      "{} precision, {} rounds of up to {} cycles; medians; ratio: none / auto, with the "
      "range of the rounds\n",
      world::EnginePrecision(), runs.rounds, runs.cycles);
  fmt::print("{:<18} {:>6} {:>9} {:>9} {:>6} {:>15} {:>8} {:>8} {:>8} {:>8}\n", "scene", "N",
             "none, us", "auto, us", "ratio", "range", "build us", "auto", "heap kB", "auto");
  const bool good = runs.ForEach([&](const std::string& name, const plan::Scene& scene) {
    RunScene(name, scene, runs.rounds, runs.cycles);
  });
  return good ? 0 : 1;
}
