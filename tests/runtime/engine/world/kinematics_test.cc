// Kinematic objects, which move regardless of collisions.
#include "runtime/engine/world/engine.h"

#include <gtest/gtest.h>

#include <numbers>

#include "compiler/analysis/expectation.h"
#include "compiler/plan/input_file.h"
#include "runtime/engine/probes/state_hash.h"
#include "runtime/protocol/verdict.h"
#include "tests/library/layouts/layout_scene.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/detector_names.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

/// One object of 1 m at rest, and the kinematic group `mover`, at these positions in a cube of 40
/// m.
plan::Scene MoverScene(const Vector3d& object, const Vector3d& mover) {
  plan::Scene scene = LayoutScene(1, 40, Points({object}));
  SetWorld(scene, "precision", Word(world::EnginePrecision()));
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "cycles", std::uint64_t{120});
  const std::size_t group = AddGroup(scene, "mover", 1, Points({mover}));
  SetGroup(scene, "type", Word("cuboid"), group);
  SetGroup(scene, "mass", Word("kinematic"), group);
  return scene;
}

/// Steps as RunScene does, and calls `look` after each step.
template <typename Look>
void RunMoved(const plan::Scene& scene, std::uint64_t steps, const Look& look) {
  world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  const world::Kinematics kinematics(scene, engine);
  for (std::uint64_t step = 0; step < steps; ++step) {
    kinematics.BeforeStep(step);
    engine.Step();
    kinematics.AfterStep(step);
    look(step, engine);
  }
}

TEST(Kinematics, FollowTheirVelocitiesWithoutDrift) {
  plan::Scene scene = MoverScene({15, 15, 15}, {0, 0, 0});
  const Vector3d velocity(0.3, -0.1, 0.7), spin(0, 3, 0);
  SetGroup(scene, "linear_velocity", velocity, 1);
  SetGroup(scene, "angular_velocity", spin, 1);
  RunMoved(scene, 600, [&](std::uint64_t step, const world::Engine& engine) {
    const double time = static_cast<double>(step + 1) / 60;
    EXPECT_LE((Position(engine, 1) - time * velocity).norm(), 10 * kEpsilon);
    EXPECT_LE((Velocity(engine, 1) - velocity).norm(), 1e-12 + kEpsilon);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(time * 3, Vector3d::UnitY()));
    EXPECT_LE(Orientation(engine, 1).angularDistance(turn), 1e-7 + 2000 * kEpsilon);
    EXPECT_EQ(engine.objects()[1]->getActivationState(), DISABLE_DEACTIVATION);
  });
}

/// An object on a lift rises with it and stays in touch: contacts are computed from poses of the
/// same time.
TEST(Kinematics, CarryWhatLiesOnThem) {
  plan::Scene scene = MoverScene({0, 1.01, 0}, {0, 0, 0});
  SetGroup(scene, "aspect", schema::Ratio{Vector3d(4, 1, 4)}, 1);
  SetGroup(scene, "linear_velocity", Vector3d(0, 2, 0), 1);
  double gap = 0, speed = 0;
  RunMoved(scene, 240, [&](std::uint64_t, const world::Engine& engine) {
    gap = Position(engine, 0).y() - Position(engine, 1).y() - 1;
    speed = Velocity(engine, 0).y();
    EXPECT_NE(engine.objects()[0]->getActivationState(), ISLAND_SLEEPING);
  });
  EXPECT_NEAR(speed, 2, 1e-3);
  EXPECT_NEAR(gap, 0, 0.01) << "a step of the lift is 2/60";
}

TEST(Kinematics, DragAsAConveyorDoes) {
  plan::Scene scene = MoverScene({0, 1.001, 0}, {0, 0, 0});
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "aspect", schema::Ratio{Vector3d(30, 1, 4)}, 1);
  SetGroup(scene, "linear_velocity", Vector3d(1.5, 0, 0), 1);
  RunMoved(scene, 120, [&](std::uint64_t step, const world::Engine& engine) {
    if (step == 119) {
      EXPECT_NEAR(Velocity(engine, 0).x(), 1.5, 1e-2);
    }
    // The friction is 0.5 * 0.5 of the weight: 0.25 g.
    if (step == 9) {
      EXPECT_NEAR(Velocity(engine, 0).x(), 0.25 * 9.8 * 10 / 60, 0.1);
    }
  });
}

TEST(Kinematics, MoveAlikeInEveryTimeStep) {
  const TemporaryFolder folder;
  const std::string csv =
      "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n0.7,3,0,1,0,0,1,0\n1.1,3,-2,1,0,1,0,0\n";
  WriteFile(folder / "lift.csv", csv);
  plan::Scene scene = MoverScene({15, 15, 15}, {0, 0, 0});
  SetGroup(scene, "location",
           Layout("path", {{"file", schema::Text{(folder / "lift.csv").string()}},
                           {"sha256", schema::Text{plan::Sha256Hex(csv)}}}),
           1);
  std::vector<Vector3d> places;
  std::vector<Eigen::Quaterniond> turns;
  RunMoved(scene, 90, [&](std::uint64_t, const world::Engine& engine) {
    places.push_back(Position(engine, 1));
    turns.push_back(Orientation(engine, 1));
  });
  EXPECT_EQ(places.back(), Vector3d(3, -2, 1));
  SetWorld(scene, "timestep", 1.0 / 240);
  RunMoved(scene, 360, [&](std::uint64_t step, const world::Engine& engine) {
    if (step % 4 != 3) return;
    EXPECT_LE((Position(engine, 1) - places[step / 4]).norm(), 10 * kEpsilon);
    EXPECT_LE(Orientation(engine, 1).angularDistance(turns[step / 4]), 1e-7 + 10 * kEpsilon);
  });
}

/// A bat hits a ball at rest: all energy comes from the bat.
plan::Scene BatScene() {
  plan::Scene scene = MoverScene({0, 0, 0}, {-6, 0, 0});
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetGroup(scene, "linear_velocity", Vector3d(6, 0, 0), 1);
  return scene;
}

TEST(Kinematics, DoWorkThatVoidsNoRun) {
  const plan::Scene scene = BatScene();
  EXPECT_EQ(analysis::ExpectationOf(scene), analysis::Expectation::kDriven);
  const Recorded run = RunHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  EXPECT_NEAR(Velocity(*run.engine, 0).x(), 6, 0.1) << "it was hit";
  const auto judged = protocol::Judge(scene, run.recording, run.header().cycles_done.load());
  EXPECT_EQ(judged.verdict, protocol::Verdict::kStable) << protocol::VerdictName(judged.verdict);
}

TEST(Kinematics, LeaveTheCubeAndPassWhatIsFixed) {
  plan::Scene scene = MoverScene({15, -19.5, 15}, {0, 0, 0});
  SetWorld(scene, "world.walls", Word("all"));
  SetGroup(scene, "linear_velocity", Vector3d(-60, 0, 0), 1);
  const std::size_t group = AddGroup(scene, "post", 1, Points({{-10, 0, 0}}));
  SetGroup(scene, "mass", Word("fixed"), group);
  const Recorded run = RunHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  EXPECT_NEAR(Position(*run.engine, 1).x(), -120, 1e-4);
  const auto judged = protocol::Judge(scene, run.recording, run.header().cycles_done.load());
  EXPECT_EQ(judged.verdict, protocol::Verdict::kStable) << protocol::VerdictName(judged.verdict);
}

TEST(Kinematics, NothingIsLeftOutThatTheyReach) {
  // Without the bat, nothing touches here.
  plan::Scene scene = BatScene();
  SetWorld(scene, "world.walls", Word("all"));
  SetWorld(scene, "cycles", std::uint64_t{400});
  for (const char* detector : {"dbvt", "sap32", "grid", "auto"}) {
    SCOPED_TRACE(detector);
    SetWorld(scene, "detector", Word(detector));
    SetWorld(scene, "omit", schema::WordList{"auto"});
    const Recorded pruned = RunHere(scene);
    ASSERT_TRUE(pruned.done()) << pruned.message();
    EXPECT_NE(pruned.header().decisions.str().find("mover are kinematic and push other objects"),
              std::string::npos)
        << pruned.header().decisions.str();
    SetWorld(scene, "omit", schema::WordList{"none"});
    EXPECT_EQ(RunHere(scene).hash(), pruned.hash());
  }
}

/// Except sap and sap32, which drop a pair, and with it the last impulses, when one box has moved
/// and the other has not yet.
TEST(Kinematics, EveryDetectorMovesAlike) {
  plan::Scene scene = LayoutScene(40, 12, Word("uniform"));
  SetWorld(scene, "precision", Word(world::EnginePrecision()));
  SetWorld(scene, "pair_order", Word("sorted"));
  SetWorld(scene, "sleeping", false);
  SetWorld(scene, "cycles", std::uint64_t{150});
  // As the last body, it is one of the few that detectors treat as walls.
  const std::size_t group = AddGroup(scene, "mover", 1, Points({{0, -5.4, 0}}));
  SetGroup(scene, "type", Word("cuboid"), group);
  SetGroup(scene, "aspect", schema::Ratio{Vector3d(10, 1, 1)}, group);
  SetGroup(scene, "mass", Word("kinematic"), group);
  SetGroup(scene, "angular_velocity", Vector3d(0, 4, 0), group);
  std::vector<std::string> detectors = BroadPhases(/*only_own=*/true);
  detectors.emplace_back("dbvt");
  ExpectAlike(scene, detectors);
}

/// Pairs with sleeping bodies are found, although only the mover moves, which is the first or the
/// last body.
TEST(Kinematics, MeetWhatSleeps) {
  for (const bool is_last : {false, true}) {
    SCOPED_TRACE(is_last);
    plan::Scene scene = LayoutScene(1, 40, Points({{0, -19.4, 0}}));
    SetWorld(scene, "precision", Word(world::EnginePrecision()));
    SetWorld(scene, "pair_order", Word("sorted"));
    SetWorld(scene, "cycles", std::uint64_t{360});
    SetGroup(scene, "type", Word("cuboid"));
    const std::size_t group = AddGroup(scene, "mover", 1, Points({{-16, -19.4, 0}}));
    const std::size_t mover = is_last ? group : 0;
    if (!is_last) std::swap(scene.groups[0].settings, scene.groups[group].settings);
    SetGroup(scene, "type", Word("cuboid"), mover);
    SetGroup(scene, "mass", Word("kinematic"), mover);
    SetGroup(scene, "linear_velocity", Vector3d(4, 0, 0), mover);
    std::string hash;
    for (const char* detector : {"dbvt", "skin", "grid", "auto"}) {
      SetWorld(scene, "detector", Word(detector));
      bool has_slept = false;
      RunMoved(scene, 180, [&](std::uint64_t, const world::Engine& engine) {
        has_slept |= engine.objects()[1 - mover]->getActivationState() == ISLAND_SLEEPING;
      });
      EXPECT_TRUE(has_slept) << detector;
      const Recorded run = RunHere(scene);
      ASSERT_TRUE(run.done()) << run.message();
      if (hash.empty()) hash = run.hash();
      EXPECT_EQ(run.hash(), hash) << detector;
      EXPECT_GT(Position(*run.engine, 1 - mover).x(), 6) << detector << ": pushed along";
    }
  }
}

}  // namespace
}  // namespace cdb::tests
