// Rigid bodies that move beside soft ones, in both of Bullet's worlds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "runtime/protocol/verdict.h"
#include "tests/runtime/engine/soft/soft_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

constexpr double kRounding = std::numeric_limits<btScalar>::epsilon();
constexpr double kGravity = 9.8;
constexpr const char* kWorlds[] = {"positions", "springs"};

/// A cloth of 1 m and 0.5 kg over x and z at y = 0, with `of_cloth`, and `others`.
std::string Cloth(const std::string& world, const std::string& of_cloth,
                  const std::string& others) {
  return "world { side 100; walls none } soft_world " + world + "; " + others +
         " objects cloth { quantity 1; type cloth(columns: 10, rows: 10); size 1; mass 0.5; margin "
         "0.02; location at(0, 0, 0); overlap on; " +
         of_cloth + " }";
}

const btRigidBody& RigidAt(const soft::SoftWorld& world, std::size_t i = 0) {
  return *world.rigid()[i];
}
Vector3d PlaceOf(const soft::SoftWorld& world) {
  return world::ToEigen(RigidAt(world).getWorldTransform().getOrigin());
}

TEST(RigidBesideSoft, FallsFreely) {
  for (const char* kind : kWorlds) {
    const plan::Run run = SoftRun(
        Cloth(kind, "",
              "timestep 1/128; objects ball { quantity 1; size 0.2; mass 2; location at(0, 5, 0); "
              "linear_velocity (0, 6, 1) }"));
    soft::SoftWorld world = MakeSoftWorld(run);
    constexpr int kSteps = 100;
    constexpr double dt = 1.0 / 128;
    for (int i = 0; i < kSteps; ++i) world.Step();
    EXPECT_NEAR(PlaceOf(world).y(),
                5 + 6 * dt * kSteps - kGravity * dt * dt * kSteps * (kSteps + 1) / 2,
                kSteps * 100 * kRounding)
        << kind;
    EXPECT_NEAR(PlaceOf(world).z(), dt * kSteps, kSteps * 10 * kRounding);
  }
}

/// Both have fallen together before the first cycle, past where the ball was at the start.
TEST(RigidBesideSoft, PassesNothingInAWarmUp) {
  for (const char* kind : kWorlds) {
    const protocol::Recording recording = RecordSoft(
        SoftRun(Cloth(kind, "",
                      "cycles 5; warmup 800; timestep 1/2000; objects ball { quantity 1; size 0.2; "
                      "mass 2; location at(0, -0.5, 0) }")));
    for (const std::int32_t passed : recording.Ints("passed")) EXPECT_EQ(passed, 0) << kind;
  }
}

/// A ball, or a box that turns, flies into a free cloth: what it loses, the cloth gains.
TEST(RigidBesideSoft, MomentumIsKept) {
  for (const char* kind : kWorlds)
    for (const char* type : {"sphere", "cuboid; angular_velocity (1, 2, 3)"}) {
      const plan::Run run = SoftRun(
          "cycles 200; timestep 1/1000; acceleration 0; " +
          Cloth(kind, "friction 0.5",
                "objects ball { quantity 1; size 0.3; mass 0.5; location at(0.01, 0.25, 0.02); "
                "linear_velocity (0, -2, 0.3); type " +
                    std::string(type) + " }"));
      const protocol::Recording recording = RecordSoft(run);
      for (const double error : recording.Reals("momentum_error"))
        ASSERT_LT(error, 0.001) << kind << type;
      soft::SoftWorld world = MakeSoftWorld(run);
      for (int i = 0; i < 200; ++i) world.Step();
      EXPECT_GT(RigidAt(world).getLinearVelocity().y(), btScalar(-1.9)) << "it met the cloth";
    }
}

/// Once all rest, the pins hold what gravity pulls: the ball and the nodes that are not pinned.
TEST(RigidBesideSoft, PinsHoldTheWeightOfABallAtRest) {
  const plan::Run run =
      SoftRun(Cloth("springs", "soft { pin corners; stiffness 500; damping 1 }",
                    "timestep 1/1000; objects ball { quantity 1; size 0.3; mass "
                    "1; location at(0, 0.18, 0); overlap on; linear_damping 0.98; "
                    "angular_damping 0.98 }"));
  soft::SoftWorld world = MakeSoftWorld(run);
  for (int i = 0; i < 4000; ++i) world.Step();
  EXPECT_LT(world::ToEigen(RigidAt(world).getLinearVelocity()).norm(), 0.01);
  const soft::SoftObject& cloth = world.bodies()[0];
  Vector3d on_pins = Vector3d::Zero();
  for (std::size_t i = 0; i < cloth.mesh.links.size(); ++i) {
    auto [a, b] = cloth.mesh.links[i];
    if (cloth.masses[a] == cloth.masses[b]) continue;
    if (cloth.masses[a] > 0) std::swap(a, b);
    if (cloth.masses[a] > 0) continue;
    const Vector3d along = NodeAt(world, static_cast<int>(b)) - NodeAt(world, static_cast<int>(a));
    on_pins += cloth.stiffness * (along.norm() - cloth.rest[i]) * along.normalized();
  }
  double weight = kGravity;
  for (const double mass : cloth.masses) weight += kGravity * mass;
  EXPECT_NEAR(-on_pins.y(), weight, 0.02 * weight);
  EXPECT_NEAR(on_pins.x(), 0, 0.02 * weight);
}

std::string Thrown(const std::string& world, const std::string& ball) {
  const std::string stiffness = world == "springs" ? "; stiffness 100" : "";
  return "cycles 100; timestep 1/480; acceleration 0; " +
         Cloth(world, "soft { pin corners" + stiffness + " }",
               "objects ball { quantity 1; size 0.2; location at(0.01, 0.3, 0.02); " + ball + " }");
}

TEST(RigidBesideSoft, ABallThroughAClothHasPassed) {
  for (const char* kind : kWorlds) {
    // In a cycle, it moves by a metre.
    const plan::Run run = SoftRun(Thrown(kind, "mass 50; linear_velocity (0, -480, 0)"));
    const protocol::Recording recording = RecordSoft(run);
    const auto passed = recording.Ints("passed");
    EXPECT_EQ(passed.front(), 1) << kind;
    EXPECT_EQ(passed.back(), 1);
    const protocol::Judgement judgement = protocol::Judge(run.scene, recording, 100);
    EXPECT_GE(judgement.verdict, protocol::Verdict::kTunnelled);
  }
}

TEST(RigidBesideSoft, ABallThatIsCaughtHasNot) {
  for (const char* kind : kWorlds) {
    const plan::Run run = SoftRun(Thrown(kind, "mass 0.05; linear_velocity (0, -1, 0)"));
    const protocol::Recording recording = RecordSoft(run);
    EXPECT_EQ(recording.Ints("passed").back(), 0) << kind;
  }
}

/// A kinematic ball moves over a pinned node, whose depth is known.
TEST(RigidBesideSoft, DepthIsThatInTheMovedBody) {
  const plan::Run run = SoftRun(
      "cycles 100; timestep 0.01; acceleration 0; world { side 100; walls none } objects ball { "
      "quantity 1; type sphere; size 0.4; mass kinematic; location at(-2, 0, 0); linear_velocity "
      "(1, 0, 0) } objects rope { quantity 1; size 2; mass 2; margin 0.01; type rope(segments: 4); "
      "location at(0, 0, 0); overlap on; soft { pin left } } record stability, vertices");
  const protocol::Recording recording = RecordSoft(run);
  for (std::size_t cycle = 0; cycle < 100; ++cycle) {
    const double centre = -2 + 0.01 * static_cast<double>(cycle + 1);
    EXPECT_NEAR(recording.Reals("poses")[cycle * 14], centre, 10 * kRounding);
    const double depth = 0.2 + 0.01 - std::abs(-1 - centre);
    if (depth < 0.02) {
      EXPECT_EQ(recording.Ints("inside")[cycle], 0) << cycle;
    } else {
      EXPECT_GE(recording.Ints("inside")[cycle], depth > 0.021) << cycle;
      EXPECT_GE(recording.Reals("max_penetration")[cycle], depth - 100 * kRounding) << cycle;
    }
  }
  EXPECT_GE(recording.Ints("inside").back(), 1);
}

// The faces of an octahedron with half sides of 0.3 m are 0.3 / sqrt(3) m from its centre, where a
// rope is pinned. Bullet keeps another rope out of it.
TEST(RigidBesideSoft, SuperellipsoidsHoldNodesInsideThem) {
  const plan::Run run = SoftRun(
      "cycles 200; timestep 1/480; soft_cell 0.02; world { side 100; walls none } objects rigid { "
      "quantity 1; type superellipsoid; e1 2; e2 2; size 0.6; mass fixed; location at(-1, 0, 0); "
      "overlap on } objects rope { quantity 1; size 2; mass 2; margin 0.01; type rope(segments: "
      "4); location at(0, 0, 0); overlap on; soft { pin left } } objects falls { quantity 1; size "
      "1; mass 1; margin 0.02; type rope(segments: 30); location at(-1, 0.5, 0) }");
  const protocol::Recording recording = RecordSoft(run);
  EXPECT_EQ(recording.Ints("inside")[0], 1);
  EXPECT_NEAR(recording.Reals("max_penetration")[0], 0.3 / std::sqrt(3) + 0.01, 1e-5);
  EXPECT_GT(std::ranges::max(recording.Ints("contacts")), 0);
}

TEST(RigidBesideSoft, PosesAreThoseOfBodiesAndTheMiddleOfNodes) {
  const plan::Run run = SoftRun(
      "record vertices; cycles 30; timestep 1/240; " +
      Cloth("positions", "",
            "objects box { quantity 1; type cuboid; size 0.3; mass 1; location at(0, 0.25, 0); "
            "angular_velocity (1, 2, 3) }"));
  const protocol::Recording recording = RecordSoft(run);
  soft::SoftWorld world = MakeSoftWorld(run);
  for (int i = 0; i < 30; ++i) world.Step();
  const auto last = recording.Reals("poses").last(14);
  const objects::Pose pose = world::ExactPose(RigidAt(world));
  EXPECT_EQ(Vector3d(last[0], last[1], last[2]), pose.position);
  EXPECT_EQ(Eigen::Vector4d(last[3], last[4], last[5], last[6]), pose.orientation.coeffs());
  Vector3d middle = Vector3d::Zero();
  for (int i = 0; i < 121; ++i) middle += NodeAt(world, i) / 121;
  EXPECT_LT((Vector3d(last[7], last[8], last[9]) - middle).norm(), 1e-12);
}

TEST(RigidBesideSoft, EnergyAndMomentumHaveTheRigidBody) {
  const plan::Run run = SoftRun(
      "acceleration 0; timestep 1/240; " +
      Cloth("springs", "",
            "objects box { quantity 1; type cuboid; size 0.6; aspect 1 : 2 : 3; mass 2; location "
            "at(0, 5, 0); linear_velocity (1, 2, 2); angular_velocity (0, 0, 4) }"));
  const soft::SoftWorld world = MakeSoftWorld(run);
  // Sides of 0.6, 1.2 and 1.8 m.
  const double inertia = 2 * (0.6 * 0.6 + 1.2 * 1.2) / 12;
  EXPECT_NEAR(soft::EnergyOf(world).kinetic, 2 * 9.0 / 2 + inertia * 16 / 2, 1e-5);
  EXPECT_NEAR(soft::MomentumOf(world).parts, 6, 1e-5);
  EXPECT_NEAR(soft::SpinOf(RigidAt(world), world.ObjectOf(RigidAt(world))).z(), 4 * inertia, 1e-6);
}

TEST(RigidBesideSoft, IsTheSameToTheBit) {
  for (const char* kind : kWorlds) {
    plan::Run run = SoftRun(
        "cycles 100; timestep 1/2000; world { side 4; walls all; wall_shape box } soft_world " +
        std::string(kind) +
        "; objects ball { quantity 3; type sphere; size 0.5; mass 1 } objects spins { quantity 1; "
        "type cuboid; size 0.5; mass kinematic; angular_velocity (0, 3, 0) } objects cloth { "
        "quantity 1; type cloth(columns: 8, rows: 8); size 1; mass 1; margin 0.02 }");
    const std::string first = RecordSoft(run).header().state_hash.str();
    EXPECT_EQ(RecordSoft(run).header().state_hash.str(), first);
    run.scene.world.Set("record", schema::WordList{});
    EXPECT_EQ(RecordSoft(run).header().state_hash.str(), first);
  }
}

}  // namespace
}  // namespace cdb::tests
