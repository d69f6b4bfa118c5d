// Drawing and placing against the number of objects: processor time, the median of some rounds and
// from where to where they reach, and memory while placing.
// Usage: bench_placement [MOST [PART-OF-A-SCENE'S-NAME]]

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "library/layouts/initial_state.h"
#include "library/layouts/placement.h"
#include "library/scene_error.h"
#include "tests/bench/median.h"
#include "tests/support/scene.h"

namespace {

using cdb::tests::SetGroup;

/// Of this process's only thread, so that a busy machine does not count.
double Seconds(auto work) {
  const std::clock_t begin = std::clock();
  work();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

/// Sets the peak below back to what is used now. Where the kernel has no such file, the peak is
/// that of all scenes so far.
void ForgetPeak() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";
}

/// Of the process's memory, bytes; 0 where the kernel does not tell.
double PeakMemory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return 1024 * std::strtod(line.c_str() + 6, nullptr);
  return 0;
}

/// Of every position's bits: the same number, the same places.
std::uint64_t HashOf(const cdb::layouts::InitialState& state) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const cdb::layouts::ObjectState& object : state.objects)
    for (const double x : object.pose.position)
      hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x100000001b3;
  return hash;
}

struct Case {
  std::string_view name;
  enum { kSpheres, kCuboids, kMixed } type;
  double fill;  ///< of the cube; 0 for the paper's cube, 50 m along an edge for each object
  cdb::schema::Value layout;
};

std::vector<Case> Cases() {
  const cdb::schema::Value uniform = cdb::tests::Word("uniform");
  const cdb::schema::Value normal = cdb::tests::Word("normal");
  const auto layout = [](std::string_view name,
                         const std::map<std::string_view, cdb::schema::Value>& arguments = {}) {
    return cdb::tests::Layout(name, arguments);
  };
  return {
      {"spheres, paper", Case::kSpheres, 0, uniform},
      {"clustered, paper", Case::kSpheres, 0, normal},
      {"mixed, paper", Case::kMixed, 0, uniform},
      {"clustered, 1 %", Case::kSpheres, .01, normal},
      {"spheres, 10 %", Case::kSpheres, .10, uniform},
      {"mixed, 10 %", Case::kMixed, .10, uniform},
      {"spheres, 25 %", Case::kSpheres, .25, uniform},
      {"spheres, 30 %", Case::kSpheres, .30, uniform},
      {"spheres, 35 %", Case::kSpheres, .35, uniform},
      {"cuboids, 38 %", Case::kCuboids, .38, uniform},
      {"grid, paper", Case::kSpheres, 0, layout("grid")},
      {"grid of 51 m", Case::kCuboids, 0, layout("grid", {{"spacing", 51.0}})},
      {"mixed grid, 1 %", Case::kMixed, .01, layout("grid")},
      {"stacks of 100", Case::kCuboids, 0, layout("stack", {{"height", std::uint64_t{100}}})},
      {"pyramid", Case::kCuboids, 0, layout("pyramid")},
      {"ring", Case::kSpheres, 0, layout("ring")},
      {"pile", Case::kMixed, 0, layout("pile")},
  };
}

constexpr int kRounds = 5;
/// Of all rounds together: what takes longer has fewer.
constexpr double kLongEnough = 10;

void Measure(const Case& scenario, std::uint64_t objects) {
  const double n = static_cast<double>(objects);
  cdb::plan::Scene scene = cdb::tests::DefaultScene(objects, 50 * n);
  if (scenario.type == Case::kMixed) {
    SetGroup(scene, "type", cdb::tests::AnyType());
    SetGroup(scene, "size", cdb::tests::Uniform(10.0, 90.0));
    SetGroup(scene, "orientation", cdb::tests::Word("random"));
  } else if (scenario.type == Case::kCuboids) {
    SetGroup(scene, "type", cdb::tests::Word("cuboid"));
  }
  SetGroup(scene, "location", scenario.layout);
  if (scenario.fill > 0) {
    const double fill = cdb::layouts::DrawObjects(scene).fill_fraction;
    const double side = 50 * n * std::cbrt(fill / scenario.fill * (1 + 1e-12));
    cdb::tests::SetWorld(scene, "world.side", side);
  }
  cdb::layouts::InitialState state;
  std::vector<double> draws, places;
  double memory = 0, total = 0;
  while (places.size() < kRounds && total < kLongEnough) {
    draws.push_back(Seconds([&] { state = cdb::layouts::DrawObjects(scene); }));
    ForgetPeak();
    const double before = PeakMemory();
    try {
      places.push_back(Seconds([&] { cdb::layouts::Place(scene, state); }));
    } catch (const cdb::library::SceneError& error) {
      // A small cube is full earlier, as its walls keep a larger part of it free.
      fmt::print("{:<18} {:>9} {}\n", scenario.name, objects, error.what());
      return;
    }
    memory = PeakMemory() - before;
    total += draws.back() + places.back();
  }
  const auto [least, longest] = std::ranges::minmax(places);
  const double place = cdb::bench::Median(places);
  fmt::print(
      "{:<18} {:>9} {:>9.3g} {:>9.4f} {:>9.4f} {:>9.4f} {:>9.4f} {:>6} {:>10.0f} {:>9.0f}  "
      "{:016x}\n",
      scenario.name, objects, 100 * state.fill_fraction, cdb::bench::Median(draws), place, least,
      longest, places.size(), 1e9 * place / n, memory / n, HashOf(state));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const double most = argc > 1 ? std::strtod(argv[1], nullptr) : 1e6;
  const std::string_view part = argc > 2 ? argv[2] : "";
  fmt::print("{:<18} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>6} {:>10} {:>9}  {}\n", "scene",
             "objects", "fill, %", "draw, s", "place, s", "least", "longest", "rounds", "ns/object",
             "more, B", "places");
  for (double n = 1e3; n <= most * 1.001; n *= 10)
    for (const Case& scenario : Cases())
      if (scenario.name.find(part) != std::string_view::npos)
        Measure(scenario, static_cast<std::uint64_t>(n));
}
