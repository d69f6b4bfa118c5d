// Broad phases in live scenes: Bullet's dbvt and sap32 alone, dbvt behind cdb's interface, and
// cdb's own, each in a world of its own in one program, in blocks of cycles in turn. Broad is
// boxes moved and pairs found and lost, as the series of that name. Pairs are in the order
// `sorted`, and nothing sleeps where sleep would depend on the list of pairs (but in `asleep`); so
// all worlds that list what there is have to be in the same state after every block, else the scene
// is marked.
// Times are processor time of the thread, so that other programs on the machine disturb them less.
//
// With -n, narrow phases in place of broad ones: Bullet's and those that are named, with the pairs
// of `auto`. Their worlds go different ways, and so each has its own pairs.
//
// With -t, detectors and narrow phases may use so many threads. The times do not show it, as they
// are the processor time of one; count the instructions of each with callgrind --separate-threads.
//
// Usage: bench_live_f32 [-r ROUNDS] [-c CYCLES] [-d DETECTOR]... [-n NARROW_PHASE]... [-s SCENE]...
// [-t THREADS]

#include <fmt/format.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "compiler/compile.h"
#include "compiler/yaml/plan_yaml.h"
#include "library/layouts/placement.h"
#include "runtime/engine/probes/state_hash.h"
#include "runtime/engine/worker/settle.h"
#include "runtime/engine/world/engine.h"
#include "tests/bench/median.h"
#include "tests/support/scene.h"

namespace cdb::bench {
namespace {

/// Cycles of a world before it is the next one's turn.
constexpr int kBlock = 8;
constexpr const char* kThrough = "dbvt via cdb";

struct LiveScene {
  std::string name;
  int warmup;
  std::function<plan::Scene()> make;
};

plan::Scene Balls(std::uint64_t quantity, double side, double speed, double fall) {
  plan::Scene scene = tests::DefaultScene(quantity, side);
  tests::SetWorld(scene, "timestep", 1.0 / 60);
  tests::SetWorld(scene, "sleeping", false);
  tests::SetWorld(scene, "acceleration", Eigen::Vector3d(0, -fall, 0));
  tests::SetGroup(scene, "size", 1.0);
  tests::SetGroup(scene, "restitution", fall > 0 ? 0.2 : 1.0);
  tests::SetGroup(scene, "linear_velocity", tests::Uniform(-speed, speed));
  return scene;
}

plan::Scene Gas(std::uint64_t quantity) {
  return Balls(quantity, 2 * std::cbrt(static_cast<double>(quantity)), 5, 0);
}

plan::Scene OfFile(const std::string& file, bool sleeping = false) {
  const auto compiled = compiler::Compile(CDB_SOURCE_DIR "/" + file, compiler::ReadFromDisk, {});
  plan::Scene scene = compiled.plans.front().runs.back().scene;
  tests::SetWorld(scene, "sleeping", sleeping);
  return scene;
}

std::vector<LiveScene> Scenes() {
  const auto open = [](plan::Scene scene) {
    tests::SetWorld(scene, "world.walls", tests::Word("none"));
    return scene;
  };
  const auto pile = [](std::uint64_t n) {
    return Balls(n, 2 / 1.2 * std::cbrt(static_cast<double>(n)), 3, 9.8);
  };
  return {
      {"sparse 5000", 40, [=] { return open(Balls(5000, 250000, 50, 0)); }},
      {"paper 5000", 40, [] { return Balls(5000, 250000, 50, 9.8); }},
      {"gas 4000", 40, [] { return Gas(4000); }},
      {"gas 5000", 40, [] { return Gas(5000); }},
      {"gas 20000", 4, [] { return Gas(20000); }},
      {"open gas 5000", 40, [=] { return open(Gas(5000)); }},
      {"dense 5000", 40, [] { return Balls(5000, std::cbrt(3.5 * 5000), 60, 0); }},
      {"debris 3000", 40, [] { return OfFile("library/scenarios/standard/games/debris.cdb"); }},
      {"drum 600", 400, [] { return OfFile("library/scenarios/standard/granular/drum.cdb"); }},
      {"bin 301", 60, [] { return OfFile("library/scenarios/standard/robotics/bin.cdb"); }},
      {"bunnies 5000", 10, [] { return OfFile("library/scenarios/paper/table1_09_bunnies.cdb"); }},
      {"rubble falling", 40, [] { return OfFile("library/scenarios/application/rubble.cdb"); }},
      {"rubble 1500", 400, [] { return OfFile("library/scenarios/application/rubble.cdb"); }},
      {"heap 400", 20, [] { return OfFile("library/scenarios/application/heap.cdb"); }},
      {"warehouse 1001", 60, [] { return OfFile("library/scenarios/application/warehouse.cdb"); }},
      {"ragdolls 81", 240, [] { return OfFile("library/scenarios/standard/joints/ragdolls.cdb"); }},
      {"gripper 10", 480, [] { return OfFile("library/scenarios/standard/joints/gripper.cdb"); }},
      {"asleep 5100", 180, [] { return OfFile("tests/bench/asleep.cdb", true); }},
      {"probe 2001", 400, [] { return OfFile("library/scenarios/standard/haptics/probe.cdb"); }},
      {"clutter 4020", 40,
       [] { return OfFile("library/scenarios/standard/planning/clutter.cdb"); }},
      {"pile 216", 200, [=] { return pile(216); }},
      {"pile 1000", 200, [=] { return pile(1000); }},
      {"pile 5000", 200, [=] { return pile(5000); }},
  };
}

/// A detector or a narrow phase in its world.
struct World {
  std::string name;
  std::unique_ptr<world::Engine> engine;
  std::vector<double> phase, step;  ///< us
};

/// What is compared.
struct Field {
  std::vector<std::string> names;
  protocol::Phase phase = protocol::Phase::kBroad;

  bool IsNarrow() const { return phase == protocol::Phase::kNarrow; }
};

World MakeWorld(const Field& field, const std::string& name, plan::Scene scene,
                const layouts::InitialState& state) {
  if (field.IsNarrow()) {
    tests::SetWorld(scene, "detector", tests::Word("auto"));
    tests::SetWorld(scene, "narrow_phase", tests::Word(name));
    return {name,
            std::make_unique<world::Engine>(scene, state, omissions::KeepEverything(scene)),
            {},
            {}};
  }
  const bool is_through = name == kThrough;
  tests::SetWorld(scene, "detector", tests::Word(is_through ? "dbvt" : name));
  const auto omissions = omissions::KeepEverything(scene);
  World world{name, nullptr, {}, {}};
  if (is_through) {
    const detection::Detectors detectors{.broad = detection::MakeDetector("dbvt", scene),
                                         .narrow = {}};
    world.engine = std::make_unique<world::Engine>(scene, state, omissions, detectors);
  } else {
    world.engine = std::make_unique<world::Engine>(scene, state, omissions);
  }
  return world;
}

void RunBlock(World& world, protocol::Phase phase, int cycles, bool counts) {
  for (int cycle = 0; cycle < cycles; ++cycle) {
    world.engine->Step();
    if (!counts) continue;
    const auto durations = world.engine->timed_world()->Durations();
    world.phase.push_back(durations[protocol::IndexOf(phase)] / 1e3);
    world.step.push_back(durations[protocol::IndexOf(protocol::Phase::kStep)] / 1e3);
  }
}

bool AreAlike(const std::vector<World>& worlds) {
  const std::string first = probes::StateHash(*worlds.front().engine);
  return std::ranges::all_of(
      worlds, [&](const World& world) { return probes::StateHash(*world.engine) == first; });
}

/// The points of all manifolds.
int Points(world::Engine& engine) {
  btDispatcher& dispatcher = *engine.world().getDispatcher();
  int count = 0;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
    count += dispatcher.getManifoldByIndexInternal(i)->getNumContacts();
  return count;
}

void RunScene(const LiveScene& live, const Field& field, int rounds, int cycles,
              std::uint64_t threads) {
  const std::vector<std::string>& names = field.names;
  plan::Scene scene = live.make();
  tests::SetWorld(scene, "precision", tests::Word(world::EnginePrecision()));
  tests::SetWorld(scene, "record", schema::WordList{"timing"});
  tests::SetWorld(scene, "pair_order", tests::Word("sorted"));
  tests::SetWorld(scene, "threads", threads);
  layouts::InitialState state = layouts::DrawObjects(scene);
  layouts::Place(scene, state);
  if (yaml::HasPile(scene)) worker::SettlePiles(scene, state);
  std::vector<std::vector<double>> phase(names.size()), step(names.size());
  bool are_alike = true;
  std::vector<int> pairs(names.size()), points(names.size());
  std::vector<std::string> hashes(names.size());
  for (int round = 0; round < rounds; ++round) {
    std::vector<World> worlds;
    for (const std::string& name : names) worlds.push_back(MakeWorld(field, name, scene, state));
    for (World& world : worlds) RunBlock(world, field.phase, live.warmup, false);
    for (int block = 0; block * kBlock < cycles; ++block) {
      for (std::size_t i = 0; i < worlds.size(); ++i)
        RunBlock(worlds[(i + static_cast<std::size_t>(block + round)) % worlds.size()], field.phase,
                 kBlock, true);
      are_alike = are_alike && (field.IsNarrow() || AreAlike(worlds));
    }
    for (std::size_t i = 0; i < worlds.size(); ++i) {
      phase[i].push_back(Median(worlds[i].phase));
      step[i].push_back(Median(worlds[i].step));
      pairs[i] = worlds[i].engine->world().getPairCache()->getNumOverlappingPairs();
      points[i] = Points(*worlds[i].engine);
      hashes[i] = probes::StateHash(*worlds[i].engine).substr(0, 8);
    }
  }
  fmt::print("\n{}{}\n", live.name, are_alike ? "" : ": the worlds went different ways");
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::vector<double> ratios, steps;
    for (std::size_t round = 0; round < phase[i].size(); ++round) {
      ratios.push_back(phase[0][round] / phase[i][round]);
      steps.push_back(step[0][round] / step[i][round]);
    }
    const auto [least, most] = std::ranges::minmax(ratios);
    fmt::print(
        "  {:<14} {:>9.1f} {:>8} {:>8} {:>7.2f} ({:.2f} .. {:.2f}) {:>10.1f} {:>6.2f} {:>9}\n",
        names[i], Median(phase[i]), pairs[i], points[i], Median(ratios), least, most,
        Median(step[i]), Median(steps), hashes[i]);
  }
  std::fflush(stdout);
}

int Main(int argc, char** argv) {
  int rounds = 3, cycles = 96;
  std::uint64_t threads = 1;
  Field field;
  std::vector<std::string> only;
  for (int option; (option = getopt(argc, argv, "r:c:d:n:s:t:")) != -1;) {
    switch (option) {
      case 'r':
        rounds = std::atoi(optarg);
        break;
      case 'c':
        cycles = std::atoi(optarg);
        break;
      case 'd':
        field.names.push_back(optarg);
        break;
      case 'n':
        field.names.push_back(optarg);
        field.phase = protocol::Phase::kNarrow;
        break;
      case 't':
        threads = std::strtoul(optarg, nullptr, 10);
        break;
      case 's':
        only.push_back(optarg);
        break;
      default:
        return 2;
    }
  }
  if (field.names.empty()) field.names = {"sap32", kThrough, "auto"};
  const std::string base = field.IsNarrow() ? "bullet" : "dbvt";
  field.names.insert(field.names.begin(), base);
  fmt::print(
      "{} precision, {} rounds of {} cycles; medians, and {}'s to them with the range of "
      "the rounds\n  {:<14} {:>9} {:>8} {:>8} {:>7} {:>26} {:>6} {:>9}\n",
      world::EnginePrecision(), rounds, cycles, base, "",
      field.IsNarrow() ? "narrow us" : "broad us", "pairs", "points", base + "/", "step us",
      base + "/", "state");
  for (const LiveScene& live : Scenes())
    if (only.empty() || std::ranges::count(only, live.name) > 0)
      RunScene(live, field, rounds, cycles, threads);
  return 0;
}

}  // namespace
}  // namespace cdb::bench

/// In place of the C library's: the clock of the phases shows this thread's processor time.
extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
  if (clock == CLOCK_MONOTONIC) clock = CLOCK_THREAD_CPUTIME_ID;
  return static_cast<int>(syscall(SYS_clock_gettime, clock, time));
}

int main(int argc, char** argv) { return cdb::bench::Main(argc, argv); }
