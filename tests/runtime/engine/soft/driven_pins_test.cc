// Pins that move, against closed forms of elasticity.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

#include "compiler/analysis/expectation.h"
#include "runtime/protocol/verdict.h"
#include "tests/runtime/engine/soft/soft_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

std::string Scene(const std::string& world, const std::string& objects) {
  return fmt::format(
      "world {{ side 100; walls none }} {}; objects {{ quantity 1; margin 0.001; location "
      "at(1, 2, 3); {} }}",
      world, objects);
}

TEST(DrivenPins, FollowTheirMotionInBothWorlds) {
  struct Case {
    const char *world, *objects;
  };
  constexpr Case kCases[] = {
      {"soft_world positions", "type rope(segments: 8); size 1; soft { pin left; "},
      {"soft_world springs", "type rope(segments: 8); size 1; soft { stiffness 100; "},
      {"soft_world positions", "type cloth(columns: 4, rows: 3); size 1; soft { pin left; "},
      {"soft_world springs",
       "type cloth(columns: 4, rows: 3); size 1; soft { pin left; stiffness 100; "},
      {"soft_world springs",
       "type block(columns: 4, rows: 2, layers: 2); size 1; mass 100; soft { pin left; "}};
  for (const Case& one : kCases) {
    const plan::Run run = SoftRun(Scene(
        std::string(one.world) + "; timestep 0.001; cycles 300",
        std::string(one.objects) +
            "drive { pin right; linear_velocity (0.2, 0.1, 0); angular_velocity (1, 2, 0.5) } }"));
    soft::SoftWorld world = MakeSoftWorld(run);
    const soft::SoftObject& body = world.bodies()[0];
    std::vector<Vector3d> start;
    for (std::size_t i = 0; i < body.masses.size(); ++i)
      start.push_back(NodeAt(world, static_cast<int>(i)));
    const std::vector<std::uint32_t>& nodes = body.drive.nodes;
    ASSERT_FALSE(nodes.empty());
    Vector3d centre = Vector3d::Zero();
    for (const std::uint32_t node : nodes)
      centre += start[node] / static_cast<double>(nodes.size());
    for (int i = 0; i < 300; ++i) world.Step();
    const Eigen::AngleAxisd turn(0.3 * Vector3d(1, 2, 0.5).norm(),
                                 Vector3d(1, 2, 0.5).normalized());
    for (const std::uint32_t node : nodes) {
      const Vector3d expected =
          centre + 0.3 * Vector3d(0.2, 0.1, 0) + turn * (start[node] - centre);
      EXPECT_LT((NodeAt(world, static_cast<int>(node)) - expected).norm(), kIsDouble ? 1e-9 : 1e-5)
          << one.world << " " << one.objects;
    }
    for (const std::uint32_t node : analysis::PinnedNodes(run.scene.groups[0], body.mesh))
      EXPECT_LT((NodeAt(world, static_cast<int>(node)) - start[node]).norm(),
                kIsDouble ? 1e-12 : 1e-6);
    // Their work is no gain of the solver.
    EXPECT_THAT(analysis::DriverText(run.scene), HasSubstr("pins move the nodes of group"));
    EXPECT_NE(protocol::Judge(run.scene, RecordSoft(run), 300).criterion, "energy") << one.objects;
  }
}

/// A bar of 0.4 m x 0.1 m x 0.1 m with E = 1 MPa, whose right end moves for `seconds`.
double StrainEnergy(int across, double poisson, const std::string& velocity, int steps) {
  const plan::Run run = SoftRun(
      Scene("soft_world springs; timestep 0.001; acceleration 0; cycles " + std::to_string(steps),
            fmt::format(
                "type block(columns: {}, rows: {}, layers: {}); size 0.4; aspect 1 : 0.25 : 0.25; "
                "mass 4; soft {{ pin left; material corotated; young_modulus 1e5; poisson_ratio "
                "{}; drive {{ pin right; {} }} }}",
                4 * across, across, across, poisson, velocity)));
  soft::SoftWorld world = MakeSoftWorld(run);
  for (int i = 0; i < steps; ++i) world.Step();
  return soft::EnergyOf(world).springs.plain;
}

// E A d^2 / (2 L), without lateral contraction, slowly: 40 periods of the first mode.
TEST(DrivenPins, AStretchedBarHasTheEnergyOfASpring) {
  const double way = 0.004;
  const double energy = StrainEnergy(1, 0, "linear_velocity (0.002, 0, 0)", 2000);
  EXPECT_NEAR(energy / (1e5 * 0.01 * way * way / (2 * 0.4)), 1, 0.03);
}

// Saint-Venant: U = G J theta^2 / (2 L), J = 0.1406 a^4. Clamped ends cannot warp, which makes a
// bar of this length a little stiffer, and coarse meshes are stiffer by far.
TEST(DrivenPins, ATwistedBarConvergesToSaintVenant) {
  const double angle = 0.2, shear = 1e5 / 2.6;
  const double expected = shear * 0.1406 * 1e-4 * angle * angle / (2 * 0.4);
  std::vector<double> errors;
  for (const int across : {1, 2, 4})
    errors.push_back(StrainEnergy(across, 0.3, "angular_velocity (0.2, 0, 0)", 1000) / expected -
                     1);
  // Of order 1.8: the limit is within 0.02 of the closed form.
  EXPECT_NEAR(errors[0] / errors[1], 3.45, 0.2);
  EXPECT_NEAR(errors[1] / errors[2], 3.45, 0.2);
  EXPECT_NEAR(errors[2], 0.316, 0.02);
}

TEST(DrivenPins, RefusesWhatMovesNothing) {
  const auto said = [](const std::string& soft) {
    return dsl::Render(
        CompileText("benchmark b { world { side 10; wall_shape box } soft_world springs; objects { "
                    "quantity 1; size 1; type rope(segments: 3); soft { " +
                    soft + " } } }")
            .diagnostics);
  };
  EXPECT_THAT(said("drive { pin right }"), HasSubstr("these nodes have no velocity"));
  EXPECT_THAT(said("drive { linear_velocity (1, 0, 0) }"), HasSubstr("moves no nodes"));
  EXPECT_THAT(said("pin right; drive { pin right; linear_velocity (1, 0, 0) }"),
              HasSubstr("the nodes of 'right' cannot both stay and move"));
  EXPECT_THAT(said("drive { pin top; linear_velocity (1, 0, 0) }"),
              HasSubstr("a rope has no 'top'"));
  EXPECT_EQ(said("pin left; drive { pin right; linear_velocity (1, 0, 0) }").find("error"),
            std::string::npos);
}

TEST(DrivenPins, RefusesDrivesWhoseNodesAllStay) {
  const plan::Run run = SoftRun(
      Scene("soft_world springs",
            "type rope(segments: 3); size 1; soft { pin ends; drive { pin right; linear_velocity "
            "(1, 0, 0) } }"));
  try {
    MakeSoftWorld(run);
    FAIL();
  } catch (const library::SceneError& error) {
    EXPECT_THAT(error.what(), HasSubstr("soft.drive.pin moves no nodes"));
  }
}

}  // namespace
}  // namespace cdb::tests
