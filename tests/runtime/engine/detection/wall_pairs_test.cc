// Pairs with planes that no box reaches are not listed, which changes no motion.
#include "runtime/engine/detection/wall_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "library/scene_error.h"
#include "tests/runtime/engine/paired_run.h"
#include "tests/runtime/engine/random_scenes.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

plan::Scene Sorted(plan::Scene scene, const char* detector) {
  SetWorld(scene, "pair_order", Word("sorted"));
  SetWorld(scene, "detector", Word(detector));
  return scene;
}

/// Objects of 40 m, so that Bullet keeps contacts up to 0.4 m and more.
plan::Scene Large(double fall) {
  plan::Scene scene = EngineScene(60, 300);
  SetWorld(scene, "timestep", 1.0 / 60);
  SetWorld(scene, "acceleration", Vector3d(0, -fall, 0));
  SetGroup(scene, "type", AnyType());
  SetGroup(scene, "size", Uniform(10.0, 60.0));
  SetGroup(scene, "friction", 0.5);
  SetGroup(scene, "linear_velocity", Normal(0.0, 30.0));
  SetGroup(scene, "angular_velocity", Normal(0.0, 1.0));
  return scene;
}

/// Steps both and expects identical states of all bodies after each step.
void ExpectSameMotion(const plan::Scene& scene, const layouts::InitialState& state, int steps,
                      const char* detector) {
  const auto omissions = omissions::KeepEverything(scene);
  // `simple` lists exactly the overlapping boxes.
  world::Engine all(Sorted(scene, "simple"), state, omissions);
  world::Engine reached(Sorted(scene, detector), state, omissions);
  for (int step = 0; step < steps; ++step) {
    all.Step();
    reached.Step();
    ASSERT_TRUE(HaveSameState(all, reached)) << detector << ", step " << step;
    ASSERT_LE(reached.world().getPairCache()->getNumOverlappingPairs(),
              all.world().getPairCache()->getNumOverlappingPairs());
  }
}

void ExpectSameMotion(const plan::Scene& scene, int steps, const char* detector) {
  ExpectSameMotion(scene, layouts::MakeInitialState(scene), steps, detector);
}

TEST(WallPairs, LeaveTheMotionAsItIs) {
  for (const double fall : {0.0, 9.8, 200.0}) ExpectSameMotion(Large(fall), 400, "auto");
  for (const char* detector : {"grid", "octree", "sweep"})
    ExpectSameMotion(Large(50), 150, detector);
}

TEST(WallPairs, LeaveTheMotionOfRandomScenesAsItIs) {
  std::size_t placed = 0;
  for (const RandomScene& random : RandomScenes(80, 15)) {
    SCOPED_TRACE(std::string(random.theme));
    layouts::InitialState state;
    try {
      state = layouts::MakeInitialState(random.scene);
    } catch (const library::SceneError&) {
      continue;  // some do not fit
    }
    ++placed;
    const auto steps = static_cast<int>(random.scene.world.Count("cycles"));
    ExpectSameMotion(random.scene, state, steps, "auto");
  }
  EXPECT_GT(placed, 60u);
}

/// The number of pairs after one step.
int Pairs(const plan::Scene& scene) {
  world::Engine engine(scene, layouts::MakeInitialState(scene), omissions::KeepEverything(scene));
  engine.Step();
  return engine.world().getPairCache()->getNumOverlappingPairs();
}

TEST(WallPairs, AreThoseThatReachTheHalfSpace) {
  plan::Scene scene = EngineScene(50, 1000);
  EXPECT_EQ(Pairs(Sorted(scene, "dbvt")), 300);
  EXPECT_LT(Pairs(Sorted(scene, "auto")), 10);
  EXPECT_LT(Pairs(Sorted(scene, "octree")), 10);
}

TEST(WallPairs, AreAllWhereTheirAbsenceCouldBeSeen) {
  plan::Scene scene = Sorted(EngineScene(50, 1000), "auto");
  SetWorld(scene, "pair_order", Word("listed"));
  EXPECT_EQ(Pairs(scene), 300);
  scene = Sorted(scene, "auto");
  SetGroup(scene, "ccd", true);
  EXPECT_EQ(Pairs(scene), 300);
}

TEST(WallPairs, HalfSpacesReachAsFarAsContacts) {
  const plan::Scene scene = Large(0);
  world::Engine engine(scene, layouts::MakeInitialState(scene), omissions::KeepEverything(scene));
  double breaking = 0;
  for (const auto& body : engine.objects())
    breaking = std::max(breaking,
                        static_cast<double>(body->getCollisionShape()->getContactBreakingThreshold(
                            gContactBreakingThreshold)));
  ASSERT_GT(breaking, 0.3);
  const Box left = detection::HalfSpaceBox(*engine.walls()[0], engine.objects());
  const Box above = detection::HalfSpaceBox(*engine.walls()[3], engine.objects());
  EXPECT_GE(left.upper.x, -150 + breaking - 0.02);
  EXPECT_LT(left.upper.x, -150 + breaking);
  EXPECT_LE(above.lower.y, 150 - breaking + 0.02);
  EXPECT_EQ(left.lower.x, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(left.upper.y, std::numeric_limits<double>::infinity());
  EXPECT_EQ(static_cast<double>(static_cast<btScalar>(left.upper.x)), left.upper.x);
}

/// The scene with only `omit wall_pairs`.
plan::Scene Omitting(plan::Scene scene, const char* detector) {
  scene = Sorted(scene, detector);
  SetWorld(scene, "omit", schema::WordList{"wall_pairs"});
  return scene;
}

constexpr const char* kBullets[] = {"simple", "sap", "sap32", "dbvt"};

TEST(OmitWallPairs, LeavesTheMotionAsItIs) {
  for (const char* detector : kBullets) {
    SCOPED_TRACE(detector);
    for (const double fall : {0.0, 50.0}) {
      const PairedRun paired = RunPaired(Omitting(Large(fall), detector));
      EXPECT_EQ(paired.names(), "wall_pairs");
    }
  }
}

TEST(OmitWallPairs, LeavesTheMotionOfRandomScenesAsItIs) {
  std::size_t omitted = 0, next = 0;
  for (const RandomScene& random : RandomScenes(40, 16)) {
    SCOPED_TRACE(std::string(random.theme));
    const plan::Scene scene = Omitting(random.scene, kBullets[next++ % std::size(kBullets)]);
    try {
      const layouts::InitialState state = layouts::MakeInitialState(scene);
      omitted += RunPaired(scene, state).Omits(schema::Component::kWallPairs) ? 1 : 0;
    } catch (const library::SceneError&) {
      continue;  // some do not fit
    }
  }
  EXPECT_GT(omitted, 15u);
}

TEST(OmitWallPairs, LeavesThePairsThatReachTheHalfSpace) {
  const auto pairs = [](const plan::Scene& scene) {
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    world::Engine engine(scene, state, omissions::DecideOmissions(scene, state));
    engine.Step();
    return engine.world().getPairCache()->getNumOverlappingPairs();
  };
  for (const char* detector : kBullets) {
    plan::Scene scene = Omitting(EngineScene(50, 1000), detector);
    EXPECT_LT(pairs(scene), 10) << detector;
    SetWorld(scene, "omit", schema::WordList{"none"});
    EXPECT_EQ(pairs(scene), 300) << detector;
  }
}

TEST(OmitWallPairs, GivesBulletsOwnTheHalfSpacesOfTheOthers) {
  const plan::Scene scene = Omitting(Large(0), "simple");
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  world::Engine engine(scene, state, omissions::DecideOmissions(scene, state));
  engine.Step();
  const auto box_of = [&](std::size_t wall) {
    btVector3 lower, upper;
    engine.world().getBroadphase()->getAabb(engine.walls()[wall]->getBroadphaseHandle(), lower,
                                            upper);
    return std::pair(lower, upper);
  };
  const double right = detection::HalfSpaceBox(*engine.walls()[0], engine.objects()).upper.x;
  const double bottom = detection::HalfSpaceBox(*engine.walls()[3], engine.objects()).lower.y;
  EXPECT_GE(static_cast<double>(box_of(0).second.x()), right);
  EXPECT_NEAR(static_cast<double>(box_of(0).second.x()), right, 1e-4);
  EXPECT_LE(static_cast<double>(box_of(3).first.y()), bottom);
  EXPECT_NEAR(static_cast<double>(box_of(3).first.y()), bottom, 1e-4);
}

TEST(OmitWallPairs, IsRefusedForObjectsInPieces) {
  plan::Scene scene = Omitting(EngineScene(2, 1000), "dbvt");
  SetGroup(scene, "type", Word("torus"));
  try {
    omissions::DecideOmissions(scene, layouts::MakeInitialState(scene));
    ADD_FAILURE() << "not refused";
  } catch (const library::SceneError& error) {
    EXPECT_EQ(std::string(error.what())
                  .find("omit wall_pairs: this scene needs it: object 1 has "
                        "several convex pieces"),
              0u)
        << error.what();
  }
}

}  // namespace
}  // namespace cdb::tests
