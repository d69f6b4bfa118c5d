// Overhead of the Bullet adapter: Bullet's dbvt alone, and the same behind cdb's interface, in two
// worlds of one program, cycle by cycle in turn, the order swapped each time. Gas: balls that fly
// about; pile: balls that have fallen on the floor. Pairs in the order `listed` and `sorted`; with
// the latter both worlds must be in the same state after every cycle.
// Usage: bench_adapter_f32 [ROUNDS [CYCLES]]

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "runtime/engine/probes/state_hash.h"
#include "runtime/engine/world/engine.h"
#include "tests/bench/median.h"
#include "tests/support/scene.h"

namespace cdb::bench {
namespace {

using Durations = std::array<double, protocol::kPhaseCount>;

plan::Scene MakeScene(bool is_pile, std::uint64_t quantity, const char* order) {
  plan::Scene scene = tests::DefaultScene(quantity, 2 * std::cbrt(static_cast<double>(quantity)));
  tests::SetWorld(scene, "precision", tests::Word(world::EnginePrecision()));
  tests::SetWorld(scene, "record", schema::WordList{"timing"});
  tests::SetWorld(scene, "pair_order", tests::Word(order));
  tests::SetWorld(scene, "timestep", 1.0 / 60);
  tests::SetWorld(scene, "sleeping", false);
  tests::SetWorld(scene, "acceleration", Eigen::Vector3d(0, is_pile ? -9.8 : 0, 0));
  tests::SetGroup(scene, "size", 1.2);
  tests::SetGroup(scene, "restitution", is_pile ? 0.2 : 1.0);
  tests::SetGroup(scene, "linear_velocity", tests::Normal(0.0, 3.0));
  return scene;
}

/// Ratios of one round: medians over the cycles of through / alone.
struct Ratios {
  double broad, detect, step;
  double broad_us, detect_us, step_us;  ///< alone
};

Ratios RunRound(const plan::Scene& scene, const layouts::InitialState& state, int warmup,
                int cycles, int round) {
  const auto omissions = omissions::KeepEverything(scene);
  detection::Detectors detectors{.broad = detection::MakeDetector("dbvt", scene), .narrow = {}};
  std::unique_ptr<world::Engine> alone, through;
  const auto make_alone = [&] {
    alone = std::make_unique<world::Engine>(scene, state, omissions, detection::Detectors{});
  };
  // Whoever comes first gets the smoother memory.
  if (round % 2 == 0) make_alone();
  through = std::make_unique<world::Engine>(scene, state, omissions, detectors);
  if (round % 2 == 1) make_alone();
  const bool are_alike = scene.world.WordOr("pair_order") == "sorted";
  std::vector<double> times[2][3];
  for (int cycle = 0; cycle < warmup + cycles; ++cycle) {
    for (const int which : {cycle % 2, 1 - cycle % 2}) {
      world::Engine& engine = which == 0 ? *alone : *through;
      engine.Step();
      if (cycle < warmup) continue;
      const Durations durations = engine.timed_world()->Durations();
      times[which][0].push_back(durations[protocol::IndexOf(protocol::Phase::kBroad)]);
      times[which][1].push_back(durations[protocol::IndexOf(protocol::Phase::kDetect)]);
      times[which][2].push_back(durations[protocol::IndexOf(protocol::Phase::kStep)]);
    }
    if (are_alike && probes::StateHash(*alone) != probes::StateHash(*through)) {
      fmt::print(stderr, "cycle {}: the two worlds went different ways\n", cycle);
      std::exit(1);
    }
  }
  const auto ratio = [&](int phase) { return Median(times[1][phase]) / Median(times[0][phase]); };
  return {ratio(0),
          ratio(1),
          ratio(2),
          Median(times[0][0]) / 1e3,
          Median(times[0][1]) / 1e3,
          Median(times[0][2]) / 1e3};
}

void Run(bool is_pile, std::uint64_t quantity, const char* order, int rounds, int cycles) {
  const plan::Scene scene = MakeScene(is_pile, quantity, order);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  std::vector<Ratios> results;
  for (int round = 0; round < rounds; ++round)
    results.push_back(RunRound(scene, state, is_pile ? 200 : 20, cycles, round));
  const auto shown = [&](double Ratios::*member) {
    std::vector<double> values;
    for (const Ratios& result : results) values.push_back(result.*member);
    const auto [least, most] = std::ranges::minmax(values);
    return fmt::format("{:.3f} ({:.3f} .. {:.3f})", Median(values), least, most);
  };
  fmt::print("{:<5} {:>5} {:<7} {:>8.1f} {:>8.1f} {:>8.1f}  {:<25} {:<25} {}\n",
             is_pile ? "pile" : "gas", quantity, order, results.front().broad_us,
             results.front().detect_us, results.front().step_us, shown(&Ratios::broad),
             shown(&Ratios::detect), shown(&Ratios::step));
  std::fflush(stdout);
}

}  // namespace
}  // namespace cdb::bench

using namespace cdb;
using namespace cdb::bench;

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 5;
  const int cycles = argc > 2 ? std::atoi(argv[2]) : 100;
  const std::uint64_t most = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 5000;
  fmt::print(
      "{} precision, {} rounds of {} cycles; through the interface / alone, medians and the "
      "range of the rounds\n",
      world::EnginePrecision(), rounds, cycles);
  fmt::print("{:<5} {:>5} {:<7} {:>8} {:>8} {:>8}  {:<25} {:<25} {}\n", "scene", "N", "pairs",
             "broad us", "detect", "step", "broad", "detect", "step");
  for (const char* order : {"listed", "sorted"})
    for (const bool is_pile : {false, true})
      for (const std::uint64_t quantity : {216, 1000, 5000})
        if (quantity <= most) Run(is_pile, quantity, order, rounds, cycles);
}
