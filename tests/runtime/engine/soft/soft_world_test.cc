// Soft bodies in motion, against closed forms.
#include "runtime/engine/soft/soft_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "tests/runtime/engine/soft/soft_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

constexpr double kEps = std::numeric_limits<btScalar>::epsilon();
constexpr double kG = 9.8;

/// `more`: of the rope.
std::string Rope(const std::string& world, const std::string& more, int segments = 20) {
  return "world { side 100; walls none } " + world +
         " objects { quantity 1; margin 0.01; mass 2; type rope(segments: " +
         std::to_string(segments) + "); " + more + " }";
}

// Each step adds g dt to the velocity and moves by the new one: after n steps the rope fell by
// g dt^2 n (n + 1) / 2.
TEST(SoftWorld, FallsFreely) {
  for (const char* kind : {"positions", "springs"}) {
    for (const std::string type : {"rope(segments: 20)", "cloth(columns: 8, rows: 5)",
                                   "block(columns: 3, rows: 2, layers: 2)"}) {
      const bool is_block = type.starts_with("block");
      if (is_block && std::string(kind) == "positions") continue;
      const plan::Run run = SoftRun(
          "world { side 100; walls none } timestep 0.01; soft_world " + std::string(kind) +
          "; objects { quantity 1; size 2; mass 3; margin 0.01; location at(0, 4, 0); type " +
          type + "; linear_velocity (1, 0, -0.5)" +
          (is_block                         ? "; soft { young_modulus 10 }"
           : std::string(kind) == "springs" ? "; soft { stiffness 10 }"
                                            : "") +
          " }");
      soft::SoftWorld world = MakeSoftWorld(run);
      std::vector<Vector3d> start;
      const int count = world.bodies()[0].body->m_nodes.size();
      for (int i = 0; i < count; ++i) start.push_back(NodeAt(world, i));
      constexpr int kSteps = 100;
      // Bullet's world of positions rounds the time step to single precision, in double, too.
      const double dt = std::string(kind) == "positions" ? double{0.01f} : 0.01;
      for (int i = 0; i < kSteps; ++i) world.Step();
      const Vector3d velocity(1, -kG * dt * kSteps, -0.5);
      const Vector3d moved(dt * kSteps, -kG * dt * dt * kSteps * (kSteps + 1) / 2,
                           -0.5 * dt * kSteps);
      // A velocity is a difference of positions of up to 4 m over dt: its error is 4 kEps / dt a
      // step. In n steps, those of a place add up to n^2 / 2 times 4 kEps.
      for (int i = 0; i < count; ++i) {
        EXPECT_NEAR((NodeAt(world, i) - start[static_cast<std::size_t>(i)] - moved).norm(), 0,
                    kSteps * 200 * kEps)
            << kind << " " << type;
        EXPECT_NEAR((NodeVelocity(world, i) - velocity).norm(), 0, kSteps * 400 * kEps);
      }
    }
  }
}

TEST(SoftWorld, SharesItsMassAmongItsNodes) {
  const soft::SoftWorld rope = MakeSoftWorld(SoftRun(Rope("", "size 2", 4)));
  EXPECT_EQ(rope.bodies()[0].masses, (std::vector<double>{0.25, 0.5, 0.5, 0.5, 0.25}));
  const soft::SoftWorld cloth = MakeSoftWorld(
      SoftRun("world { side 100; walls none } objects { quantity 1; size 2; mass 3; margin 0.01; "
              "type cloth(columns: 6, rows: 4); soft { pin back } }"));
  double moving = 0, whole = 0;
  const soft::SoftObject& one = cloth.bodies()[0];
  for (std::size_t i = 0; i < one.masses.size(); ++i) {
    moving += one.masses[i];
    EXPECT_EQ(one.masses[i] == 0, i < 7);
    whole += one.body->m_nodes[static_cast<int>(i)].m_im == 0
                 ? 0
                 : 1 / static_cast<double>(one.body->m_nodes[static_cast<int>(i)].m_im);
  }
  EXPECT_NEAR(whole, moving, 100 * kEps);
  // Of four rows of rectangles, the pins hold half of the first.
  EXPECT_NEAR(moving, 3 * 3.5 / 4, 1e-12);
}

// A hanging rope of n links of stiffness k and mass m is longer by the sum of the tensions over k,
// m g n / (2 k): that of a continuous one, m g L / (2 E A).
TEST(SoftWorld, HangingRopeStretchesByItsWeight) {
  for (const int segments : {5, 20}) {
    const plan::Run run =
        SoftRun(Rope("soft_world springs; timestep 0.0005;",
                     "size 2; location at(0, 0, 0); orientation (0, 0, 1.5707963267948966); "
                     "soft { pin right; stiffness 4000; damping 100 }",
                     segments));
    soft::SoftWorld world = MakeSoftWorld(run);
    for (int i = 0; i < 16000; ++i) world.Step();
    const double length = (NodeAt(world, segments) - NodeAt(world, 0)).norm();
    EXPECT_NEAR(length - 2, 2 * kG * segments / (2 * 4000.0), 1e-4) << segments;
    EXPECT_NEAR(NodeAt(world, segments).y(), 1, 10 * kEps);  // it is pinned
  }
}

// The first mode of a hanging rope has the period 4 pi / j0 sqrt(L / g), j0 = 2.4048 the first zero
// of the Bessel function J0. A chain of n links has nearly the same.
TEST(SoftWorld, HangingRopeSwingsWithThePeriodOfItsFirstMode) {
  constexpr double kZero = 2.404825557695773;
  // A small angle; the mode is near the straight line, as other modes swing faster.
  const plan::Run run =
      SoftRun(Rope("timestep 0.001; solver.iterations 100;",
                   "size 2; location at(0, 0, 0); orientation (0, 0, 1.5507963267948966); "
                   "soft { pin right }",
                   20));
  soft::SoftWorld world = MakeSoftWorld(run);
  // The first mode weighs nodes by its shape: J0(j0 sqrt(s)), s the height of a node over L.
  const auto deflection = [&] {
    double sum = 0;
    for (int i = 0; i <= 20; ++i)
      sum += world.bodies()[0].masses[static_cast<std::size_t>(i)] *
             std::cyl_bessel_j(0, kZero * std::sqrt(i / 20.0)) *
             (NodeAt(world, i).x() - NodeAt(world, 20).x());
    return sum;
  };
  std::vector<double> zeros;
  double last = deflection();
  for (int i = 1; i < 9000; ++i) {
    world.Step();
    const double now = deflection();
    if ((now < 0) != (last < 0)) zeros.push_back(0.001 * (i - now / (now - last)));
    last = now;
  }
  ASSERT_GE(zeros.size(), 5u);
  const double period = 2 * (zeros.back() - zeros.front()) / static_cast<double>(zeros.size() - 1);
  EXPECT_NEAR(period, 4 * std::numbers::pi / kZero * std::sqrt(2 / kG), 0.02 * period);
}

// A rope of length L held at two points d apart hangs as a catenary: y = a cosh(x / a), where
// 2 a sinh(d / (2 a)) = L.
TEST(SoftWorld, RopeBetweenTwoPointsHangsAsACatenary) {
  // A rope that is compressed at the start by links that have less than their length would need
  // another shape: it hangs from one end, and its other end is pinned where it is let go.
  const plan::Run run = SoftRun(Rope("timestep 0.002; solver.iterations 400;",
                                     "size 2; location at(0, 0, 0); linear_damping 0.5; "
                                     "soft { pin ends }",
                                     40));
  soft::SoftWorld world = MakeSoftWorld(run);
  // The pinned ends are moved together, slowly.
  btSoftBody& body = *world.bodies()[0].body;
  constexpr int kMoving = 2000;
  for (int i = 0; i < 6000; ++i) {
    if (i < kMoving) {
      body.m_nodes[0].m_x.setX(btScalar(-1 + 0.4 * (i + 1) / kMoving));
      body.m_nodes[40].m_x.setX(btScalar(1 - 0.4 * (i + 1) / kMoving));
    }
    world.Step();
  }
  double low = 0.01, high = 10;
  for (int i = 0; i < 100; ++i) {
    const double a = (low + high) / 2;
    (2 * a * std::sinh(0.6 / a) > 2 ? low : high) = a;
  }
  const double a = low, top = NodeAt(world, 0).y();
  for (int i = 0; i <= 40; ++i) {
    const Vector3d node = NodeAt(world, i);
    const double height = top + a * (std::cosh(node.x() / a) - std::cosh(0.6 / a));
    EXPECT_NEAR(node.y(), height, 0.01) << i;
  }
}

TEST(SoftWorld, KeepsItsMomentumWithoutGravity) {
  for (const char* kind : {"positions", "springs"}) {
    const plan::Run run = SoftRun(
        "world { side 100; walls none } acceleration 0; timestep 0.002; soft_world " +
        std::string(kind) +
        "; objects { quantity 1; size 2; mass 3; margin 0.01; location at(0, 0, 0); type "
        "cloth(columns: 6, rows: 6); linear_velocity (1, 2, 3); angular_velocity (2, 1, 0) }");
    soft::SoftWorld world = MakeSoftWorld(run);
    const Vector3d before = soft::MomentumOf(world).sum;
    EXPECT_NEAR((before - 3 * Vector3d(1, 2, 3)).norm(), 0, 100 * kEps);
    const Vector3d start = NodeAt(world, 0) - NodeAt(world, 48);
    for (int i = 0; i < 500; ++i) world.Step();
    // Positions of 4 m have errors of 4 kEps: in a step, each changes a velocity by that over the
    // time step.
    const double step = 3 * 4 * kEps / 0.002;
    EXPECT_NEAR((soft::MomentumOf(world).sum - before).norm(), 0, 2 * std::sqrt(500.0) * step)
        << kind;
    // It turned.
    EXPECT_GT((NodeAt(world, 0) - NodeAt(world, 48) - start).norm(), 0.5) << kind;
  }
}

TEST(SoftWorld, RestsOnFixedBodiesAndWallsAtItsMargin) {
  for (const char* kind : {"positions", "springs; timestep 1/2000"}) {
    const plan::Run run = SoftRun(
        "world { side 4; walls floor; wall_shape box } soft_world " + std::string(kind) +
        "; soft_cell 0.05; objects cloth { quantity 1; type cloth(columns: 6, rows: 6); size 1; "
        "mass 1; margin 0.05; location at(0, -1.9, 0) }");
    soft::SoftWorld world = MakeSoftWorld(run);
    const double timestep = run.scene.world.Real("timestep");
    for (int i = 0; i < 3 / timestep; ++i) world.Step();
    for (int i = 0; i < 49; ++i) EXPECT_NEAR(NodeAt(world, i).y(), -2 + 0.05, 0.01) << kind;
    EXPECT_GE(world.ContactCount(), 49u);
  }
}

TEST(SoftWorld, FrictionHoldsAClothOnASlope) {
  const auto slipped = [](const char* friction) {
    const plan::Run run = SoftRun(
        std::string("acceleration (3, -9, 0); world { side 10; walls floor; wall_shape box; "
                    "wall_friction 1 } soft_cell 0.05; objects cloth { quantity 1; type "
                    "cloth(columns: 4, rows: 4); size 1; mass 1; margin 0.05; location at(0, "
                    "-4.94, 0); friction ") +
        friction + " }");
    soft::SoftWorld world = MakeSoftWorld(run);
    const double start = NodeAt(world, 12).x();
    for (int i = 0; i < 60; ++i) world.Step();
    return NodeAt(world, 12).x() - start;
  };
  EXPECT_GT(slipped("0"), 1.4);  // 3 t^2 / 2
  EXPECT_LT(slipped("0.9"), 0.1);
}

TEST(SoftWorld, IsTheSameToTheBit) {
  for (const char* kind : {"positions", "springs; timestep 1/2000"}) {
    const plan::Run run = SoftRun(
        "cycles 100; world { side 4; walls all; wall_shape box } soft_world " + std::string(kind) +
        "; objects ball { quantity 3; type sphere; size 0.5; mass fixed } objects cloth { quantity "
        "2; type cloth(columns: 8, rows: 8); size 1; mass 1; margin 0.02 }");
    const protocol::Recording first = RecordSoft(run), second = RecordSoft(run);
    EXPECT_EQ(first.header().state_hash.str(), second.header().state_hash.str());
    EXPECT_EQ(first.header().state_hash.str().size(), 16u);
    plan::Run quiet = run;
    quiet.scene.world.Set("record", schema::WordList{});
    EXPECT_EQ(RecordSoft(quiet).header().state_hash.str(), first.header().state_hash.str());
  }
}

}  // namespace
}  // namespace cdb::tests
