// What objects of each type take: memory for each of them, the time until a scene of them has gone
// through its first cycle, and what it costs to cut a mesh into convex pieces. Heap bytes with the
// allocator's own, processor time; medians of the rounds, times with from where to where they
// reach. Usage: bench_objects_f32 [memory|start|cut|all [ROUNDS]]

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "library/layouts/initial_state.h"
#include "library/layouts/placement.h"
#include "library/objects/solid_factory.h"
#include "runtime/engine/world/engine.h"
#include "tests/bench/median.h"
#include "tests/support/cache.h"
#include "tests/support/scene.h"

namespace cdb::bench {
namespace {

double HeapBytes() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

/// Of this process's only thread, so that a busy machine does not count.
double Milliseconds(auto work) {
  const std::clock_t begin = std::clock();
  work();
  return 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

/// Objects of one type in the paper's cube, of one size or all of another.
plan::Scene SceneOf(std::string_view type, std::uint64_t objects, bool alike) {
  plan::Scene scene = tests::DefaultScene(objects, 50 * static_cast<double>(objects));
  tests::SetWorld(scene, "precision", tests::Word(world::EnginePrecision()));
  tests::SetGroup(scene, "type", tests::Word(type));
  if (!alike) tests::SetGroup(scene, "size", tests::Uniform(10.0, 90.0));
  return scene;
}

std::shared_ptr<const objects::ConvexDecomposition> FormOf(std::string_view type) {
  objects::SolidFactory maker;
  maker.Make(tests::Word(type), Eigen::Vector3d::Constant(50), Eigen::Vector3d::Ones());
  const auto forms = maker.Forms();
  return forms.empty() ? nullptr : forms.front();
}

std::size_t VertexCount(const objects::ConvexDecomposition& form) {
  std::size_t count = 0;
  for (const auto& piece : form.pieces) count += piece.vertices.size();
  return count;
}

/// Heap bytes of a scene, drawn and placed; of its engine, built; and of what the first cycle adds.
using Memory = std::array<double, 3>;

Memory MemoryOf(const plan::Scene& scene) {
  Memory memory;
  double before = HeapBytes();
  const auto more = [&] { return HeapBytes() - std::exchange(before, HeapBytes()); };
  layouts::InitialState state = layouts::MakeInitialState(scene);
  memory[0] = more();
  world::Engine engine(scene, std::move(state), omissions::KeepEverything(scene));
  memory[1] = more();
  engine.Step();
  memory[2] = more();
  return memory;
}

/// For each further object: not the form, the pools and whatever else ten take already.
Memory MemoryOfEach(std::string_view type, std::uint64_t objects, bool alike, int rounds) {
  constexpr std::uint64_t kFew = 10;
  std::array<std::vector<double>, 3> bytes;
  for (int round = 0; round < rounds; ++round) {
    const Memory few = MemoryOf(SceneOf(type, kFew, alike));
    const Memory all = MemoryOf(SceneOf(type, objects, alike));
    for (std::size_t i = 0; i < bytes.size(); ++i)
      bytes[i].push_back((all[i] - few[i]) / static_cast<double>(objects - kFew));
  }
  return {Median(bytes[0]), Median(bytes[1]), Median(bytes[2])};
}

void PrintMemory(int rounds) {
  fmt::print(
      "\nheap bytes for each object, dbvt, omit none; alike: of 5000 of one size, unlike: of 1000 "
      "of as many sizes; the form is there once, and Bullet's pools have room for 4096 pairs\n");
  fmt::print("{:<12} {:>6} {:>8} {:>9}", "type", "pieces", "vertices", "form");
  for (const char* sizes : {"alike", "unlike"})
    fmt::print(" | {:>6}: {:>6} {:>8} {:>12}", sizes, "state", "engine", "first cycle");
  fmt::print("\n");
  for (const auto& [type, doc, fill] : schema::kObjectTypeTable) {
    std::size_t vertices = 0, pieces = 1;
    double form_bytes = 0;
    if (const auto form = FormOf(type)) {
      const double before = HeapBytes();
      const auto copy = std::make_unique<const objects::ConvexDecomposition>(*form);
      form_bytes = HeapBytes() - before;
      pieces = form->pieces.size();
      vertices = VertexCount(*form);
    }
    fmt::print("{:<12} {:>6} {:>8} {:>9.0f}", type, pieces, vertices, form_bytes);
    for (const bool alike : {true, false}) {
      const Memory each = MemoryOfEach(type, alike ? 5000 : 1000, alike, rounds);
      fmt::print(" | {:>6}  {:>6.0f} {:>8.0f} {:>12.0f}", "", each[0], each[1], each[2]);
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
}

/// The parts of a start. Drawing loads the type anew, as every run does.
enum Part { kLoad, kDraw, kPlace, kNeeds, kBuild, kFirstCycle, kSecondCycle, kParts };
constexpr const char* kPartNames[kParts] = {"(load)", "draw",        "place",       "needs",
                                            "build",  "first cycle", "second cycle"};

struct Start {
  std::string_view type;
  const char* detector;
  bool lean;  ///< without what `omit auto` leaves out
  std::array<std::vector<double>, kParts> parts;
  std::vector<double> until_first_cycle, heap_mb;

  void Measure(std::uint64_t objects) {
    plan::Scene scene = SceneOf(type, objects, true);
    tests::SetWorld(scene, "detector", tests::Word(detector));
    layouts::InitialState state;
    std::unique_ptr<world::Engine> engine;
    omissions::Omissions omissions;
    double sum = 0;
    const double before = HeapBytes();
    const auto measure = [&](Part part, auto work) {
      parts[part].push_back(Milliseconds(work));
      if (part != kLoad && part != kSecondCycle) sum += parts[part].back();
    };
    measure(kLoad, [&] { FormOf(type); });
    measure(kDraw, [&] { state = layouts::DrawObjects(scene); });
    measure(kPlace, [&] { layouts::Place(scene, state); });
    measure(kNeeds, [&] {
      omissions =
          lean ? omissions::DecideOmissions(scene, state) : omissions::KeepEverything(scene);
    });
    measure(kBuild, [&] {
      engine = std::make_unique<world::Engine>(scene, std::move(state), std::move(omissions));
    });
    measure(kFirstCycle, [&] { engine->Step(); });
    measure(kSecondCycle, [&] { engine->Step(); });
    until_first_cycle.push_back(sum);
    heap_mb.push_back((HeapBytes() - before) / 1e6);
  }
};

void PrintStart(int rounds) {
  constexpr std::uint64_t kObjects = 5000;
  std::vector<Start> starts;
  for (const std::string_view type : {"sphere", "bunny", "armadillo", "torus"})
    for (const char* detector : {"dbvt", "sap"})
      for (const bool lean : {false, true}) starts.push_back({type, detector, lean, {}, {}, {}});
  // A round that nobody sees fills the caches.
  for (const Start& start : starts) Start(start).Measure(kObjects);
  for (int round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < starts.size(); ++i)
      starts[round % 2 == 0 ? i : starts.size() - 1 - i].Measure(kObjects);
  fmt::print(
      "\nms until {} objects have gone through their first cycle; draw loads the form, which "
      "(load) does by itself\n{:<10} {:<8} {:<4}",
      kObjects, "type", "detector", "omit");
  for (const char* name : kPartNames) fmt::print(" {:>22}", name);
  fmt::print(" {:>22} {:>8}\n", "until first cycle", "heap, MB");
  const auto print = [](const std::vector<double>& ms) {
    const auto [least, most] = std::ranges::minmax(ms);
    fmt::print(" {:>22}", fmt::format("{:.4g} ({:.4g}..{:.4g})", Median(ms), least, most));
  };
  for (const Start& start : starts) {
    fmt::print("{:<10} {:<8} {:<4}", start.type, start.detector, start.lean ? "auto" : "none");
    for (const auto& part : start.parts) print(part);
    print(start.until_first_cycle);
    fmt::print(" {:>8.1f}\n", Median(start.heap_mb));
  }
}

void PrintCut() {
  fmt::print("\na form with an empty cache, and found in it again\n");
  fmt::print("{:<12} {:>9} {:>9} {:>6} {:>9} {:>16} {:>7}\n", "type", "cold, s", "warm, ms",
             "hulls", "vertices", "volume error, %", "IoU");
  const tests::TemporaryCache cache;
  for (const auto& [type, doc, fill] : schema::kObjectTypeTable) {
    const auto& closed = objects::kClosedShapes;
    if (std::ranges::any_of(closed,
                            [&](objects::Shape shape) { return objects::TypeOf(shape) == type; }))
      continue;
    std::shared_ptr<const objects::ConvexDecomposition> form;
    const double cold = Milliseconds([&] { form = FormOf(type); });
    const double warm = Milliseconds([&] { form = FormOf(type); });
    fmt::print("{:<12} {:>9.2f} {:>9.2f} {:>6} {:>9} {:>16.2f} {:>7.3f}\n", type, cold / 1e3, warm,
               form->pieces.size(), VertexCount(*form), 100 * form->volume_error, form->iou);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace cdb::bench

using namespace cdb;
using namespace cdb::bench;

int main(int argc, char** argv) {
  const std::string_view part = argc > 1 ? argv[1] : "all";
  const int rounds = argc > 2 ? std::max(1, std::atoi(argv[2])) : 5;
  const auto is_asked = [&](std::string_view name) { return part == name || part == "all"; };
  fmt::print("{} precision, {} rounds\n", world::EnginePrecision(), rounds);
  if (is_asked("memory")) PrintMemory(rounds);
  if (is_asked("start")) PrintStart(rounds);
  if (is_asked("cut")) PrintCut();
}
