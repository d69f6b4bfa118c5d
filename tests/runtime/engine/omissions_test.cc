// Omissions change no motion: scenes at the limit of each proof, and the omission guard, which
// detects a wrong proof.
#include <gtest/gtest.h>

#include "library/scene_error.h"
#include "tests/runtime/engine/paired_run.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using schema::Component;
using schema::WordList;

/// Balls of 50 m at rest, without gravity, in a cube of 2000 m; the recording permits omitting
/// detection.
plan::Scene Balls(std::uint64_t quantity) {
  plan::Scene scene = EngineScene(quantity, 2000);
  SetWorld(scene, "cycles", std::uint64_t{60});
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(scene, "record", WordList{"energy"});
  return scene;
}

struct Ball {
  Vector3d position, velocity = Vector3d::Zero();
};

layouts::InitialState WithBalls(const plan::Scene& scene, const std::vector<Ball>& balls) {
  layouts::InitialState state = layouts::DrawObjects(scene);
  for (std::size_t i = 0; i < balls.size(); ++i) {
    state.objects.at(i).pose.position = balls[i].position;
    state.objects.at(i).linear_velocity = balls[i].velocity;
  }
  return state;
}

/// A ball that moves towards the wall, so fast that its surface is `short_of` m from it in the last
/// step that detection sees.
layouts::InitialState TowardsWall(const plan::Scene& scene, int wall, double short_of) {
  const double sign = wall % 2 == 0 ? -1 : 1;
  const double steps = static_cast<double>(scene.world.Count("cycles")) - 1;
  const double speed = (1000 - 25 - short_of) / (steps * scene.world.Real("timestep"));
  return WithBalls(scene, {{Vector3d::Zero(), sign * speed * Vector3d::Unit(wall / 2)}});
}

TEST(OmitWalls, ReachedInTheLastCycleOrJustNot) {
  const plan::Scene scene = Balls(1);
  for (int wall = 0; wall < omissions::kWallCount; ++wall) {
    SCOPED_TRACE(wall);
    // It overlaps the wall in the last detection: the wall is kept, and changes the motion.
    const PairedRun hit = RunPaired(scene, TowardsWall(scene, wall, -1));
    EXPECT_EQ(hit.omissions.walls.at(0), 1 << wall);
    EXPECT_FALSE(hit.tripped);
    EXPECT_FALSE(hit.Omits(Component::kSolver));
    // Within the distance at which Bullet makes a contact.
    const PairedRun near = RunPaired(scene, TowardsWall(scene, wall, 0.1));
    EXPECT_EQ(near.omissions.walls.at(0), 1 << wall);
    // Far from it: nothing touches, everything is omitted.
    const PairedRun miss = RunPaired(scene, TowardsWall(scene, wall, 40));
    EXPECT_EQ(miss.omissions.walls.at(0), 0);
    EXPECT_TRUE(miss.Omits(Component::kSolver)) << miss.why(Component::kSolver);
    EXPECT_TRUE(miss.Omits(Component::kDetection)) << miss.why(Component::kDetection);
    EXPECT_TRUE(miss.Omits(Component::kRotation)) << miss.why(Component::kRotation);
  }
}

TEST(OmitWalls, AVelocityThatGravityTurns) {
  plan::Scene scene = Balls(1);
  SetWorld(scene, "acceleration", Vector3d(0, -100, 0));
  SetWorld(scene, "cycles", std::uint64_t{400});
  // Thrown up, it turns at v^2 / 2g.
  const auto thrown = [&](double height) {
    return RunPaired(scene, WithBalls(scene, {{{0, -900, 0}, {0, std::sqrt(200 * height), 0}}}));
  };
  EXPECT_EQ(thrown(1860).omissions.walls.at(0) & 1 << 3, 0);  // 15 m short of the ceiling
  EXPECT_NE(thrown(1880).omissions.walls.at(0) & 1 << 3, 0);
}

TEST(OmitSolver, ASpinThatBeginsByACollision) {
  plan::Scene scene = Balls(2);
  SetGroup(scene, "restitution", 1.0);
  // A glancing collision in the fourth cycle from the end, and a similar one that misses.
  const auto passing = [&](double offset) {
    return RunPaired(scene, WithBalls(scene, {{{0, 0, 0}}, {{-500, offset, 0}, {480, 0, 0}}}));
  };
  const PairedRun hit = passing(40);
  EXPECT_FALSE(hit.Omits(Component::kSolver));
  EXPECT_FALSE(hit.Omits(Component::kRotation)) << hit.why(Component::kRotation);
  EXPECT_TRUE(hit.Omits(Component::kWalls)) << hit.why(Component::kWalls);
  EXPECT_FALSE(hit.tripped);
  const PairedRun miss = passing(60);
  EXPECT_TRUE(miss.Omits(Component::kSolver)) << miss.why(Component::kSolver);
  EXPECT_TRUE(miss.Omits(Component::kRotation));
}

TEST(OmitWalls, WhatACollisionSendsThere) {
  plan::Scene scene = Balls(3);
  SetWorld(scene, "cycles", std::uint64_t{300});
  SetGroup(scene, "restitution", 1.0);
  // The first hits the second obliquely, and neither would reach a wall along y without that.
  const PairedRun paired = RunPaired(
      scene, WithBalls(scene, {{{-300, 30, 0}, {300, 0, 0}}, {{0, 0, 0}}, {{0, 0, 900}}}));
  EXPECT_NE(paired.omissions.walls.at(0) & 1 << 3, 0);
  EXPECT_NE(paired.omissions.walls.at(1) & 1 << 2, 0);
  EXPECT_FALSE(paired.tripped) << *paired.tripped;
}

TEST(OmitRotation, TheSameBitsForeverOrNotAtAll) {
  for (const char* type : {"sphere", "cuboid", "cylinder", "cone"}) {
    for (const Vector3d& turn : {Vector3d(0, 0, 0), Vector3d(0.3, 1, -2), Vector3d(1e-3, 0, 0)}) {
      plan::Scene scene = Balls(1);
      SetGroup(scene, "type", Word(type));
      SetGroup(scene, "orientation", turn);
      SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
      const PairedRun paired = RunPaired(scene, WithBalls(scene, {{{0, 0, 0}, {3, 0, 1}}}));
      EXPECT_TRUE(paired.Omits(Component::kSolver));
      if (turn.isZero()) {
        EXPECT_TRUE(paired.Omits(Component::kRotation)) << paired.why(Component::kRotation);
      }
    }
  }
}

TEST(OmitSleeping, OnlyWhereNothingComesToRest) {
  plan::Scene scene = Balls(1);
  SetWorld(scene, "cycles", std::uint64_t{400});
  const auto moving = [&](double speed) {
    return RunPaired(scene, WithBalls(scene, {{{0, 0, 0}, {speed, 0, 0}}}));
  };
  EXPECT_FALSE(moving(0.5).Omits(Component::kSleeping));
  EXPECT_FALSE(moving(0.5).Omits(Component::kSolver));
  EXPECT_TRUE(moving(0.5).Omits(Component::kWalls));
  EXPECT_TRUE(moving(1.0).Omits(Component::kSleeping)) << moving(1.0).why(Component::kSleeping);
  // With damping it comes to rest in the end.
  SetGroup(scene, "linear_damping", 0.9);
  EXPECT_FALSE(moving(5).Omits(Component::kSleeping));
  SetGroup(scene, "linear_damping", 0.0);
  // Thrown upwards, it is slow only for a moment.
  SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
  EXPECT_TRUE(
      RunPaired(scene, WithBalls(scene, {{{0, 0, 0}, {0, 9, 0}}})).Omits(Component::kSleeping));
  SetWorld(scene, "acceleration", Vector3d(0, -0.1, 0));
  EXPECT_FALSE(
      RunPaired(scene, WithBalls(scene, {{{0, 0, 0}, {0, 0.4, 0}}})).Omits(Component::kSleeping));
}

TEST(OmitDetection, ANeighbourKeepsASlowOneAwake) {
  // Their boxes overlap for the whole run, so the fast one keeps the slow one from sleep.
  plan::Scene scene = Balls(2);
  SetWorld(scene, "cycles", std::uint64_t{400});
  const PairedRun paired =
      RunPaired(scene, WithBalls(scene, {{{0, 0, 0}, {0.5, 0, 0}}, {{-20, 48, 0}, {4, 0, 0}}}));
  EXPECT_FALSE(paired.Omits(Component::kDetection));
}

TEST(OmitRaycastTree, NotWhereObjectsLookAhead) {
  for (const char* detector : {"sap", "sap32"}) {
    plan::Scene scene = EngineScene(30, 400);
    SetWorld(scene, "cycles", std::uint64_t{100});
    SetWorld(scene, "detector", Word(detector));
    SetGroup(scene, "linear_velocity", Normal(0.0, 2000.0));
    EXPECT_TRUE(RunPaired(scene).Omits(Component::kRaycastTree));
    SetGroup(scene, "ccd", true);
    const PairedRun swept = RunPaired(scene);
    EXPECT_FALSE(swept.Omits(Component::kRaycastTree));
    EXPECT_FALSE(swept.Omits(Component::kSweptContacts));
    EXPECT_FALSE(swept.Omits(Component::kWalls));
  }
}

TEST(OmitDamping, EitherKindKeepsIt) {
  plan::Scene scene = EngineScene(20, 400);
  SetWorld(scene, "cycles", std::uint64_t{100});
  SetGroup(scene, "linear_velocity", Normal(0.0, 50.0));
  EXPECT_TRUE(RunPaired(scene).Omits(Component::kDamping));
  SetGroup(scene, "angular_damping", Uniform(0.0, 0.5));
  EXPECT_FALSE(RunPaired(scene).Omits(Component::kDamping));
  SetGroup(scene, "angular_damping", 0.0);
  SetGroup(scene, "linear_damping", 0.1);
  EXPECT_FALSE(RunPaired(scene).Omits(Component::kDamping));
}

// ---- the omission guard -------------------------------------------------------------------------

/// Omissions as if the proof had shown that no object can reach any wall.
omissions::Omissions WrongAboutWalls(const plan::Scene& scene) {
  omissions::Omissions omissions = omissions::KeepEverything(scene);
  omissions.decisions[static_cast<std::size_t>(Component::kWalls)].decision =
      analysis::Decision::kLeftOut;
  omissions.walls.assign(scene.ObjectCount(), 0);
  return omissions;
}

TEST(OmissionGuard, SeesAnObjectAtAWallThatIsNotThereBeforeBulletWould) {
  const plan::Scene scene = Balls(1);
  for (int wall = 0; wall < omissions::kWallCount; ++wall) {
    const PairedRun paired = RunPaired(scene, TowardsWall(scene, wall, -1), WrongAboutWalls(scene));
    ASSERT_TRUE(paired.tripped);
    EXPECT_NE(paired.tripped->find("object 1 came close to the wall"), std::string::npos);
    EXPECT_GE(paired.tripped_in, 58u);
    EXPECT_FALSE(RunPaired(scene, TowardsWall(scene, wall, 5), WrongAboutWalls(scene)).tripped);
  }
}

TEST(OmissionGuard, SeesAnObjectThatTouchesTwo) {
  plan::Scene scene = Balls(2);
  SetWorld(scene, "cycles", std::uint64_t{200});
  SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
  // One lies on the floor, another falls onto it.
  const auto state = WithBalls(scene, {{{0, -975, 0}}, {{1, -915, 0}}});
  const PairedRun paired = RunPaired(scene, state);
  ASSERT_TRUE(paired.tripped);
  EXPECT_NE(paired.tripped->find("object 1 was in two contacts at once"), std::string::npos);
  EXPECT_EQ(paired.why(Component::kWalls), *paired.tripped);
}

TEST(OmissionGuard, SeesASleeperThatHadANeighbour) {
  plan::Scene scene = Balls(2);
  SetWorld(scene, "cycles", std::uint64_t{200});
  SetWorld(scene, "detector", Word("dbvt"));
  // Their boxes overlap, but the balls do not.
  const auto state = WithBalls(scene, {{{0, 0, 0}}, {{40, 40, 0}}});
  const PairedRun paired = RunPaired(scene, state);
  ASSERT_TRUE(paired.tripped);
  EXPECT_NE(paired.tripped->find("came to rest after it had been near another"), std::string::npos);
  // Sweep and prune drops pairs immediately, regardless of other pairs.
  SetWorld(scene, "detector", Word("sap32"));
  EXPECT_FALSE(RunPaired(scene, state).tripped);
}

TEST(Omit, AListThatAsksTooMuchEndsTheRunWithAMessage) {
  plan::Scene scene = EngineScene(10, 500);
  SetWorld(scene, "cycles", std::uint64_t{400});
  SetWorld(scene, "omit", WordList{"solver"});
  const Recorded solver = RunHere(scene);
  EXPECT_FALSE(solver.done());
  EXPECT_NE(solver.message().find("omit solver: this scene needs it"), std::string::npos);
  SetWorld(scene, "omit", WordList{"damping", "pools"});
  const Recorded silent = RunHere(scene);
  EXPECT_TRUE(silent.done()) << silent.message();
  EXPECT_EQ(silent.header().omitted.str(), "damping pools");
}

TEST(Omit, TheRecordSaysWhatBecameOfEachComponent) {
  plan::Scene scene = EngineScene(10, 5000);
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  for (const char* omit : {"none", "auto"}) {
    SetWorld(scene, "omit", WordList{omit});
    const Recorded run = RunHere(scene);
    ASSERT_TRUE(run.done()) << run.message();
    const std::string decisions = run.header().decisions.str();
    for (const schema::ComponentInfo& info : schema::Components())
      EXPECT_NE(decisions.find(std::string(info.name) + ": "), std::string::npos) << decisions;
    EXPECT_EQ(run.header().omitted.str().empty(), std::string_view(omit) == "none");
  }
}

TEST(Omit, AutoDetectsWhereARecordAsks) {
  plan::Scene scene = Balls(2);
  const auto state = WithBalls(scene, {{{0, 0, 0}}, {{500, 0, 0}}});
  for (const char* what : {"timing", "counts", "contacts", "pairs"}) {
    SetWorld(scene, "record", WordList{what});
    EXPECT_FALSE(omissions::DecideOmissions(scene, state).Omits(Component::kDetection)) << what;
  }
  SetWorld(scene, "record", WordList{"poses"});
  EXPECT_TRUE(omissions::DecideOmissions(scene, state).Omits(Component::kDetection));
  // If it is listed by name, it is omitted anyway.
  SetWorld(scene, "record", WordList{"timing"});
  SetWorld(scene, "omit", WordList{"detection"});
  EXPECT_TRUE(RunPaired(scene, state).Omits(Component::kDetection));
}

}  // namespace
}  // namespace cdb::tests
