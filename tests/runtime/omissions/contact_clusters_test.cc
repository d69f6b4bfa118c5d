#include "runtime/omissions/contact_clusters.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "tests/runtime/omissions/hand_made_scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

TEST(ContactClusters, WhoIsHitMayHitOthersAndWalls) {
  HandMade scene;
  scene.Add({0, 0, 0}, {20, 0, 0});
  scene.Add({5, 0, 0});
  scene.Add({12, 0, 0});   // 0 stops before it, 1 may not
  scene.Add({0, 0, -40});  // too far from all others
  scene.state.objects[0].linear_velocity = Vector3d(20, 2, 0);
  omissions::Reachability reachability = scene.Make();
  EXPECT_EQ(reachability.largest_cluster, 3u);
  EXPECT_EQ(reachability.walls[3], 0);
  scene.state.objects[2].pose.position.x() = 47;
  reachability = scene.Make();
  EXPECT_EQ(reachability.largest_cluster, 2u);
  EXPECT_EQ(reachability.walls[2], 0);
}

TEST(ContactClusters, WhoIsHitMayReachAWall) {
  // In free flight, neither comes near the wall +x: 0 passes it, 1 rests.
  HandMade scene;
  scene.Add({38, -14, 0}, {0, 28, 0});
  scene.Add({38, 0, 0});
  const omissions::Reachability reachability = scene.Make();
  EXPECT_NE(reachability.walls[1] & Bit(1), 0);
  EXPECT_EQ(reachability.walls[1] & Bit(0), 0);
  scene.state.objects[1].pose.position.z() = 10;  // out of the way
  EXPECT_TRUE(scene.Make().nothing_touches);
}

TEST(ContactClusters, LightOnesFlyOffFast) {
  for (const double mass : {1.0, 1000.0}) {
    // The struck ball leaves at 10 m/s if both have the same mass, otherwise at 20.
    HandMade scene;
    scene.Set("solver.erp", 0.0);
    scene.Add({-kPairTouch - 0.1, 0, 0}, {10, 0, 0}, mass);
    scene.Add({0, 0, 0});
    const omissions::Reachability near = scene.Make();
    EXPECT_EQ(near.largest_cluster, 2u);
    EXPECT_EQ(near.walls[1], 0);
    scene.state.objects[0].pose.position.x() += 32;
    scene.state.objects[1].pose.position.x() += 32;
    EXPECT_EQ(scene.Make().walls[1] & Bit(1), mass == 1 ? 0 : Bit(1));
    // The heavy ball never gets much faster than it was.
    EXPECT_EQ(scene.Make().walls[0], 0);
  }
}

TEST(ContactClusters, SpinIsEnergyToo) {
  HandMade scene;
  scene.Add({40, 0, 0});
  scene.Add({42, 0, 0});
  EXPECT_EQ(scene.Make().walls[1], 0);
  scene.state.objects[0].angular_velocity = Vector3d(0, 0, 30);
  EXPECT_EQ(scene.Make().walls[1] & Bit(1), Bit(1));
}

TEST(ContactClusters, TwoAtOneFixedObjectAreNoCrowd) {
  HandMade scene;
  scene.Add({0, 0, 0}, {0, 0, 0}, 0);
  scene.state.objects[0].solid.sides.setConstant(40);
  scene.Add({-21.5, 0, 0}, {1, 0, 0});
  scene.Add({21.5, 0, 0}, {-1, 0, 0});
  const omissions::Reachability reachability = scene.Make();
  EXPECT_FALSE(reachability.nothing_touches);
  EXPECT_EQ(reachability.largest_cluster, 1u);
  EXPECT_EQ(reachability.walls, (std::vector<std::uint8_t>{0, 0, 0}));
}

TEST(ContactClusters, BounceOffAWallMayHitOthers) {
  HandMade scene;
  scene.Add({45, 0, 0}, {20, 0, 0});
  scene.Add({42, 5, 0}, {0, 0, 0});
  const omissions::Reachability reachability = scene.Make();
  EXPECT_EQ(reachability.largest_cluster, 2u);
  EXPECT_EQ(reachability.closest, "object 1 may touch the wall +x at 0.1983 s");
}

TEST(ContactClusters, ATouchLateInTheRunSpreadsLittle) {
  HandMade scene;
  scene.Add({0, -kHalf + kWallTouch + 20 * kLast - 0.5, 0}, {0, -20, 0});
  scene.Add({5, -kHalf + 3, 0});
  const omissions::Reachability late = scene.Make();
  EXPECT_EQ(late.walls, (std::vector<std::uint8_t>{Bit(2), 0}));
  EXPECT_EQ(late.largest_cluster, 1u);
  scene.state.objects[0].pose.position.y() = -kHalf + kWallTouch + 0.5;
  EXPECT_EQ(scene.Make().largest_cluster, 2u);
}

TEST(ContactClusters, FallingAddsEnergyWhereWallsHold) {
  HandMade scene;
  scene.Set("cycles", std::uint64_t{640});
  scene.state.acceleration = Vector3d(0, -9.8, 0);
  scene.Set("world.side", 4000.0);
  scene.Add({0, -1998.5, 0});  // falls 0.5 m, so it is never faster than 5 m/s
  const omissions::Reachability floor = scene.Make();
  EXPECT_EQ(floor.walls[0], Bit(2));
  scene.Add({0, -1900, 0});
  scene.state.objects[1].linear_velocity.y() = 96;  // stays in the air
  EXPECT_EQ(scene.Make().largest_cluster, 1u);
}

TEST(ContactClusters, TheLowerOneStopsTheUpperOne) {
  // They fall side by side, and never meet in free flight.
  HandMade scene;
  scene.state.acceleration = Vector3d(0, -9.8, 0);
  scene.Add({0, -kHalf + 1.5, 0});
  scene.Add({0, -kHalf + 9.5, 0});
  EXPECT_EQ(scene.Make().largest_cluster, 2u);
  scene.state.objects[1].pose.position.x() = 20;
  const omissions::Reachability apart = scene.Make();
  EXPECT_EQ(apart.largest_cluster, 1u);
  EXPECT_EQ(apart.walls, (std::vector<std::uint8_t>{Bit(2), 0}));
}

TEST(ContactClusters, DampingTakesThemOutOfTheFallingFrame) {
  // Without damping, the two would return to their start, side by side.
  HandMade scene;
  scene.Set("cycles", std::uint64_t{127});
  scene.state.acceleration = Vector3d(0, -10, 0);
  for (const double x : {0.0, kPairTouch - 0.01}) scene.Add({x, -40, 0}, {0, 10, 0});
  EXPECT_EQ(scene.Make().largest_cluster, 2u);
  EXPECT_EQ(scene.Make().walls[0], 0);
  scene.state.objects[1].numbers["linear_damping"] = 0.9;
  EXPECT_NE(scene.Make().walls[0] & Bit(2), 0);
  EXPECT_NE(scene.Make().walls[1] & Bit(2), 0);
}

TEST(ContactClusters, WhoIsSlowedByAMeetingMayFallAsleep) {
  // The first two meet. While awake, each moves faster than the third, which follows them.
  HandMade scene;
  scene.Set("cycles", std::uint64_t{1900});
  scene.Add({-20, 0, 0}, {1.2, 0, 0});
  scene.Add({-20 + kPairTouch + 0.1, 0, 0}, {0.81, 0, 0});
  scene.Add({-26, 0, 0}, {0.5, 0, 0});
  scene.state.objects[2].angular_velocity = Vector3d(2, 0, 0);
  EXPECT_EQ(scene.Make().largest_cluster, 2u);
  scene.Set("sleeping", true);
  EXPECT_EQ(scene.Make().largest_cluster, 3u);
}

TEST(ContactClusters, WhoIsHitMayBounceOffAFixedObject) {
  // The two move side by side past the fixed one, which reverses a ball that the other pushes
  // against it.
  HandMade scene;
  scene.Add({-45, 0, 0}, {60, 0, 0});
  scene.Add({-45, kPairTouch + 0.2, 0}, {60, -0.5, 0});
  const std::uint8_t back = Bit(0);
  const omissions::Reachability alone = scene.Make();
  EXPECT_EQ(alone.largest_cluster, 2u);
  EXPECT_EQ(alone.walls[0] & back, 0);
  scene.Add({-10, -kPairTouch - 0.1, 0}, {0, 0, 0}, 0);
  const omissions::Reachability beside = scene.Make();
  EXPECT_EQ(beside.largest_cluster, 2u);
  EXPECT_EQ(beside.walls[0] & back, back);
  EXPECT_EQ(beside.walls[1] & back, back);
}

TEST(ContactClusters, RoundingCountsAfterAMeetingToo) {
  // Far from the origin, numbers in single precision are 6 cm apart. A resting ball is not rounded
  // in each step, but it is once it may have been hit.
  HandMade scene;
  scene.Set("world.side", 2e6);
  scene.Set("precision", Word("single"));
  scene.Add({1e6 - 15, 0, 0});
  EXPECT_EQ(scene.Make().walls[0], 0);
  scene.Add({1e6 - 15, kPairTouch - 0.01, 0}, {0, -1e-3, 0});
  EXPECT_EQ(scene.Make().walls[0] & Bit(1), Bit(1));
  scene.Set("precision", Word("double"));
  EXPECT_EQ(scene.Make().walls[0], 0);
  EXPECT_EQ(scene.Make().largest_cluster, 2u);
}

}  // namespace
}  // namespace cdb::tests
