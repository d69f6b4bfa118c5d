// Verdicts of hand-made series: each criterion just below and just above its threshold.
#include "runtime/protocol/verdict.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "compiler/analysis/expectation.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

using analysis::Expectation;
using protocol::Judgement;
using protocol::Recording;
using protocol::Verdict;

constexpr std::uint64_t kCycles = 40;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A run of 40 cycles without faults; energy 100 J on a scale of 200 J.
class VerdictTest : public testing::Test {
 protected:
  VerdictTest() : scene_(DefaultScene(3, 500)), recording_(Make(scene_)) { SetUpQuiet(); }

  static Recording Make(plan::Scene& scene) {
    SetWorld(scene, "cycles", kCycles);
    return Recording::Create(scene);
  }
  void SetUpQuiet() {
    recording_.header().scales.initial_energy = 100;
    recording_.header().scales.energy_scale = 200;
    recording_.header().scales.speed_scale = 10;
    recording_.header().scales.least_side = 2;
    recording_.header().scales.moving_objects = 3;
    for (const schema::IntSeries count : std::initializer_list<schema::IntSeries>{
             "non_finite", "removed", "escaped", "contacts", "passed", "pressed", "inverted",
             "unheld", "frozen", "displaced"})
      std::ranges::fill(recording_.Ints(count), 0);
    for (const schema::RealSeries series : std::initializer_list<schema::RealSeries>{
             "displacement", "penetration_ratio", "max_speed"})
      std::ranges::fill(recording_.Reals(series), 0);
    std::ranges::fill(recording_.Reals("energy"), 100);
  }
  void Set(schema::RealSeries series, std::size_t from, double value, std::size_t to = kCycles) {
    std::fill(recording_.Reals(series).begin() + static_cast<std::ptrdiff_t>(from),
              recording_.Reals(series).begin() + static_cast<std::ptrdiff_t>(to), value);
  }
  void SetCount(schema::IntSeries series, std::size_t from, int value, std::size_t to = kCycles) {
    std::fill(recording_.Ints(series).begin() + static_cast<std::ptrdiff_t>(from),
              recording_.Ints(series).begin() + static_cast<std::ptrdiff_t>(to), value);
  }
  void Expect(const char* what) { SetWorld(scene_, "expect", Word(what)); }
  Judgement Judged() const { return Judge(scene_, recording_, kCycles); }
  void ExpectVerdict(Verdict verdict, std::int64_t first) const {
    const Judgement judgement = Judged();
    EXPECT_EQ(judgement.verdict, verdict) << protocol::VerdictName(judgement.verdict);
    EXPECT_EQ(judgement.first_bad_cycle, first);
  }

  plan::Scene scene_;
  Recording recording_;
};

TEST_F(VerdictTest, NothingHappened) { ExpectVerdict(Verdict::kStable, -1); }

TEST_F(VerdictTest, IsUnknownWithoutTheSeries) {
  SetWorld(scene_, "record", schema::WordList{"timing"});
  ExpectVerdict(Verdict::kUnknown, -1);
}

TEST_F(VerdictTest, TheProcessComesFirst) {
  SetCount("non_finite", 3, 1);
  const Judgement crashed = Judge(scene_, recording_, 17, Verdict::kCrashed);
  EXPECT_EQ(crashed.verdict, Verdict::kCrashed);
  EXPECT_EQ(crashed.first_bad_cycle, 17);
}

TEST_F(VerdictTest, NonFinite) {
  SetCount("non_finite", 7, 2);
  Set("energy", 7, kNaN);
  ExpectVerdict(Verdict::kNonFinite, 7);
}

TEST_F(VerdictTest, Removed) {
  SetCount("removed", 9, 1);
  SetCount("frozen", 9, 3);
  ExpectVerdict(Verdict::kRemoved, 9);
}

TEST_F(VerdictTest, FrozenFromAHundredthOfTheObjectsOn) {
  recording_.header().scales.moving_objects = 500;
  SetCount("frozen", 5, 4);
  ExpectVerdict(Verdict::kClamped, 5);
  SetCount("frozen", 8, 5);
  ExpectVerdict(Verdict::kFrozen, 8);
  recording_.header().scales.moving_objects = 1;
  SetCount("frozen", 5, 0);
  SetCount("frozen", 8, 1);
  ExpectVerdict(Verdict::kFrozen, 8);
  // Frozen bodies appear to gain energy.
  Set("energy", 6, 1e9);
  ExpectVerdict(Verdict::kFrozen, 8);
}

TEST_F(VerdictTest, ExplodedAndDriftingByRise) {
  Set("energy", 10, 60);                  // lost to friction
  ExpectVerdict(Verdict::kDrifting, 10);  // nothing has touched before
  SetCount("contacts", 10, 1);
  ExpectVerdict(Verdict::kStable, -1);
  Set("energy", 20, 61.9);
  ExpectVerdict(Verdict::kStable, -1);
  Set("energy", 21, 62.1);
  ExpectVerdict(Verdict::kDrifting, 21);
  Set("energy", 30, 261);
  ExpectVerdict(Verdict::kExploded, 30);
}

TEST_F(VerdictTest, AFallGivesEnergiesAScaleAndAGainDoesNot) {
  SetCount("contacts", 0, 4);
  Set("kinetic_energy", 5, 1000);
  Set("energy", 20, 109);
  ExpectVerdict(Verdict::kStable, -1);
  Set("energy", 20, 111);
  ExpectVerdict(Verdict::kDrifting, 20);
  Set("energy", 0, 100);
  Set("kinetic_energy", 0, 0);
  Set("energy", 20, 1100);
  Set("kinetic_energy", 20, 1000);
  ExpectVerdict(Verdict::kExploded, 20);
}

TEST_F(VerdictTest, AFreeSpinMayLoseThreeInAHundred) {
  Set("energy", 15, 94.1);
  ExpectVerdict(Verdict::kStable, -1);
  Set("energy", 15, 93.9);
  ExpectVerdict(Verdict::kDrifting, 15);
  SetCount("contacts", 15, 1);
  ExpectVerdict(Verdict::kStable, -1);
}

TEST_F(VerdictTest, EnergyIsKeptWhereItMustBe) {
  SetCount("contacts", 0, 4);
  Set("energy", 15, 97.9);
  ExpectVerdict(Verdict::kStable, -1);
  Expect("energy");
  ExpectVerdict(Verdict::kDrifting, 15);
}

TEST_F(VerdictTest, ASceneThatIsDrivenHasNoEnergyVerdict) {
  SetWorld(scene_, "acceleration",
           schema::Call{"every", {std::uint64_t{5}, Eigen::Vector3d(1, 0, 0)}});
  Set("energy", 10, 1e9);
  ExpectVerdict(Verdict::kStable, -1);
}

TEST_F(VerdictTest, TunnelledAtTheEndOnly) {
  SetCount("escaped", 4, 1, 10);
  ExpectVerdict(Verdict::kStable, -1);
  SetCount("escaped", 33, 2);
  ExpectVerdict(Verdict::kTunnelled, 33);
}

TEST_F(VerdictTest, Clamped) {
  Set("turn_ratio", 2, 0.91);
  ExpectVerdict(Verdict::kStable, -1);
  Set("turn_ratio", 3, 0.89, 4);
  ExpectVerdict(Verdict::kClamped, 3);
}

TEST_F(VerdictTest, WhatMustRestMayNotMove) {
  SetCount("displaced", 11, 1);
  ExpectVerdict(Verdict::kStable, -1);
  Expect("rest");
  ExpectVerdict(Verdict::kCollapsed, 11);
}

TEST_F(VerdictTest, AFewOfHundredsThatMoveAreNoCollapse) {
  recording_.header().scales.moving_objects = 400;
  Expect("rest");
  SetCount("displaced", 11, 3);
  ExpectVerdict(Verdict::kDrifting, 11);
  SetCount("displaced", 20, 4);
  ExpectVerdict(Verdict::kCollapsed, 20);
}

TEST_F(VerdictTest, PenetrationLateOrAtRest) {
  Set("penetration_ratio", 5, 0.3, 29);
  ExpectVerdict(Verdict::kStable, -1);
  Expect("rest");
  ExpectVerdict(Verdict::kPenetrating, 5);
  Expect("anything");
  Set("penetration_ratio", 33, 0.06);
  ExpectVerdict(Verdict::kPenetrating, 33);
}

TEST_F(VerdictTest, JointsThatOpenLate) {
  Set("joint_gap", 0, 0.3, 29);
  Set("joint_gap", 29, 0.09);
  ExpectVerdict(Verdict::kStable, -1);
  Set("joint_gap", 32, 0.11);
  ExpectVerdict(Verdict::kPenetrating, 32);
}

TEST_F(VerdictTest, JointsThatBendOrStretch) {
  Set("joint_bend", 0, 0.06, 29);
  Set("joint_stretch", 29, 0.019);
  ExpectVerdict(Verdict::kStable, -1);
  Set("joint_bend", 32, 0.06);
  ExpectVerdict(Verdict::kPenetrating, 32);
  Set("joint_bend", 0, 0);
  Set("joint_stretch", 31, 0.021);
  ExpectVerdict(Verdict::kPenetrating, 31);
}

TEST_F(VerdictTest, MotorsThatMissLate) {
  Set("motor_error", 0, 0.5, 29);
  Set("motor_error", 29, 0.09);
  ExpectVerdict(Verdict::kStable, -1);
  Set("motor_error", 32, 0.11);
  ExpectVerdict(Verdict::kDrifting, 32);
  Set("motor_error", 32, kNaN);
  ExpectVerdict(Verdict::kStable, -1);
}

TEST_F(VerdictTest, SpeedLateAtRest) {
  Set("max_speed", 0, 0.21);
  ExpectVerdict(Verdict::kStable, -1);
  Expect("rest");
  ExpectVerdict(Verdict::kDrifting, 30);
  Set("max_speed", 30, 0.19);
  ExpectVerdict(Verdict::kStable, -1);
}

TEST_F(VerdictTest, TunnelledThroughAnotherObjectAtAnyTime) {
  SetCount("passed", 6, 1, 7);
  ExpectVerdict(Verdict::kTunnelled, 6);
  SetCount("escaped", 4, 1);
  ExpectVerdict(Verdict::kTunnelled, 4);
}

TEST_F(VerdictTest, PressedAtAnyTime) {
  SetCount("pressed", 8, 2, 9);
  ExpectVerdict(Verdict::kPenetrating, 8);
}

TEST_F(VerdictTest, InvertedAtTheEndOnly) {
  SetCount("inverted", 8, 1, 39);
  ExpectVerdict(Verdict::kStable, -1);
  SetCount("inverted", 37, 1);
  ExpectVerdict(Verdict::kCollapsed, 8);
}

TEST_F(VerdictTest, AsleepWhereNothingHolds) {
  SetCount("unheld", 14, 1, 20);
  ExpectVerdict(Verdict::kCollapsed, 14);
}

TEST_F(VerdictTest, EnergyThatNothingTook) {
  SetCount("contacts", 0, 1);
  Set("lost_energy", 3, 0.09);
  ExpectVerdict(Verdict::kStable, -1);
  Set("lost_energy", 5, 0.11);
  ExpectVerdict(Verdict::kDrifting, 5);
}

TEST_F(VerdictTest, EnergyThatNothingGave) {
  SetCount("contacts", 0, 1);
  Set("gained_energy", 3, 0.09);
  ExpectVerdict(Verdict::kStable, -1);
  Set("gained_energy", 5, 0.11);
  ExpectVerdict(Verdict::kDrifting, 5);
}

TEST_F(VerdictTest, EnergyOfFreeSpin) {
  Set("spin_ratio", 3, 0.971);
  Set("spin_ratio", 9, 1.029);
  ExpectVerdict(Verdict::kStable, -1);
  Set("spin_ratio", 16, 0.969);
  ExpectVerdict(Verdict::kDrifting, 16);
}

TEST_F(VerdictTest, LooksAtCyclesThatRanOnly) {
  SetCount("removed", 30, 1);
  EXPECT_EQ(Judge(scene_, recording_, 30).verdict, Verdict::kStable);
  EXPECT_EQ(Judge(scene_, recording_, 0).verdict, Verdict::kStable);
}

TEST(Verdicts, HaveNamesOfTheirOwnInTheOrderOfTheirNumbers) {
  std::set<std::string_view> names;
  for (const protocol::VerdictInfo& info : protocol::Verdicts()) {
    EXPECT_EQ(protocol::VerdictName(info.verdict), info.name);
    EXPECT_TRUE(names.insert(info.name).second);
    EXPECT_EQ(info.name.find(' '), std::string_view::npos);
  }
  EXPECT_TRUE(protocol::HasVoidTimings(Verdict::kFrozen));
  EXPECT_FALSE(protocol::HasVoidTimings(Verdict::kExploded));
}

TEST_F(VerdictTest, CountsTheObjectsThatItConcerns) {
  SetCount("passed", 5, 2, 7);
  SetCount("passed", 9, 1, 10);
  EXPECT_EQ(Judged().verdict, Verdict::kTunnelled);
  EXPECT_EQ(Judged().bad_objects, 2);
  // A worse verdict has a count of its own.
  SetCount("frozen", 12, 3);
  EXPECT_EQ(Judged().bad_objects, 3);
}

TEST_F(VerdictTest, OnTheSceneAsAWholeConcernsNoObject) {
  EXPECT_EQ(Judged().bad_objects, -1);
  Set("energy", 5, 150);
  EXPECT_EQ(Judged().verdict, Verdict::kDrifting);
  EXPECT_EQ(Judged().bad_objects, -1);
}

TEST(ExpectationOf, FollowsFromTheScene) {
  plan::Scene scene = DefaultScene(3, 500);
  EXPECT_EQ(analysis::ExpectationOf(scene), Expectation::kAnything);
  SetGroup(scene, "location", Layout("stack"));
  EXPECT_EQ(analysis::ExpectationOf(scene), Expectation::kRest);
  SetGroup(scene, "angular_velocity", Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(analysis::ExpectationOf(scene), Expectation::kAnything);
  SetGroup(scene, "restitution", 1.0);
  SetGroup(scene, "friction", 0.0);
  EXPECT_EQ(analysis::ExpectationOf(scene), Expectation::kEnergy);
  SetGroup(scene, "linear_damping", 0.1);
  EXPECT_EQ(analysis::ExpectationOf(scene), Expectation::kAnything);
  EXPECT_FALSE(analysis::FliesFreely(scene));
  SetWorld(scene, "expect", Word("rest"));
  EXPECT_EQ(analysis::ExpectationOf(scene), Expectation::kRest);
  SetGroup(scene, "linear_velocity",
           schema::Call{"every", {std::uint64_t{5}, Eigen::Vector3d(1, 0, 0)}});
  EXPECT_EQ(analysis::ExpectationOf(scene), Expectation::kDriven);
}

}  // namespace
}  // namespace cdb::tests
