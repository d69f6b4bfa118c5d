// Piles: what settling one costs, and how still the run is that begins with it.
//
// A row is a pile, settled anew: processor time, also of the double-precision worker, which settles
// for the other; the height of its top and the mean height of its objects above the floor; then, of
// the first second of a run that begins with it: the greatest speed, the way of the object that
// went farthest, the objects that went farther than a twentieth of the diameter, the deepest
// penetration; and the verdict on two seconds. Lengths are in diameters, the mean of the objects;
// speeds in diameters a second.
//
// Usage: bench_pile_f64 [-n OBJECTS]... [-t TYPE]... [-s SEEDS] [-k]
//   -k  keeps the cache of the environment: piles that are in it are not settled

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "library/layouts/initial_state.h"
#include "library/scene_error.h"
#include "runtime/engine/worker/run_scene.h"
#include "runtime/engine/worker/settle.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/engine.h"
#include "runtime/engine/world/manifolds.h"
#include "runtime/protocol/verdict.h"
#include "tests/support/cache.h"
#include "tests/support/scene.h"

namespace cdb::bench {
namespace {

struct PileType {
  std::string name;
  schema::Value type;
  Eigen::Vector3d aspect = Eigen::Vector3d::Ones();
};

std::vector<PileType> PileTypes() {
  return {{"mixed", tests::AnyType()},
          {"sphere", tests::Word("sphere")},
          {"cylinder", tests::Word("cylinder")},
          {"cuboid", tests::Word("cuboid")},
          {"thin", tests::Word("cuboid"), {1, 0.1, 1}}};
}

plan::Scene PileScene(const PileType& type, std::uint64_t quantity, std::uint64_t seed) {
  plan::Scene scene = tests::DefaultScene(quantity, 100);
  tests::SetWorld(scene, "precision", tests::Word(world::EnginePrecision()));
  tests::SetWorld(scene, "world.walls", tests::Word("floor"));
  tests::SetWorld(scene, "sleeping", false);
  tests::SetGroup(scene, "type", type.type);
  tests::SetGroup(scene, "aspect", schema::Ratio{type.aspect});
  tests::SetGroup(scene, "size", 1.0);
  tests::SetGroup(scene, "orientation", tests::Word("random"));
  tests::SetGroup(scene, "location", schema::Call{"pile", {tests::Word("fit")}});
  tests::SeedStreams(scene, seed);
  return scene;
}

/// s, of this process and of those that it waited for.
double ProcessorTime() {
  double seconds = 0;
  for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage = {};
    getrusage(who, &usage);
    for (const timeval& time : {usage.ru_utime, usage.ru_stime})
      seconds += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  }
  return seconds;
}

struct Height {
  double top = 0, mean = 0;  ///< m above the floor
};

Height HeightOf(const layouts::InitialState& state, double floor) {
  Height height;
  for (const layouts::ObjectState& object : state.objects) {
    const objects::Box box = objects::Bounds(object.solid, object.pose.orientation);
    height.top = std::max(height.top, object.pose.position.y() + box.upper.y() - floor);
    height.mean += (object.pose.position.y() - floor) / static_cast<double>(state.objects.size());
  }
  return height;
}

struct Stillness {
  double fastest = 0, farthest = 0, deepest = 0;
  int moved = 0;
};

Stillness FirstSecond(const plan::Scene& scene, const layouts::InitialState& state,
                      double diameter) {
  world::Engine engine(scene, state, omissions::KeepEverything(scene));
  Stillness still;
  for (int step = 0; step < 60; ++step) {
    engine.Step();
    for (const auto& body : engine.objects())
      still.fastest = std::max(still.fastest, world::ToEigen(body->getLinearVelocity()).norm());
    for (const btPersistentManifold& manifold : world::TouchingManifolds(engine.world()))
      for (int i = 0; i < manifold.getNumContacts(); ++i)
        still.deepest = std::max(still.deepest,
                                 -static_cast<double>(manifold.getContactPoint(i).getDistance()));
  }
  for (std::size_t i = 0; i < state.objects.size(); ++i) {
    const Eigen::Vector3d place =
        world::ToEigen(engine.objects()[i]->getWorldTransform().getOrigin());
    const double way = (place - state.objects[i].pose.position).norm();
    still.farthest = std::max(still.farthest, way);
    still.moved += way > diameter / 20 ? 1 : 0;
  }
  still.fastest /= diameter;
  still.farthest /= diameter;
  still.deepest /= diameter;
  return still;
}

protocol::Verdict VerdictOf(plan::Scene scene) {
  plan::Run run;
  run.scene = std::move(scene);
  tests::SetWorld(run.scene, "cycles", std::uint64_t{120});
  protocol::Recording recording = protocol::Recording::Create(run.scene);
  worker::RunScene(run, recording, {});
  return protocol::Judge(run.scene, recording, recording.header().cycles_done.load()).verdict;
}

void MeasurePile(const PileType& type, std::uint64_t quantity, std::uint64_t seed) {
  const plan::Scene scene = PileScene(type, quantity, seed);
  layouts::InitialState state = layouts::MakeInitialState(scene);
  double diameter = 0;
  for (const layouts::ObjectState& object : state.objects)
    diameter += 2 * object.solid.OuterRadius() / static_cast<double>(quantity);
  const double begin = ProcessorTime();
  std::string failure;
  try {
    worker::SettlePiles(scene, state);
  } catch (const library::SceneError& error) {
    failure = error.what();
  }
  const double seconds = ProcessorTime() - begin;
  if (!failure.empty()) {
    fmt::print("  {:<8} {:>6} {:>4} {:>8.2f} {}\n", type.name, quantity, seed, seconds, failure);
    return;
  }
  const Height height = HeightOf(state, -scene.world.Real("world.side") / 2);
  const Stillness still = FirstSecond(scene, state, diameter);
  fmt::print("  {:<8} {:>6} {:>4} {:>8.2f} {:>7.2f} {:>7.3f} {:>9.4f} {:>9.4f} {:>6} {:>9.4f} {}\n",
             type.name, quantity, seed, seconds, height.top / diameter, height.mean / diameter,
             still.fastest, still.farthest, still.moved, still.deepest,
             protocol::VerdictName(VerdictOf(scene)));
  std::fflush(stdout);
}

int Main(int argc, char** argv) {
  std::vector<std::uint64_t> quantities;
  std::vector<std::string> names;
  std::uint64_t seeds = 3;
  bool keeps = false;
  for (int option; (option = getopt(argc, argv, "n:t:s:k")) != -1;) {
    switch (option) {
      case 'n':
        quantities.push_back(std::strtoull(optarg, nullptr, 10));
        break;
      case 't':
        names.emplace_back(optarg);
        break;
      case 's':
        seeds = std::strtoull(optarg, nullptr, 10);
        break;
      case 'k':
        keeps = true;
        break;
      default:
        return 2;
    }
  }
  if (quantities.empty()) quantities = {200, 1000};
  std::optional<tests::TemporaryCache> cache;
  if (!keeps) cache.emplace();
  fmt::print("{} precision\n  {:<8} {:>6} {:>4} {:>8} {:>7} {:>7} {:>9} {:>9} {:>6} {:>9}\n",
             world::EnginePrecision(), "", "n", "seed", "s", "top", "mean", "fastest", "farthest",
             "moved", "deepest");
  for (const PileType& type : PileTypes())
    for (const std::uint64_t quantity : quantities)
      for (std::uint64_t seed = 1; seed <= seeds; ++seed)
        if (names.empty() || std::ranges::count(names, type.name) > 0)
          MeasurePile(type, quantity, seed);
  return 0;
}

}  // namespace
}  // namespace cdb::bench

int main(int argc, char** argv) { return cdb::bench::Main(argc, argv); }
