// Drawing and placing against the number of objects: processor time, and memory while placing.
// Usage: bench_placement [MOST [PART-OF-A-SCENE'S-NAME]]

#include <fmt/format.h>
#include <malloc.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string_view>

#include "library/layouts/initial_state.h"
#include "library/layouts/placement.h"
#include "library/scene_error.h"
#include "tests/library/test_scene.h"

namespace {

using cdb::test::SetGroup;

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
std::uint64_t HashOf(const cdb::library::InitialState& state) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const cdb::library::ObjectState& object : state.objects)
    for (const double x : object.pose.position)
      hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x100000001b3;
  return hash;
}

struct Case {
  std::string_view name;
  enum { kSpheres, kCuboids, kMixed } type;
  double fill;  ///< of the cube; 0 for the paper's cube, 50 m along an edge for each object
  bool normal;
};

constexpr Case kCases[] = {
    {"spheres, paper", Case::kSpheres, 0, false},  {"clustered, paper", Case::kSpheres, 0, true},
    {"mixed, paper", Case::kMixed, 0, false},      {"clustered, 1 %", Case::kSpheres, .01, true},
    {"spheres, 10 %", Case::kSpheres, .10, false}, {"mixed, 10 %", Case::kMixed, .10, false},
    {"spheres, 25 %", Case::kSpheres, .25, false}, {"spheres, 30 %", Case::kSpheres, .30, false},
    {"spheres, 35 %", Case::kSpheres, .35, false}, {"cuboids, 38 %", Case::kCuboids, .38, false},
};

void Measure(const Case& scenario, std::uint64_t objects) {
  const double n = static_cast<double>(objects);
  cdb::compiler::Scene scene = cdb::test::DefaultScene(objects, 50 * n);
  if (scenario.type == Case::kMixed) {
    SetGroup(scene, "type", cdb::test::AnyType());
    SetGroup(scene, "size", cdb::test::Uniform(10.0, 90.0));
    SetGroup(scene, "orientation", cdb::test::Word("random"));
  } else if (scenario.type == Case::kCuboids) {
    SetGroup(scene, "type", cdb::test::Word("cuboid"));
  }
  if (scenario.normal) SetGroup(scene, "location", cdb::test::Word("normal"));
  if (scenario.fill > 0) {
    const double fill = cdb::library::DrawObjects(scene).fill_fraction;
    const double side = 50 * n * std::cbrt(fill / scenario.fill * (1 + 1e-12));
    cdb::test::SetWorld(scene, "world.side", side);
  }
  cdb::library::InitialState state;
  const double draw = Seconds([&] { state = cdb::library::DrawObjects(scene); });
  ForgetPeak();
  const double before = PeakMemory();
  double place = 0;
  try {
    place = Seconds([&] { cdb::library::Place(scene, state); });
  } catch (const cdb::library::SceneError& error) {
    // A small cube is full earlier, as its walls keep a larger part of it free.
    fmt::print("{:<18} {:>9} {}\n", scenario.name, objects, error.what());
    return;
  }
  fmt::print(
      "{:<18} {:>9} {:>9.3g} {:>9.4f} {:>9.4f} {:>9.4f} {:>10.0f} {:>9.0f} {:>9.0f}  {:016x}\n",
      scenario.name, objects, 100 * state.fill_fraction, draw, place, draw + place,
      1e9 * (draw + place) / n, static_cast<double>(sizeof(cdb::library::ObjectState)),
      (PeakMemory() - before) / n, HashOf(state));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const double most = argc > 1 ? std::strtod(argv[1], nullptr) : 1e6;
  const std::string_view part = argc > 2 ? argv[2] : "";
  fmt::print("{:<18} {:>9} {:>9} {:>9} {:>9} {:>9} {:>10} {:>9} {:>9}  {}\n", "scene", "objects",
             "fill, %", "draw, s", "place, s", "both, s", "ns/object", "state, B", "more, B",
             "places");
  for (double n = 1e3; n <= most * 1.001; n *= 10)
    for (const Case& scenario : kCases)
      if (scenario.name.find(part) != std::string_view::npos)
        Measure(scenario, static_cast<std::uint64_t>(n));
}
