// Verdicts of runs in Bullet: a fault is detected in the cycle in which it happens.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "runtime/engine/probes/probes.h"
#include "runtime/protocol/verdict.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using protocol::Judgement;
using protocol::Verdict;

constexpr std::uint64_t kCycles = 60;

/// Runs the scene; `before` is called before each step.
Judgement RunAndJudge(plan::Scene scene, layouts::InitialState state,
                      const std::function<void(world::Engine&, std::uint64_t)>& before = {}) {
  SetWorld(scene, "cycles", kCycles);
  protocol::Recording recording = protocol::Recording::Create(scene);
  world::Engine engine = WholeEngine(scene, std::move(state));
  probes::Probes probes(scene, engine, recording, -1);
  probes.Begin();
  for (std::uint64_t cycle = 0; cycle < kCycles; ++cycle) {
    if (before) before(engine, cycle);
    engine.Step();
    probes.Record(cycle);
  }
  return Judge(scene, recording, kCycles);
}

plan::Scene DriftingObject(double speed) {
  plan::Scene scene = EngineScene(1, 1000);
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(scene, "world.walls", Word("none"));
  SetGroup(scene, "linear_velocity", Vector3d(speed, 0, 0));
  return scene;
}

TEST(VerdictOfRun, ANumberThatIsNoneShowsInItsCycle) {
  for (const std::uint64_t k : {0u, 1u, 23u, 59u}) {
    const plan::Scene scene = EngineScene(20, 1000);
    const Judgement judgement = RunAndJudge(
        scene, layouts::MakeInitialState(scene), [&](auto& engine, std::uint64_t cycle) {
          if (cycle == k)
            engine.objects()[7]->setLinearVelocity(
                btVector3(std::numeric_limits<btScalar>::quiet_NaN(), 0, 0));
        });
    EXPECT_EQ(judgement.verdict, Verdict::kNonFinite) << protocol::VerdictName(judgement.verdict);
    EXPECT_EQ(judgement.first_bad_cycle, static_cast<std::int64_t>(k));
  }
}

TEST(VerdictOfRun, FreeFlightIsStable) {
  plan::Scene scene = EngineScene(20, 2000);
  SetGroup(scene, "linear_velocity", Normal(0.0, 30.0));
  SetGroup(scene, "angular_velocity", Normal(0.0, 3.0));
  SetGroup(scene, "linear_damping", 0.3);
  const Judgement judgement = RunAndJudge(scene, layouts::MakeInitialState(scene));
  EXPECT_EQ(judgement.verdict, Verdict::kStable) << protocol::VerdictName(judgement.verdict);
}

TEST(VerdictOfRun, FarAwayBodiesAreFrozen) {
  // |v| dt is 1/60; adjacent numbers are 1 apart at 2^24 in single precision, at 2^53 in double.
  // Bullet deactivates bodies beyond 1e6, where double precision still moves them.
  const plan::Scene scene = DriftingObject(1);
  for (const auto& [place, verdict] :
       {std::pair{1e4, Verdict::kStable},
        std::pair{9e5, kIsSingle ? Verdict::kFrozen : Verdict::kStable}}) {
    const Judgement judgement = RunAndJudge(scene, OneObjectAt(scene, Vector3d(place, 0, 0)));
    EXPECT_EQ(judgement.verdict, verdict)
        << place << ' ' << protocol::VerdictName(judgement.verdict);
  }
}

TEST(VerdictOfRun, ABoxThatGrowsTooLargeIsRemoved) {
  plan::Scene scene = DriftingObject(1);
  const Judgement judgement = RunAndJudge(
      scene, OneObjectAt(scene, Vector3d(0, 0, 0)), [](auto& engine, std::uint64_t cycle) {
        if (cycle == 31) engine.objects()[0]->setLinearVelocity(btVector3(btScalar(1e8), 0, 0));
      });
  EXPECT_EQ(judgement.verdict, Verdict::kRemoved) << protocol::VerdictName(judgement.verdict);
  EXPECT_GE(judgement.first_bad_cycle, 31);
  EXPECT_LE(judgement.first_bad_cycle, 32);
}

TEST(VerdictOfRun, FastSpinIsClamped) {
  // 2 atan(0.527 w dt) against w dt: ten per cent low at 1.41.
  for (const auto& [turn, verdict] :
       {std::pair{1.35, Verdict::kStable}, std::pair{1.47, Verdict::kClamped}}) {
    plan::Scene scene = DriftingObject(0);
    SetGroup(scene, "angular_velocity", Vector3d(0, 60 * turn, 0));
    const Judgement judgement = RunAndJudge(scene, OneObjectAt(scene, Vector3d(0, 0, 0)));
    EXPECT_EQ(judgement.verdict, verdict)
        << turn << ' ' << protocol::VerdictName(judgement.verdict);
  }
}

TEST(VerdictOfRun, EnergyFromNowhereExplodes) {
  plan::Scene scene = DriftingObject(10);
  const Judgement judgement = RunAndJudge(
      scene, OneObjectAt(scene, Vector3d(0, 0, 0)), [](auto& engine, std::uint64_t cycle) {
        if (cycle == 12) engine.objects()[0]->setLinearVelocity(btVector3(20, 0, 0));
      });
  EXPECT_EQ(judgement.verdict, Verdict::kExploded) << protocol::VerdictName(judgement.verdict);
  EXPECT_EQ(judgement.first_bad_cycle, 12);
}

TEST(VerdictOfRun, AThinWallIsNoWallForTheFast) {
  for (const auto& [speed, verdict] :
       {std::pair{1e3, Verdict::kStable}, std::pair{1e5, Verdict::kTunnelled}}) {
    plan::Scene scene = DriftingObject(speed);
    SetWorld(scene, "world.walls", Word("all"));
    SetWorld(scene, "world.wall_shape", Word("box"));
    const Judgement judgement = RunAndJudge(scene, OneObjectAt(scene, Vector3d(0, 0, 0)));
    EXPECT_EQ(judgement.verdict, verdict)
        << speed << ' ' << protocol::VerdictName(judgement.verdict);
  }
}

TEST(VerdictOfRun, AStackStandsOrCollapses) {
  for (const auto& [heavy, is_stable] : {std::pair{1.0, true}, std::pair{1e5, false}}) {
    plan::Scene scene = EngineScene(8, 2000);
    SetWorld(scene, "expect", Word("rest"));
    SetGroup(scene, "type", Word("cuboid"));
    SetGroup(scene, "location", Layout("stack"));
    layouts::InitialState state = layouts::MakeInitialState(scene);
    state.objects.back().mass = heavy;
    const Judgement judgement = RunAndJudge(scene, std::move(state));
    EXPECT_EQ(judgement.verdict == Verdict::kStable, is_stable)
        << protocol::VerdictName(judgement.verdict);
  }
}

}  // namespace
}  // namespace cdb::tests
