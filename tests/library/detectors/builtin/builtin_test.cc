// Each built-in detector lists exactly the overlapping pairs, however the boxes move.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "compiler/schema/catalogue.h"
#include "library/detectors/builtin/builtin.h"
#include "library/detectors/exact_pairs.h"
#include "library/detectors/kernels/kernels.h"
#include "tests/library/detectors/box_scenes.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double Vec3::*kAxes[] = {&Vec3::x, &Vec3::y, &Vec3::z};

struct Named {
  std::string name;
  std::unique_ptr<Detector> detector;
};

/// All built-in detectors that find pairs, with each kind of kernels that this CPU supports, and
/// the changes of those that keep their pairs.
std::vector<Named> All(unsigned threads = 1) {
  std::vector<Named> all;
  for (const DetectorEntry& entry : builtin::BuiltinDetectors()) {
    if (!schema::FindDetector(entry.name)->FindsPairs()) continue;
    const std::string name = entry.name;
    const Options options{.threads = threads};
    if (!builtin::MakeWithKernels(name, options, kernels::PlainKernels()))
      all.push_back({name, std::unique_ptr<Detector>(entry.make(options))});
    for (const kernels::Kernels* kernels : {&kernels::PlainKernels(), kernels::Avx2Kernels()}) {
      if (kernels == nullptr) continue;
      auto detector = builtin::MakeWithKernels(name, options, *kernels);
      if (!detector) continue;
      all.push_back({name + ", " + kernels->name, std::move(detector)});
      if (name == "auto" || name == "skin")
        all.push_back(
            {"changes of " + all.back().name,
             std::make_unique<KeptPairs>(builtin::MakeWithKernels(name, options, *kernels))});
    }
  }
  return all;
}

void ExpectExact(std::vector<Named>& all, const Scene& scene, const std::string& where) {
  const std::vector<Pair> exact = detectors::ExactPairs(scene);
  for (Named& named : all) {
    const std::vector<Pair> pairs = SortedPairs(*named.detector, scene);
    if (pairs == exact) continue;
    for (const Pair& pair : pairs) EXPECT_LT(pair.a, pair.b);
    const detectors::PairFaults faults = detectors::ComparePairs(scene, pairs);
    ADD_FAILURE() << named.name << " in " << where << ": of " << faults.exact << " pairs "
                  << faults.missed << " missed, " << faults.false_positives << " false, "
                  << faults.duplicate << " twice, " << pairs.size() << " listed";
  }
}

TEST(BuiltinDetectors, AreExactOnEveryScene) {
  for (const std::string_view name : kBoxScenes) {
    for (const bool walls : {false, true}) {
      BoxScene moving(name, 300, walls);
      std::vector<Named> all = All();
      for (Named& named : all) named.detector->Prepare(moving.View());
      for (int cycle = 0; cycle < 50; ++cycle, moving.Move())
        ExpectExact(all, moving.View(), std::string(name) + ", cycle " + std::to_string(cycle));
    }
  }
}

TEST(BuiltinDetectors, AreExactBetweenHalfSpaces) {
  for (const std::string_view name : kBoxScenes) {
    BoxScene moving(name, 300, true, 11);
    moving.CutWalls();
    std::vector<Named> all = All();
    for (Named& named : all) named.detector->Prepare(moving.View());
    for (int cycle = 0; cycle < 150; ++cycle, moving.Move())
      ExpectExact(all, moving.View(), std::string(name) + ", cycle " + std::to_string(cycle));
  }
}

TEST(BuiltinDetectors, AreExactWhereMostBodiesAreFixed) {
  for (const bool cuts_walls : {false, true}) {
    BoxScene moving("dense", 300, true, 16);
    if (cuts_walls) moving.CutWalls();
    std::vector<Named> all = All();
    const Scene start = moving.View();
    std::vector<Box> boxes(start.boxes.begin(), start.boxes.end());
    std::vector<Filter> filters(start.filters.begin(), start.filters.end());
    for (std::size_t i = 0; i < 300; ++i) filters[i].is_fixed = i % 20 != 0;
    for (int cycle = 0; cycle < 60; ++cycle, moving.Move()) {
      Scene scene = moving.View();
      for (std::size_t i = 0; i < 300; i += 20) boxes[i] = scene.boxes[i];
      scene.boxes = boxes;
      scene.filters = filters;
      ExpectExact(all, scene, "cycle " + std::to_string(cycle));
    }
  }
}

// Vertices and faces, of which either may be more; with walls, a kind that nothing may meet, boxes
// beyond floats, and boxes that are not numbers.
TEST(BuiltinDetectors, AreExactBetweenTwoClasses) {
  constexpr std::uint32_t kFirst = 2, kSecond = 4;
  for (const std::size_t firsts : {1u, 60u, 150u, 299u, 300u})
    for (const unsigned threads : {1u, 3u})
      for (const bool walls : {false, true}) {
        BoxScene moving("dense", 300, walls, 21);
        if (walls) moving.CutWalls();
        std::vector<Named> all = All(threads);
        const Scene start = moving.View();
        std::vector<Filter> filters(start.filters.begin(), start.filters.end());
        for (std::size_t i = 0; i < 300; ++i) {
          filters[i].group = i < firsts ? kFirst : kSecond;
          filters[i].mask = ~(kFirst | kSecond) | (i < firsts ? kSecond : kFirst);
        }
        for (int cycle = 0; cycle < 12; ++cycle, moving.Move()) {
          Scene scene = moving.View();
          scene.filters = filters;
          std::vector<Box> boxes(scene.boxes.begin(), scene.boxes.end());
          scene.boxes = boxes;
          if (cycle > 3) boxes[7].lower.y = boxes[250].upper.x = std::nan("");
          if (cycle > 6)
            for (Box& box : boxes) box.upper.z = std::nextafter(box.upper.z, kInfinite);
          if (cycle > 9) boxes[11].lower = {-kInfinite, -kInfinite, -kInfinite};
          ExpectExact(all, scene, std::to_string(firsts) + ", cycle " + std::to_string(cycle));
        }
      }
}

TEST(BuiltinDetectors, AreExactWhereBodiesFallAsleepAndWake) {
  for (const bool cuts_walls : {false, true}) {
    BoxScene moving("dense", 300, true, 13);
    if (cuts_walls) moving.CutWalls();
    std::vector<Named> all = All();
    for (int cycle = 0; cycle < 120; ++cycle) {
      Scene scene = moving.View();
      // All bodies are awake for a while, then all sleep, and then all but one.
      const int phase = cycle / 10 % 3;
      std::vector<std::uint8_t> is_asleep(scene.size, phase > 0);
      if (phase == 2) is_asleep[7] = 0;
      scene.is_asleep = is_asleep;
      std::vector<Box> boxes(scene.boxes.begin(), scene.boxes.end());
      if (phase == 2) boxes[7] = boxes[static_cast<std::size_t>(cycle) % 300];
      scene.boxes = boxes;
      ExpectExact(all, scene, "cycle " + std::to_string(cycle));
      if (phase == 0) moving.Move();
    }
  }
}

// A body that falls asleep has still moved in that cycle.
TEST(BuiltinDetectors, AreExactWhereMostBodiesSleep) {
  constexpr int kCycles = kAnySanitizer ? 60 : 200;
  for (const std::string_view name : {"dense", "pile", "shots"}) {
    BoxScene moving(name, 300, true, 14);
    std::vector<Named> all = All();
    std::mt19937 random(15);
    std::vector<Box> boxes(moving.View().boxes.begin(), moving.View().boxes.end());
    std::vector<std::uint8_t> is_asleep(boxes.size(), 1);
    for (int cycle = 0; cycle < kCycles; ++cycle, moving.Move()) {
      Scene scene = moving.View();
      // Now and then most are awake for a cycle, and now and then none.
      const unsigned most = cycle % 40 == 20 ? 1000 : cycle % 15 == 0 ? 0 : 40;
      for (std::size_t i = 0; i < 300; ++i) {
        const std::uint8_t was_asleep = is_asleep[i];
        is_asleep[i] = random() % 1000 >= most;
        if (was_asleep == 0 || is_asleep[i] == 0) boxes[i] = scene.boxes[i];
      }
      scene.boxes = boxes;
      scene.is_asleep = is_asleep;
      ExpectExact(all, scene, std::string(name) + ", cycle " + std::to_string(cycle));
    }
  }
}

TEST(BuiltinDetectors, AreExactWhereWallsMoveOrStandAmongTheBodies) {
  BoxScene moving("dense", 300, true, 12);
  std::vector<Named> all = All();
  Scene scene = moving.View();
  std::vector<Box> boxes(scene.boxes.begin(), scene.boxes.end());
  for (int cycle = 0; cycle < 60; ++cycle, moving.Move()) {
    scene = moving.View();
    std::ranges::copy(scene.boxes.first(300), boxes.begin());
    // Half-spaces that approach each other until they overlap, and a block in the middle.
    const double end = boxes[0].upper.x - boxes[0].lower.x;
    boxes[300] = {{-kInfinite, -kInfinite, -kInfinite}, {end * (cycle - 20), kInfinite, kInfinite}};
    boxes[301] = {{-end * cycle, -kInfinite, -kInfinite}, {kInfinite, kInfinite, kInfinite}};
    boxes[302] = {{-end, -end, -end}, {end, end, end}};
    scene.boxes = boxes;
    ExpectExact(all, scene, "moving walls, cycle " + std::to_string(cycle));
  }
}

TEST(BuiltinDetectors, FindTheSameInTheSameOrderOnAnyNumberOfThreads) {
  constexpr int kCycles = kAnySanitizer ? 4 : 20;
  for (const std::string_view name : kBoxScenes) {
    BoxScene moving(name, 3000, true, 7);
    std::vector<Named> first = All(1), second = All(1), two = All(2), three = All(3);
    for (int cycle = 0; cycle < kCycles; ++cycle, moving.Move()) {
      for (std::size_t i = 0; i < first.size(); ++i) {
        const std::vector<Pair> pairs = Listed(*first[i].detector, moving.View());
        EXPECT_EQ(Listed(*second[i].detector, moving.View()), pairs) << first[i].name;
        EXPECT_EQ(Listed(*two[i].detector, moving.View()), pairs) << first[i].name;
        EXPECT_EQ(Listed(*three[i].detector, moving.View()), pairs) << first[i].name;
      }
    }
  }
}

// Enough bodies for crowds in the grids.
TEST(BuiltinDetectors, AreExactInLargeSwarms) {
  BoxScene moving("swarms", 6000, true, 14);
  moving.CutWalls();
  std::vector<Named> all = All();
  for (int cycle = 0; cycle < 12; ++cycle, moving.Move())
    ExpectExact(all, moving.View(), "cycle " + std::to_string(cycle));
}

// More bodies than in the other tests, so that all code that uses threads in large scenes does so.
class InLargeScenes : public testing::TestWithParam<const char*> {};

TEST_P(InLargeScenes, BuiltinDetectorsFindTheSameInTheSameOrderOnThreads) {
  BoxScene moving(GetParam(), 17000, true, 7);
  moving.CutWalls();
  for (const char* name : {"skin", "grid"}) {
    std::vector<std::unique_ptr<Detector>> all;
    for (const unsigned threads : {1u, 2u, 3u})
      all.push_back(builtin::MakeWithKernels(name, {.threads = threads}, kernels::BestKernels()));
    for (int cycle = 0; cycle < 6; ++cycle, moving.Move()) {
      const std::vector<Pair> pairs = Listed(*all[0], moving.View());
      EXPECT_EQ(Listed(*all[1], moving.View()), pairs);
      EXPECT_EQ(Listed(*all[2], moving.View()), pairs);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, InLargeScenes, testing::Values("dense", "swarms"),
                         [](const auto& scene) { return std::string(scene.param); });

TEST(BuiltinDetectors, AreExactOnFewAndOddBodies) {
  for (const std::size_t count : {0u, 1u, 2u, 7u, 8u, 9u, 25u, 33u, 100u}) {
    Boxes equal, points, far, farther, lines, tiny;
    for (std::size_t i = 0; i < count; ++i) {
      const auto x = static_cast<double>(i);
      equal.Add(Cube(1, 2, 3, 1));
      points.Add(Cube(std::floor(x / 3), 0, 0, 0));
      far.Add(Cube(1e6 + x / 7, 1e6, -1e6, 0.2));
      farther.Add(Cube(1e30 * std::fmod(x, 7), -1e30, 1e30 * x, 1e30));
      lines.Add(Cube(0, x * 0.9, 0, 0.5));
      tiny.Add(Cube(x * 1e-42, 0, 0, 1e-42));
    }
    for (const Boxes& boxes : {equal, points, far, farther, lines, tiny}) {
      std::vector<Named> all = All();
      for (int cycle = 0; cycle < 3; ++cycle)
        ExpectExact(all, boxes.View(), std::to_string(count) + " bodies");
    }
  }
}

TEST(BuiltinDetectors, AreExactBeyondFloats) {
  Boxes boxes;
  boxes.Add({{0, 0, 0}, {1e39, 1, 1}});
  boxes.Add({{1e39, 0, 0}, {1e40, 1, 1}});
  boxes.Add({{-1e300, 0, 0}, {-1e39, 1, 1}});
  boxes.Add({{-1e39, 0, 0}, {0, 1, 1}});
  boxes.Add({{std::nextafter(1e39, kInfinite), 0, 0}, {1e39 * 2, 1, 1}});
  boxes.Add({{-kInfinite, 0.5, 0}, {kInfinite, 0.5, kInfinite}});
  boxes.Add({{-kInfinite, -kInfinite, -kInfinite}, {kInfinite, kInfinite, kInfinite}});
  for (int i = 0; i < 2; ++i) {
    boxes.Add({{kInfinite, 0, 0}, {kInfinite, 1, 1}});
    boxes.Add({{0, -kInfinite, 0}, {1, -kInfinite, 1}});
    boxes.Add({{kInfinite, kInfinite, kInfinite}, {kInfinite, kInfinite, kInfinite}});
    boxes.Add({{-kInfinite, -kInfinite, -kInfinite}, {-kInfinite, -kInfinite, -kInfinite}});
  }
  for (int i = 0; i < 40; ++i) boxes.Add(Cube(i * (1 + 1e-16), 0.1, 1. / 3, 0.5 - 1e-17 * i));
  std::vector<Named> all = All();
  for (int cycle = 0; cycle < 3; ++cycle) ExpectExact(all, boxes.View(), "beyond");
}

TEST(BuiltinDetectors, BoxesThatAreNotNumbersOverlapNothing) {
  Boxes boxes;
  for (int i = 0; i < 60; ++i) boxes.Add(Cube(i % 10, i % 7, 0, 0.6));
  boxes.Add({{-kInfinite, -kInfinite, -kInfinite}, {kInfinite, kInfinite, kInfinite}});
  boxes.Add({{-kInfinite, -kInfinite, -kInfinite}, {kInfinite, kInfinite, kInfinite}},
            {.is_fixed = true});
  std::vector<Named> all = All();
  std::mt19937 random(3);
  for (int cycle = 0; cycle < 60; ++cycle) {
    const std::vector<Box> before = boxes.boxes;
    for (int k = 0; k < cycle % 4; ++k) {
      Box& box = boxes.boxes[random() % 60];
      (random() % 2 ? box.lower : box.upper).*kAxes[random() % 3] = NAN;
    }
    if (cycle % 10 == 9)
      for (Box& box : boxes.boxes) box.lower.y = NAN;
    ExpectExact(all, boxes.View(), "cycle " + std::to_string(cycle));
    if (cycle % 3 == 0) boxes.boxes = before;
  }
}

TEST(BuiltinDetectors, ListNoPairThatMayNotCollide) {
  std::mt19937 random(5);
  for (const int kind : {0, 1, 2}) {
    Boxes boxes;
    for (int i = 0; i < 200; ++i) {
      Filter filter;
      if (kind == 0) filter.is_fixed = i >= 100;    // more fixed bodies than can be walls
      if (kind == 1) filter.is_fixed = i % 3 == 0;  // fixed bodies among the others
      if (kind == 2)
        filter = {.group = 1u << random() % 3, .mask = static_cast<std::uint32_t>(random() % 8)};
      boxes.Add(Cube(random() % 10, random() % 10, random() % 4, 0.7), filter);
    }
    for (int i = 0; i < 6; ++i)
      boxes.Add({{-kInfinite, -kInfinite, -kInfinite}, {kInfinite, kInfinite, double(i)}},
                {.group = 2, .mask = 1, .is_fixed = true});
    std::vector<Named> all = All();
    for (int cycle = 0; cycle < 20; ++cycle) {
      ExpectExact(all, boxes.View(), "kind " + std::to_string(kind));
      for (int k = 0; k < 20; ++k) boxes.boxes[random() % 200] = Cube(random() % 10, 0, 1, 0.7);
    }
  }
}

/// Moves a scene in ways that physics does not.
void Disturb(std::vector<Box>& boxes, int how, std::mt19937_64& random) {
  const auto uniform = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  const auto any = [&]() -> Box& { return boxes[random() % boxes.size()]; };
  switch (how) {
    case 0:  // a few teleport
      for (int k = 0; k < 3; ++k) any() = Cube(uniform(-9, 9), uniform(-9, 9), uniform(-9, 9), 1);
      break;
    case 1:  // all grow
      for (Box& box : boxes)
        for (const auto axis : kAxes) box.upper.*axis += 0.02;
      break;
    case 2:  // one is as large as the scene for a while
      any() = Cube(0, 0, 0, 20);
      break;
    case 3:  // all collapse into a line
      for (Box& box : boxes) box.lower.y = box.upper.y = 0;
      break;
    case 4:  // all jump
      for (Box& box : boxes) box = Cube(uniform(-9, 9), uniform(-9, 9), uniform(-9, 9), 0.7);
      break;
    case 5:  // one moves while all sleep
      boxes[0] = Cube(uniform(-9, 9), 0, 0, 0.7);
      break;
    case 6:  // far away
      any() = Cube(1e12 * uniform(-1, 1), 0, 1e30, uniform(0, 1e10));
      break;
    case 7:  // a swarm
      for (std::size_t i = 0; i < boxes.size() / 2; ++i)
        boxes[i] = Cube(uniform(3, 3.1), uniform(3, 3.1), uniform(3, 3.1), 0.01);
      break;
    case 8:  // all drift
      for (Box& box : boxes) {
        box.lower.x += 0.1;
        box.upper.x += 0.1;
      }
      break;
    case 9:  // sizes of five orders of magnitude
      for (Box& box : boxes)
        box = Cube(uniform(-9, 9), uniform(-9, 9), uniform(-9, 9), std::pow(10, uniform(-4, 1)));
      break;
    case 10:  // NaN, until the box is set again
      any().lower.x = std::numeric_limits<double>::quiet_NaN();
      break;
    default:  // nothing happens
      break;
  }
}

TEST(BuiltinDetectors, AreExactWhateverHappens) {
  std::mt19937_64 random(11);
  constexpr int kRounds = kAnySanitizer ? 9 : 36;
  constexpr int kFewestThreads = kThreadSanitizer ? 2 : 1;  // a single thread has no data races
  for (int round = 0; round < kRounds; ++round) {
    Boxes boxes;
    const std::size_t count = 1 + random() % 400;
    for (std::size_t i = 0; i < count; ++i) boxes.Add({});
    if (round % 3 == 0) boxes.Add(Cube(0, -10, 0, 10), {.is_fixed = true});
    Disturb(boxes.boxes, 4, random);
    std::vector<Named> all = All(kFewestThreads + round % 2);
    // Some disturbances continue for a while, because detectors adapt to them.
    int how = 8;
    for (int cycle = 0; cycle < 120; ++cycle) {
      if (random() % 8 == 0) how = static_cast<int>(random() % 14);
      Disturb(boxes.boxes, random() % 6 == 0 ? static_cast<int>(random() % 14) : how, random);
      ExpectExact(all, boxes.View(),
                  "round " + std::to_string(round) + ", cycle " + std::to_string(cycle));
      if (HasFailure()) return;
    }
  }
}

TEST(BuiltinDetectors, AreExactWhenTheSceneChangesItsSize) {
  std::vector<Named> all = All();
  for (const std::size_t count : {300u, 10u, 500u, 0u, 40u}) {
    BoxScene moving("dense", count, true);
    for (Named& named : all) named.detector->Prepare(moving.View());
    for (int cycle = 0; cycle < 10; ++cycle, moving.Move())
      ExpectExact(all, moving.View(), std::to_string(count));
  }
}

TEST(BuiltinDetectors, AreExactOnBoxesOfAnyKind) {
  std::mt19937_64 random(7);
  const double corners[] = {-1e30, -3, -1, -0.5, 0, 0, 0.5, 1, 1, 3, 1e6, 1e30, INFINITY, NAN};
  std::uniform_int_distribution<std::size_t> pick(0, std::size(corners) - 1);
  for (int round = 0; round < 300; ++round) {
    Boxes bodies(std::vector<Box>(40));
    for (Box& box : bodies.boxes)
      for (const auto axis : kAxes) {
        double a = corners[pick(random)], b = round % 2 == 0 ? a : corners[pick(random)];
        if (b < a) std::swap(a, b);
        box.lower.*axis = a == INFINITY ? -INFINITY : a;
        box.upper.*axis = b;
      }
    for (std::size_t i = 0; i < bodies.filters.size(); i += 5) bodies.filters[i].is_fixed = true;
    const Scene scene = bodies.View();
    std::vector<Named> all = All();
    for (Named& named : all) named.detector->Prepare(scene);
    ExpectExact(all, scene, "round " + std::to_string(round));
  }
}

}  // namespace
}  // namespace cdb::tests
