// Objects that come and go, under every detector that knows them.
#include "runtime/engine/world/population.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "compiler/schema/catalogue.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

schema::Value Between(const Vector3d& lower, const Vector3d& upper) {
  return schema::Call{"box", {lower, upper}};
}

/// Balls that come at a height of 5 to 9 m and leave below -8 m; on their way is a ledge.
plan::Scene Rain(std::uint64_t quantity, const char* detector = "dbvt",
                 schema::WordList record = {"counts"}) {
  plan::Scene scene = EngineScene(quantity, 20);
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "cycles", std::uint64_t{400});
  SetWorld(scene, "detector", Word(detector));
  SetWorld(scene, "pair_order", Word("sorted"));
  SetWorld(scene, "sleeping", false);  // the pairs that are listed decide what sleeps together
  SetWorld(scene, "record", std::move(record));
  SetGroup(scene, "size", schema::Call{"same", {Uniform(0.4, 0.8)}});
  SetGroup(scene, "region", Between(Vector3d(-2, 5, -2), Vector3d(2, 9, 2)));
  SetGroup(scene, "spawn.batch", std::uint64_t{5});
  SetGroup(scene, "spawn.every", std::uint64_t{4});
  SetGroup(scene, "spawn.start", std::uint64_t{10});
  SetGroup(scene, "remove.below", -8.0);
  scene.groups.push_back(EngineScene(1, 20).groups[0]);
  scene.groups[1].name = "ledge";
  SetGroup(scene, "type", Word("cuboid"), 1);
  SetGroup(scene, "size", 4.0, 1);
  SetGroup(scene, "aspect", schema::Ratio{Vector3d(1, 0.2, 1)}, 1);
  SetGroup(scene, "mass", Word("fixed"), 1);
  SetGroup(scene, "location", schema::Call{"at", {Vector3d(0, -2, 0)}}, 1);
  SeedStreams(scene);
  return scene;
}

std::int64_t SumOf(std::span<const std::int32_t> values) {
  return std::accumulate(values.begin(), values.end(), std::int64_t{0});
}

std::vector<std::string> KnowingDetectors() {
  std::vector<std::string> names;
  for (const schema::DetectorInfo& info : schema::Detectors())
    if (info.part.empty() && info.FindsPairs()) names.emplace_back(info.name);
  return names;
}

TEST(Population, EveryDetectorMovesThemAlikeAndMissesNoPair) {
  std::string hash;
  for (const std::string& detector : KnowingDetectors()) {
    const Recorded run = RunHere(Rain(150, detector.c_str(), {"pairs", "counts"}));
    ASSERT_TRUE(run.done()) << detector << ": " << run.message();
    if (hash.empty()) hash = run.hash();
    EXPECT_EQ(run.hash(), hash) << detector;
    EXPECT_GT(SumOf(run.recording.Ints("exact_pairs")), 1000);
    EXPECT_EQ(SumOf(run.recording.Ints("missed_pairs")), 0) << detector << run.message();
    EXPECT_EQ(SumOf(run.recording.Ints("duplicate_pairs")), 0) << detector;
    EXPECT_GT(SumOf(run.recording.Ints("departed")), 50);
  }
}

// Through the detector interface, with contacts by cdb: the narrow phase misses none, either.
TEST(Population, EveryBroadPhaseServesTheNarrowPhaseOfCdb) {
  std::string hash;
  for (const std::string& detector : KnowingDetectors()) {
    plan::Scene scene = Rain(150, detector.c_str(), {"pairs", "counts"});
    SetWorld(scene, "narrow_phase", Word("batch"));
    const Recorded run = RunHere(scene);
    ASSERT_TRUE(run.done()) << detector << ": " << run.message();
    if (hash.empty()) hash = run.hash();
    EXPECT_EQ(run.hash(), hash) << detector;
    EXPECT_EQ(SumOf(run.recording.Ints("missed_pairs")), 0) << detector << run.message();
    EXPECT_GT(SumOf(run.recording.Ints("exact_contacts")), 500);
    EXPECT_EQ(SumOf(run.recording.Ints("missed_contacts")), 0) << detector;
    EXPECT_EQ(SumOf(run.recording.Ints("false_contacts")), 0) << detector;
  }
}

// Groups that may not touch each other have their filters from the first cycle they are there.
TEST(Population, FiltersHoldForThoseThatCome) {
  std::string hash;
  for (const std::string& detector : KnowingDetectors()) {
    plan::Scene scene = Rain(100, detector.c_str(), {"pairs", "counts"});
    SetGroup(scene, "collides_with", schema::WordList{"ledge"});
    const Recorded run = RunHere(scene);
    ASSERT_TRUE(run.done()) << detector << ": " << run.message();
    if (hash.empty()) hash = run.hash();
    EXPECT_EQ(run.hash(), hash) << detector;
    EXPECT_EQ(SumOf(run.recording.Ints("missed_pairs")), 0) << detector << run.message();
    EXPECT_GT(SumOf(run.recording.Ints("exact_pairs")), 10);
  }
}

TEST(Population, RepeatsToTheBitAndCountsAddUp) {
  const Recorded first = RunHere(Rain(150, "auto")), second = RunHere(Rain(150, "auto"));
  EXPECT_EQ(first.hash(), second.hash());
  const protocol::Recording& got = first.recording;
  std::int32_t there = 1;  // the ledge
  for (std::size_t i = 0; i < 400; ++i) {
    there += got.Ints("spawned")[i] - got.Ints("departed")[i];
    EXPECT_EQ(got.Ints("present")[i], there) << i;
    const bool is_due = i >= 10 && (i - 10) % 4 == 0 && i < 10 + 4 * 30;
    EXPECT_EQ(got.Ints("spawned")[i], is_due ? 5 : 0) << i;
    EXPECT_EQ(got.Ints("waiting")[i], 0) << i;
  }
  EXPECT_EQ(SumOf(got.Ints("spawned")), 150);
  EXPECT_GT(there, 1);
}

// Little's law: the mean number in a stationary system is the rate times the time that each stays,
// here that of a fall, v(n + 1) = v(n) - g dt, from a known height.
TEST(Population, PresentIsTheRateTimesTheTimeOfTheFall) {
  plan::Scene scene = EngineScene(2000, 400);
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "cycles", std::uint64_t{300});
  SetWorld(scene, "warmup", std::uint64_t{200});
  SetWorld(scene, "record", schema::WordList{"counts"});
  SetGroup(scene, "size", 1.0);
  SetGroup(scene, "collides_with", schema::WordList{"none"});
  SetGroup(scene, "region", Between(Vector3d(-150, 9.4999, -150), Vector3d(150, 10.5001, 150)));
  SetGroup(scene, "spawn.batch", std::uint64_t{3});
  SetGroup(scene, "remove.below", -20.0);
  SeedStreams(scene);
  const Recorded run = RunHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  const double step = 1.0 / 60;
  std::int32_t steps = 0;
  for (double y = 10, v = 0; y >= -20; ++steps) {
    v -= 9.8 * step;
    y += v * step;
  }
  for (std::size_t i = 0; i < 300; ++i) {
    EXPECT_EQ(run.recording.Ints("present")[i], 3 * steps) << i;
    EXPECT_EQ(run.recording.Ints("departed")[i], 3) << i;
  }
}

TEST(Population, LifetimeAndBoxEndTheirStay) {
  plan::Scene scene = Rain(40);
  SetGroup(scene, "remove.below", Word("never"));
  SetGroup(scene, "remove.after", std::uint64_t{12});
  const Recorded aged = RunHere(scene);
  ASSERT_TRUE(aged.done()) << aged.message();
  for (std::size_t i = 12; i < 100; ++i)
    EXPECT_EQ(aged.recording.Ints("departed")[i], aged.recording.Ints("spawned")[i - 12]) << i;

  SetGroup(scene, "remove.after", Word("never"));
  SetGroup(scene, "remove.outside", Between(Vector3d(-10, 3, -10), Vector3d(10, 10, 10)));
  const Recorded boxed = RunHere(scene);
  SetGroup(scene, "remove.outside", Word("never"));
  SetGroup(scene, "remove.below", 3.0);
  EXPECT_EQ(boxed.hash(), RunHere(scene).hash());
  EXPECT_EQ(SumOf(boxed.recording.Ints("departed")), 40);

  SetGroup(scene, "remove.below", Word("never"));
  SetGroup(scene, "remove.outside", Word("cube"));
  const Recorded cubed = RunHere(scene);
  SetGroup(scene, "remove.outside", Between(Vector3d(-10, -10, -10), Vector3d(10, 10, 10)));
  EXPECT_EQ(cubed.hash(), RunHere(scene).hash());
  EXPECT_GT(SumOf(cubed.recording.Ints("departed")), 20);
}

/// A ball of 1 m has room for one in a box of 1.5 m: the next comes when it has fallen out of it.
TEST(Population, ThoseWithoutAPlaceWait) {
  plan::Scene scene = EngineScene(10, 100);
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "cycles", std::uint64_t{300});
  SetWorld(scene, "record", schema::WordList{"counts", "poses"});
  SetGroup(scene, "size", 1.0);
  SetGroup(scene, "region", Between(Vector3d::Constant(-0.75), Vector3d::Constant(0.75)));
  SetGroup(scene, "spawn.batch", std::uint64_t{10});
  SeedStreams(scene);
  const Recorded run = RunHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  const auto spawned = run.recording.Ints("spawned"), waiting = run.recording.Ints("waiting");
  EXPECT_EQ(spawned[0], 1);
  EXPECT_EQ(waiting[0], 9);
  std::int32_t came = 0;
  for (std::size_t i = 0; i < 300; ++i) {
    came += spawned[i];
    EXPECT_LE(spawned[i], 1);
    EXPECT_EQ(waiting[i], 10 - came) << i;
  }
  EXPECT_EQ(came, 10);
  // In the order of their slots, and without a pose before.
  const auto poses = run.recording.Reals("poses");
  for (std::size_t i = 0, there = 0; i < 300; ++i) {
    there += static_cast<std::size_t>(spawned[i]);
    for (std::size_t object = 0; object < 10; ++object)
      EXPECT_EQ(std::isnan(poses[(i * 10 + object) * protocol::kPoseSize]), object >= there);
  }
}

// Bullet alone would leave it asleep in the air.
TEST(Population, WhatLayOnOneThatLeavesWakes) {
  plan::Scene scene = EngineScene(1, 20);
  SetWorld(scene, "world.walls", Word("floor"));
  SetWorld(scene, "cycles", std::uint64_t{500});
  SetWorld(scene, "record", schema::WordList{"counts", "stability"});
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", 1.0);
  SetGroup(scene, "location", schema::Call{"at", {Vector3d(0, -9.5, 0)}});
  SetGroup(scene, "remove.after", std::uint64_t{400});
  scene.groups.push_back(scene.groups[0]);
  scene.groups[1].name = "upper";
  SetGroup(scene, "location", schema::Call{"at", {Vector3d(0, -8.5, 0)}}, 1);
  SetGroup(scene, "remove.after", Word("never"), 1);
  SeedStreams(scene);
  const Recorded run = RunHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  EXPECT_EQ(run.recording.Ints("asleep")[399], 2);
  EXPECT_EQ(run.recording.Ints("asleep")[405], 0);
  EXPECT_NEAR(Position(*run.engine, 1).y(), -9.5, 0.03);
  EXPECT_EQ(run.recording.Ints("non_finite")[499], 0);
}

/// A bin of 12 m, kept full of balls of 1 m, with a square outlet in its floor. Returns the balls
/// that leave in a second.
double Discharge(double outlet) {
  plan::Scene scene = EngineScene(4000, 12);
  SetWorld(scene, "timestep", 1.0 / 120);
  SetWorld(scene, "detector", Word("auto"));
  SetWorld(scene, "pair_order", Word("sorted"));
  SetWorld(scene, "world.wall_restitution", 0.0);
  SetWorld(scene, "warmup", std::uint64_t{700});
  SetWorld(scene, "cycles", std::uint64_t{900});
  SetWorld(scene, "record", schema::WordList{"counts"});
  SetGroup(scene, "size", 1.0);
  SetGroup(scene, "linear_velocity", Vector3d(0, -2, 0));
  SetGroup(scene, "region", Between(Vector3d(-6, 2, -6), Vector3d(6, 6, 6)));
  SetGroup(scene, "spawn.batch", std::uint64_t{40});
  SetGroup(scene, "spawn.every", std::uint64_t{4});
  SetGroup(scene, "remove.below", -4.0);
  const double brim = (12 - outlet) / 2, middle = 6 - brim / 2;
  const auto add = [&](const char* name, const Vector3d& sides, const Vector3d& place) {
    scene.groups.push_back(EngineScene(2, 12).groups[0]);
    const std::size_t group = scene.groups.size() - 1;
    scene.groups[group].name = name;
    SetGroup(scene, "type", Word("cuboid"), group);
    SetGroup(scene, "size", sides.x(), group);
    SetGroup(scene, "aspect", schema::Ratio{sides / sides.x()}, group);
    SetGroup(scene, "mass", Word("fixed"), group);
    SetGroup(scene, "location", schema::Call{"at", {Vector3d(-place), place}}, group);
    SetGroup(scene, "overlap", true, group);
  };
  add("sides", {brim, 3, 12}, {middle, 0, 0});
  add("ends", {outlet - 0.02, 2.8, brim}, {0, 0, middle});
  SeedStreams(scene);
  const Recorded run = RunHere(scene);
  EXPECT_TRUE(run.done()) << run.message();
  EXPECT_GT(run.recording.Ints("waiting")[899], 0) << "the bin is not full";
  return static_cast<double>(SumOf(run.recording.Ints("departed"))) / 900 * 120;
}

// Beverloo: W = C n sqrt(g) (D - k d)^2.5. k is 1 to 1.6 grains for outlets of all kinds; C is 0.58
// for round ones, so about 0.74 for square ones of the same width, and n the grains in 1 m^3, here
// about 0.6 / (pi / 6).
TEST(Population, HopperFlowsByBeverloosLaw) {
  if (kAddressSanitizer || !kIsSingle) GTEST_SKIP() << "slow, and the same in double precision";
  const double narrow = Discharge(4), wide = Discharge(6);
  const double first = std::pow(narrow, 0.4), second = std::pow(wide, 0.4);
  const double slope = (second - first) / 2, k = 4 - first / slope;
  EXPECT_GT(k, 0.8);
  EXPECT_LT(k, 1.6);
  const double c = std::pow(slope, 2.5) / std::sqrt(9.8) / 1.146;
  EXPECT_GT(c, 0.5);
  EXPECT_LT(c, 0.9);
}

}  // namespace
}  // namespace cdb::tests
