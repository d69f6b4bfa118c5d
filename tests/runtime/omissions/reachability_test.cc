#include "runtime/omissions/omissions.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <string>

#include "tests/runtime/omissions/hand_made_scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

constexpr double kStep = HandMade::kStep;
/// The end of the analysis, s.
constexpr double kEnd = 61 * kStep;
/// More than rounding errors in double precision, less than anything else; m.
constexpr double kLittle = 1e-6;

Vector3d TowardsWall(int wall) { return (wall % 2 == 0 ? -1 : 1) * Vector3d::Unit(wall / 2); }
const char* const kWallNames[] = {"-x", "+x", "-y", "+y", "-z", "+z"};

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Tests with all six walls, as planes and as boxes.
template <typename Body>
void ForEachWall(const Body& body) {
  for (const char* shape : {"plane", "box"}) {
    for (int wall = 0; wall < 6; ++wall) {
      SCOPED_TRACE(testing::Message() << shape << " " << kWallNames[wall]);
      HandMade scene;
      scene.Set("world.wall_shape", Word(shape));
      body(scene, wall, TowardsWall(wall));
    }
  }
}

TEST(ReachabilityOfWalls, SpeedThatJustReachesTheWall) {
  ForEachWall([](HandMade& scene, int wall, const Vector3d& there) {
    scene.Add((kHalf - kWallTouch - 10 * kLast) * there, 10 * there);
    const omissions::Reachability reachability = scene.Make();
    EXPECT_FALSE(reachability.nothing_touches);
    EXPECT_EQ(reachability.walls[0] & Bit(wall), Bit(wall));
    EXPECT_EQ(reachability.largest_cluster, 1u);
    EXPECT_EQ(reachability.closest,
              std::string("object 1 may touch the wall ") + kWallNames[wall] + " at 0.9219 s");
  });
}

TEST(ReachabilityOfWalls, SpeedThatJustDoesNotReachTheWall) {
  ForEachWall([](HandMade& scene, int wall, const Vector3d& there) {
    scene.Add((kHalf - kWallTouch - 10 * kEnd - kLittle) * there, 10 * there);
    const omissions::Reachability reachability = scene.Make();
    EXPECT_TRUE(reachability.nothing_touches);
    EXPECT_EQ(reachability.walls[0], 0);
    // Its surface keeps the distance that a contact needs.
    EXPECT_EQ(reachability.closest,
              std::string("object 1 stays 0.03464 m from the wall ") + kWallNames[wall]);
  });
}

TEST(ReachabilityOfWalls, GravityThatJustReachesTheWall) {
  ForEachWall([](HandMade& scene, int wall, const Vector3d& there) {
    const double fall = 9.8 * kStep * kStep * 59 * 60 / 2;
    scene.state.acceleration = 9.8 * there;
    scene.Add((kHalf - kWallTouch - fall) * there);
    EXPECT_NE(scene.Make().walls[0] & Bit(wall), 0);
    scene.state.objects[0].pose.position =
        (kHalf - kWallTouch - 9.8 * kStep * kStep * 61 * 62 / 2 - kLittle) * there;
    EXPECT_TRUE(scene.Make().nothing_touches);
  });
}

TEST(ReachabilityOfWalls, GravityThatTurnsItBackJustBeforeTheWall) {
  ForEachWall([](HandMade& scene, int wall, const Vector3d& there) {
    // v dt k - g dt^2 k (k + 1) / 2 is largest at k = 31 and 32: 31 * 32 / 2 dt^2 g.
    const double g = 32;
    scene.state.acceleration = -g * there;
    const double apex = g * kStep * kStep * 31 * 32 / 2;
    const Vector3d velocity = g * kStep * 32 * there;
    scene.Add((kHalf - kWallTouch - apex) * there, velocity);
    EXPECT_NE(scene.Make().walls[0] & Bit(wall), 0);
    // Between the two cycles, the parabola is higher by g dt^2 / 8.
    scene.state.objects[0].pose.position =
        (kHalf - kWallTouch - apex - g * kStep * kStep / 8 - kLittle) * there;
    EXPECT_TRUE(scene.Make().nothing_touches);
  });
}

TEST(ReachabilityOfWalls, WarmupIsPartOfTheRun) {
  HandMade scene;
  scene.Add({kHalf - kWallTouch - 10 * kLast, 0, 0}, {10, 0, 0});
  scene.Set("cycles", std::uint64_t{20});
  EXPECT_TRUE(scene.Make().nothing_touches);
  scene.Set("warmup", std::uint64_t{40});
  EXPECT_FALSE(scene.Make().nothing_touches);
}

TEST(ReachabilityOfWalls, OnlyThoseThatStand) {
  HandMade scene;
  scene.Add({0, -kHalf + 1, 0});
  scene.Add({kHalf - 1, 0, 0});
  EXPECT_EQ(scene.Make().walls, (std::vector<std::uint8_t>{Bit(2), Bit(1)}));
  scene.Set("world.walls", Word("floor"));
  EXPECT_EQ(scene.Make().walls, (std::vector<std::uint8_t>{Bit(2), 0}));
  scene.Set("world.walls", Word("none"));
  const omissions::Reachability reachability = scene.Make();
  EXPECT_EQ(reachability.walls, (std::vector<std::uint8_t>{0, 0}));
  EXPECT_TRUE(reachability.nothing_touches);
  EXPECT_EQ(reachability.closest,
            "there are no walls, and no two objects come close to one another");
}

TEST(ReachabilityOfWalls, WithoutSpinAnObjectIsAsTallAsItIsTurned) {
  HandMade scene;
  scene.Add({0, -kHalf + 1.2, 0});
  scene.state.objects[0].solid = {objects::Shape::kCuboid, Vector3d(2, 2, 2)};
  EXPECT_EQ(scene.Make().walls[0], 0);
  scene.state.objects[0].angular_velocity = Vector3d(0, 0, 0.1);
  EXPECT_EQ(scene.Make().walls[0], Bit(2));  // half its diagonal is 1.73
  scene.state.objects[0].angular_velocity.setZero();
  scene.state.objects[0].pose.orientation = layouts::TurnAbout(Vector3d(0, 0, 0.7));
  EXPECT_EQ(scene.Make().walls[0], Bit(2));
}

TEST(ReachabilityOfWalls, SingleAllowsForItsRounding) {
  HandMade scene;
  scene.Set("world.side", 10000.0);
  scene.Add({5000 - kWallTouch - 10 * kEnd - 0.001, 0, 0}, {10, 0, 0});
  EXPECT_TRUE(scene.Make().nothing_touches);
  scene.Set("precision", Word("single"));
  EXPECT_EQ(scene.Make().walls[0], Bit(1));
  scene.state.objects[0].pose.position.x() -= 1;
  EXPECT_TRUE(scene.Make().nothing_touches);
}

TEST(ReachabilityOfPairs, HeadOn) {
  HandMade scene;
  scene.Add({0, 0, 0}, {10, 0, 0});
  scene.Add({kPairTouch + 20 * kLast, 0, 0}, {-10, 0, 0});
  const omissions::Reachability reachability = scene.Make();
  EXPECT_FALSE(reachability.nothing_touches);
  EXPECT_EQ(reachability.largest_cluster, 2u);
  EXPECT_EQ(reachability.closest, "objects 1 and 2 may touch at 0.9219 s");
  scene.state.objects[1].pose.position.x() = kPairTouch + 20 * kEnd + kLittle;
  EXPECT_TRUE(scene.Make().nothing_touches);
  EXPECT_EQ(scene.Make().largest_cluster, 1u);
}

TEST(ReachabilityOfPairs, Passing) {
  for (const double aside : {-kLittle, kLittle}) {
    for (const double fall : {0.0, -9.8}) {
      HandMade scene;
      scene.state.acceleration = Vector3d(0, fall, 0);
      // Side by side at 0.5 s: relative to one, the other approaches along x.
      scene.Add({0, 5, 0}, {10, 10, 0});
      scene.Add({5, 5 + kPairTouch + aside, 0}, {0, 10, 0});
      const omissions::Reachability reachability = scene.Make();
      EXPECT_EQ(reachability.nothing_touches, aside > 0);
      EXPECT_TRUE(Contains(reachability.closest, aside > 0 ? "objects 1 and 2 stay 0.03464 m apart"
                                                           : "objects 1 and 2 may touch at 0.49"))
          << reachability.closest;
    }
  }
}

TEST(ReachabilityOfPairs, ParallelFallNeverTouches) {
  HandMade scene;
  scene.Set("world.walls", Word("none"));
  scene.Set("cycles", std::uint64_t{10000});
  scene.state.acceleration = Vector3d(1, -9.8, 2);
  scene.Add({0, 0, 0}, {3, 4, 5});
  scene.Add({0, kPairTouch + 0.01, 0}, {3, 4, 5});
  EXPECT_TRUE(scene.Make().nothing_touches);
  scene.state.objects[1].linear_velocity.y() -= 1e-3;
  EXPECT_FALSE(scene.Make().nothing_touches);
}

TEST(ReachabilityOfPairs, TouchingAtTheStartCounts) {
  HandMade scene;
  scene.Add({0, 0, 0});
  scene.Add({kPairTouch - kLittle, 0, 0});
  EXPECT_EQ(scene.Make().closest, "objects 1 and 2 may touch at 0 s");
}

TEST(ReachabilityOfPairs, TheSmallerThresholdCounts) {
  HandMade scene;
  scene.Add({0, 0, 0});
  scene.Add({0, 12 + kPairTouch - 2 - kLittle, 0});
  scene.state.objects[0].solid.sides.setConstant(22);  // so its threshold is 11 times as large
  EXPECT_FALSE(scene.Make().nothing_touches);
  scene.state.objects[1].pose.position.y() += 2 * kLittle;
  EXPECT_TRUE(scene.Make().nothing_touches);
}

TEST(ReachabilityOfPairs, FixedObjectInTheWay) {
  HandMade scene;
  scene.state.acceleration = Vector3d(0, -10, 0);
  scene.Add({0, 20, 0});
  const double fall = 10 * kStep * kStep * 59 * 60 / 2;
  scene.Add({0, 20 - fall - kPairTouch, 0}, {0, 0, 0}, 0);
  const omissions::Reachability reachability = scene.Make();
  EXPECT_EQ(reachability.closest, "objects 1 and 2 may touch at 0.9219 s");
  EXPECT_EQ(reachability.largest_cluster, 1u);  // it is in no cluster
  scene.state.objects[1].pose.position.y() =
      20 - 10 * kStep * kStep * 61 * 62 / 2 - kPairTouch - kLittle;
  EXPECT_TRUE(scene.Make().nothing_touches);
}

TEST(ReachabilityOfPairs, ThrownOverAFixedObject) {
  // The swept box contains the obstacle, but the path passes it.
  HandMade scene;
  scene.Set("cycles", std::uint64_t{127});
  scene.state.acceleration = Vector3d(0, -10, 0);
  scene.Add({-10, 0, 0}, {10, 10, 0});
  scene.Add({0, 5 - kPairTouch - 0.1, 0}, {0, 0, 0}, 0);
  EXPECT_TRUE(scene.Make().nothing_touches);
  scene.state.objects[1].pose.position.y() += 0.3;
  EXPECT_FALSE(scene.Make().nothing_touches);
}

TEST(ReachabilityOfPairs, FixedOnesTouchNothing) {
  HandMade scene;
  scene.Add({0, -kHalf, 0}, {0, 0, 0}, 0);
  scene.Add({0, -kHalf + 1, 0}, {0, 0, 0}, 0);
  const omissions::Reachability reachability = scene.Make();
  EXPECT_TRUE(reachability.nothing_touches);
  EXPECT_EQ(reachability.walls, (std::vector<std::uint8_t>{0, 0}));
  EXPECT_EQ(reachability.closest, "no object moves");
  EXPECT_EQ(reachability.largest_cluster, 1u);
  EXPECT_EQ(reachability.longest_rest, 0);
  EXPECT_EQ(reachability.largest_box, 0);
}

TEST(ReachabilityOfPairs, NoObjects) {
  HandMade scene;
  const omissions::Reachability reachability = scene.Make();
  EXPECT_TRUE(reachability.nothing_touches);
  EXPECT_TRUE(reachability.walls.empty());
}

TEST(ReachabilityOfPairs, DampedOnesMayStayBehind) {
  HandMade scene;
  scene.Add({0, 0, 0}, {5, 0, 0});
  scene.Add({-kPairTouch - 1, 0, 0}, {5, 0, 0});
  EXPECT_TRUE(scene.Make().nothing_touches);
  scene.state.objects[0].numbers["linear_damping"] = 0.5;
  EXPECT_FALSE(scene.Make().nothing_touches);
}

TEST(ReachabilityOfPairs, DampedOneTurnsNoFartherThanGravityTakesIt) {
  // Without damping it would return; with damping it falls earlier and reaches the floor.
  HandMade scene;
  scene.Set("cycles", std::uint64_t{127});
  scene.state.acceleration = Vector3d(0, -10, 0);
  scene.Add({0, -40, 0}, {0, 10, 0});
  EXPECT_EQ(scene.Make().walls[0], 0);
  scene.state.objects[0].numbers["linear_damping"] = 0.9;
  EXPECT_EQ(scene.Make().walls[0] & Bit(2), Bit(2));
}

TEST(ReachabilityAsleep, SleepersStandInTheWay) {
  // The first is slow enough to sleep; the second would never catch up with it if it stayed awake.
  HandMade scene;
  scene.Set("cycles", std::uint64_t{400});
  scene.Add({0, 0, 0}, {0.5, 0, 0});
  scene.Add({-kPairTouch - 3, 0, 0}, {0.9, 0, 0});
  EXPECT_TRUE(scene.Make().nothing_touches);
  scene.Set("sleeping", true);
  EXPECT_FALSE(scene.Make().nothing_touches);
  scene.state.objects[0].angular_velocity = Vector3d(0, 2, 0);  // stays awake
  EXPECT_TRUE(scene.Make().nothing_touches);
  scene.state.objects[0].angular_velocity.setZero();
  scene.Set("cycles", std::uint64_t{100});  // fewer than sleeping takes
  EXPECT_TRUE(scene.Make().nothing_touches);
}

TEST(ReachabilityAsleep, RestIsReported) {
  HandMade scene;
  scene.Add({0, 0, 0}, {0.79, 0, 0});
  EXPECT_EQ(scene.Make().longest_rest, kEnd);
  scene.state.objects[0].linear_velocity.x() = 0.81;
  EXPECT_EQ(scene.Make().longest_rest, 0);
  scene.state.acceleration = Vector3d(-3.2, 0, 0);
  // From 0.8 to -0.8 m/s.
  EXPECT_NEAR(scene.Make().longest_rest, 0.5 + kStep, 1e-9);
  scene.Add({0, 10, 0}, {0.5, 0, 0});
  scene.state.objects[0].mass = 0;
  EXPECT_NEAR(scene.Make().longest_rest, 1.3 / 3.2 + kStep, 1e-9);
}

TEST(ReachabilityBox, DiagonalAndWay) {
  HandMade scene;
  scene.state.acceleration = Vector3d(0, -10, 0);
  scene.Add({0, 0, 0}, {3, 0, 0});
  scene.Add({0, 0, 20}, {0, 0, 0}, 0);
  scene.state.objects[1].solid.sides.setConstant(10);  // fixed ones do not count
  const double fastest = std::hypot(3, 10 * kEnd);
  const double least = 2 * std::sqrt(3.0) + fastest * kStep;
  EXPECT_GE(scene.Make().largest_box, least + 0.04 * std::sqrt(3.0));
  EXPECT_LE(scene.Make().largest_box, least + 0.2);
}

TEST(ReachabilityGivesUp, Ccd) {
  HandMade scene;
  scene.Add({0, 0, 0});
  scene.Add({10, 0, 0}, {0, 0, 0}, 0);
  scene.state.objects[1].numbers["ccd"] = 1;
  EXPECT_TRUE(scene.Make().nothing_touches);  // fixed bodies are not swept
  scene.state.objects[0].numbers["ccd"] = 1;
  const omissions::Reachability reachability = scene.Make();
  EXPECT_FALSE(reachability.nothing_touches);
  EXPECT_EQ(reachability.walls, (std::vector<std::uint8_t>{0x3f, 0}));
  EXPECT_EQ(reachability.closest, "object 1 has ccd, which finds contacts along its path");
}

TEST(ReachabilityGivesUp, SoftContacts) {
  HandMade scene;
  scene.Add({0, 0, 0});
  scene.Add({10, 0, 0}, {0, 0, 0});
  scene.Add({-10, 0, 0}, {5, 0, 0});
  scene.state.objects[1].numbers["contact_stiffness"] = 1000;
  EXPECT_TRUE(scene.Make().nothing_touches);  // it touches nothing
  scene.state.objects[2].linear_velocity.x() = 20;
  const omissions::Reachability reachability = scene.Make();
  EXPECT_FALSE(reachability.nothing_touches);
  EXPECT_EQ(reachability.largest_cluster, 3u);
  EXPECT_EQ(reachability.walls, (std::vector<std::uint8_t>{0x3f, 0x3f, 0x3f}));
  EXPECT_TRUE(Contains(reachability.closest, "objects 1 and 3 may touch at 0.39"))
      << reachability.closest;
  EXPECT_TRUE(Contains(reachability.closest, "object 2 has a soft contact"))
      << reachability.closest;
}

TEST(ReachabilityGivesUp, NumbersTooLarge) {
  for (const double speed : {1e80, 1e200, std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::quiet_NaN()}) {
    HandMade scene;
    scene.Set("world.walls", Word("floor"));
    scene.Add({0, 0, 0}, {speed, 0, 0});
    scene.Add({10, 0, 0}, {0, 0, 0}, 0);
    const omissions::Reachability reachability = scene.Make();
    EXPECT_FALSE(reachability.nothing_touches);
    EXPECT_EQ(reachability.walls, (std::vector<std::uint8_t>{Bit(2), 0}));
    EXPECT_TRUE(Contains(reachability.closest, "object 1 gets too far")) << reachability.closest;
  }
}

TEST(ReachabilityGivesUp, DenseGas) {
  plan::Scene scene = DefaultScene(3000, 1500);
  SetWorld(scene, "cycles", std::uint64_t{1000});
  SetGroup(scene, "linear_velocity", Normal(Vector3d(0, 0, 0), Vector3d(60, 60, 60)));
  const omissions::Reachability reachability =
      omissions::AnalyseReachability(scene, layouts::MakeInitialState(scene));
  EXPECT_FALSE(reachability.nothing_touches);
  EXPECT_EQ(reachability.largest_cluster, 3000u);
  EXPECT_EQ(reachability.walls, std::vector<std::uint8_t>(3000, 0x3f));
  // It does not search for everything that may meet first.
  EXPECT_TRUE(Contains(reachability.closest, "too many objects may meet to predict their contacts"))
      << reachability.closest;
}

TEST(ReachabilityScale, ThePapersSceneNeedsFewWalls) {
  for (const std::uint64_t seed : {std::uint64_t{0xAAAAAAAAAA}, std::uint64_t{1}, std::uint64_t{2},
                                   std::uint64_t{3}, std::uint64_t{4}}) {
    for (const std::uint64_t count : {1000, 5000}) {
      plan::Scene scene = DefaultScene(count, 50.0 * static_cast<double>(count));
      SetWorld(scene, "cycles", std::uint64_t{1000});
      SetGroup(scene, "type", AnyType());
      SeedStreams(scene, seed);
      const omissions::Reachability reachability =
          omissions::AnalyseReachability(scene, layouts::MakeInitialState(scene));
      std::size_t kept = 0;
      for (const std::uint8_t walls : reachability.walls)
        kept += static_cast<std::size_t>(std::popcount(walls));
      EXPECT_GT(kept, 5u) << seed;
      EXPECT_LT(kept, 60u) << seed;
      EXPECT_LE(reachability.largest_cluster, 8u) << seed;
    }
  }
}

TEST(ReachabilityScale, RestingSpheresTouchNothing) {
  plan::Scene scene = DefaultScene(1000, 50000);
  SetWorld(scene, "cycles", std::uint64_t{1000});
  SetWorld(scene, "acceleration", Vector3d(Vector3d::Zero()));
  const omissions::Reachability reachability =
      omissions::AnalyseReachability(scene, layouts::MakeInitialState(scene));
  EXPECT_TRUE(reachability.nothing_touches) << reachability.closest;
  EXPECT_NEAR(reachability.longest_rest, 1001.0 / 60, 1e-9);
}

}  // namespace
}  // namespace cdb::tests
