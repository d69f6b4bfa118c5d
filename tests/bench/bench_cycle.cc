// Overhead of the runner in a cycle: its engine against the same scene written by hand, in one
// program, cycle by cycle in strict alternation, the order swapped each time. Both must end with
// the same state hash.
// Usage: bench_cycle_f32 [ROUNDS] [CYCLES]

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "runtime/engine/probes/probes.h"
#include "runtime/engine/probes/state_hash.h"
#include "runtime/engine/world/engine.h"
#include "tests/bench/hand_written.h"
#include "tests/bench/median.h"
#include "tests/support/scene.h"

namespace cdb::bench {
namespace {

struct Case {
  const char* name;
  std::uint64_t objects;
  bool mixed;
  double side;
};

plan::Scene SceneOf(const Case& c, std::uint64_t cycles, std::uint64_t seed) {
  plan::Scene scene = tests::DefaultScene(c.objects, c.side);
  tests::SetWorld(scene, "cycles", cycles);
  tests::SetWorld(scene, "precision", tests::Word(world::EnginePrecision()));
  tests::SeedStreams(scene, seed);
  if (c.mixed) {
    tests::SetGroup(scene, "type",
                    schema::Distribution{
                        schema::DistributionKind::kAny,
                        {tests::Word("sphere"), tests::Word("cuboid"), tests::Word("cylinder")},
                        {1, 1, 1}});
    tests::SetGroup(scene, "orientation", tests::Word("random"));
  }
  return scene;
}

/// All of Bullet, as the hand-written scene has it.
std::unique_ptr<world::Engine> MakeEngine(const plan::Scene& scene,
                                          const layouts::InitialState& state) {
  return std::make_unique<world::Engine>(scene, state, omissions::KeepEverything(scene));
}

/// Medians of one round.
struct Round {
  double runner, hand, between;
};

Round RunRound(const Case& c, std::uint64_t cycles, std::uint64_t round) {
  const plan::Scene scene = SceneOf(c, cycles, round);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  protocol::Recording recording = protocol::Recording::Create(scene);
  std::unique_ptr<world::Engine> engine;
  std::unique_ptr<HandWritten> hand;
  // Whoever comes first gets the smoother memory.
  if (round % 2 == 0) engine = MakeEngine(scene, state);
  hand = std::make_unique<HandWritten>(state, c.side);
  if (round % 2 == 1) engine = MakeEngine(scene, state);
  probes::Probes probes(scene, *engine, recording, -1);
  probes.Begin();
  std::vector<double> by_hand, between;
  const double timestep = scene.world.Real("timestep");
  for (std::uint64_t cycle = 0; cycle < cycles; ++cycle) {
    const bool hand_first = cycle % 2 == 0;
    if (hand_first) by_hand.push_back(hand->Step(timestep));
    engine->Step();
    const auto begin = world::Now();
    probes.Record(cycle);
    between.push_back(static_cast<double>(world::Now() - begin));
    if (!hand_first) by_hand.push_back(hand->Step(timestep));
  }
  if (probes::StateHash(*engine) !=
      probes::StateHash(hand->objects().data(), hand->objects().size())) {
    fmt::print(stderr, "{}: the two worlds went different ways; the times mean nothing\n", c.name);
    std::exit(1);
  }
  const auto steps = recording.Reals("duration")
                         .subspan(protocol::IndexOf(protocol::Phase::kStep) * cycles, cycles);
  return {Median({steps.begin(), steps.end()}), Median(by_hand), Median(between)};
}

void RunCase(const Case& c, std::uint64_t rounds, std::uint64_t cycles) {
  std::vector<double> ratios, runner, hand, between;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    const Round r = RunRound(c, cycles, round);
    ratios.push_back(r.runner / r.hand);
    runner.push_back(r.runner);
    hand.push_back(r.hand);
    between.push_back(r.between);
  }
  const auto [least, most] = std::ranges::minmax(ratios);
  fmt::print("{:<14} {:>6} {:>12.2f} {:>12.2f} {:>8.4f} {:>8.4f} .. {:.4f} {:>14.2f}\n", c.name,
             c.objects, Median(runner) / 1e3, Median(hand) / 1e3, Median(ratios), least, most,
             Median(between) / 1e3);
  std::fflush(stdout);
}

}  // namespace
}  // namespace cdb::bench

using namespace cdb;
using namespace cdb::bench;

int main(int argc, char** argv) {
  const auto argument = [&](int i, std::uint64_t otherwise) {
    return argc > i ? std::strtoull(argv[i], nullptr, 10) : otherwise;
  };
  const std::uint64_t rounds = argument(1, 9), cycles = argument(2, 200);
  fmt::print(
      "{} precision, {} rounds of {} cycles; us, medians; ratio: median and range of the "
      "rounds\n{:<14} {:>6} {:>12} {:>12} {:>8} {:>20} {:>14}\n",
      world::EnginePrecision(), rounds, cycles, "scene", "N", "runner", "by hand", "ratio", "range",
      "between cycles");
  const Case cases[] = {
      {"spheres", 100, false, 5000},      {"spheres", 1000, false, 50000},
      {"spheres", 5000, false, 250000},   {"mixed", 100, true, 5000},
      {"mixed", 1000, true, 50000},       {"mixed", 5000, true, 250000},
      {"mixed, dense", 100, true, 400},   {"mixed, dense", 1000, true, 800},
      {"mixed, dense", 5000, true, 1400},
  };
  for (const auto& c : cases) RunCase(c, rounds, cycles);
}
