#include "compiler/analysis/soft.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <set>

#include "compiler/analysis/coverage.h"
#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

schema::Value Cloth(std::uint64_t columns, std::uint64_t rows) {
  return schema::Call{"cloth", {schema::Number(columns), schema::Number(rows)}};
}

TEST(SoftMesh, RopeIsAChain) {
  const analysis::SoftMesh mesh =
      analysis::MeshOf(schema::Call{"rope", {schema::Number(std::uint64_t{3})}});
  EXPECT_EQ(mesh.NodeCount(), 4u);
  EXPECT_TRUE(mesh.triangles.empty());
  EXPECT_THAT(mesh.links, ElementsAre(std::array{0u, 1u}, std::array{1u, 2u}, std::array{2u, 3u}));
  EXPECT_EQ(mesh.PlaceOf(3), Eigen::Vector3d(1, 0.5, 0.5));
}

// Euler: nodes - links + triangles = 1 for a disc, each link of which has one or two triangles.
TEST(SoftMesh, ClothIsADisc) {
  const analysis::SoftMesh mesh = analysis::MeshOf(Cloth(7, 4));
  EXPECT_EQ(mesh.NodeCount(), 40u);
  EXPECT_EQ(mesh.triangles.size(), 2u * 7 * 4);
  EXPECT_EQ(mesh.NodeCount() + mesh.triangles.size(), mesh.links.size() + 1);
  std::set<std::set<std::uint32_t>> links;
  for (const auto& [a, b] : mesh.links) EXPECT_TRUE(links.insert({a, b}).second);
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    for (const auto& link : {std::set{a, b}, std::set{b, c}, std::set{c, a}})
      EXPECT_TRUE(links.contains(link));
    const auto at = [&](std::uint32_t node) {
      const Eigen::Vector3d place = mesh.PlaceOf(node);
      return Eigen::Vector2d(place.x(), place.z());
    };
    const Eigen::Vector2d ab = at(b) - at(a), ac = at(c) - at(a);
    const double twice = ab.x() * ac.y() - ab.y() * ac.x();
    EXPECT_LT(twice, 0);  // all have the same orientation
    area -= twice / 2;
  }
  EXPECT_NEAR(area, 1, 1e-12);
}

// The tetrahedra fill the box: each triangle belongs to two of them, or to one and the surface,
// which is a sphere: nodes - links + triangles = 2.
TEST(SoftMesh, BlockIsABall) {
  const analysis::SoftMesh mesh = analysis::BlockOf(4, 3, 2);
  EXPECT_EQ(mesh.NodeCount(), 60u);
  ASSERT_EQ(mesh.tetrahedra.size(), 5u * 24);
  const Eigen::Vector3d sides(4, 2, 3);  // cubes
  const auto at = [&](std::uint32_t node) {
    return Eigen::Vector3d(mesh.PlaceOf(node).cwiseProduct(sides));
  };
  std::set<std::set<std::uint32_t>> links;
  for (const auto& [a, b] : mesh.links) EXPECT_TRUE(links.insert({a, b}).second);
  double volume = 0;
  std::map<std::set<std::uint32_t>, int> faces;
  std::set<std::set<std::uint32_t>> edges;
  for (const auto& [a, b, c, d] : mesh.tetrahedra) {
    const double own = (at(b) - at(a)).cross(at(c) - at(a)).dot(at(d) - at(a)) / 6;
    EXPECT_TRUE(std::abs(own - 1.0 / 6) < 1e-12 || std::abs(own - 1.0 / 3) < 1e-12) << own;
    volume += own;
    for (const auto& face : {std::set{a, b, c}, {a, b, d}, {a, c, d}, {b, c, d}}) ++faces[face];
    for (const auto& edge : {std::set{a, b}, {a, c}, {a, d}, {b, c}, {b, d}, {c, d}})
      edges.insert(edge);
  }
  EXPECT_NEAR(volume, 24, 1e-9);
  EXPECT_EQ(edges, links);
  std::size_t once = 0;
  for (const auto& [face, count] : faces) {
    EXPECT_LE(count, 2);
    once += count == 1;
  }
  EXPECT_EQ(once, mesh.triangles.size());
  EXPECT_EQ(mesh.triangles.size(), 4u * (4 * 3 + 4 * 2 + 3 * 2));
  std::set<std::set<std::uint32_t>> around;
  std::set<std::uint32_t> outer;
  double enclosed = 0, area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    EXPECT_EQ((faces[{a, b, c}]), 1);
    enclosed += at(a).dot(at(b).cross(at(c))) / 6;
    area += (at(b) - at(a)).cross(at(c) - at(a)).norm() / 2;
    for (const auto& edge : {std::set{a, b}, {b, c}, {a, c}}) around.insert(edge);
    outer.insert({a, b, c});
  }
  EXPECT_NEAR(enclosed, 24, 1e-9) << "they face outwards";
  EXPECT_NEAR(area, 2 * (4 * 2 + 4 * 3 + 2 * 3), 1e-9);
  EXPECT_EQ(outer.size() + mesh.triangles.size(), around.size() + 2);
  const std::vector<double> shares = analysis::MassShares(mesh);
  double sum = 0;
  for (const double share : shares) sum += share;
  EXPECT_NEAR(sum, 1, 1e-12);
  // A node between cells is a corner of one tetrahedron, or of four, in each of eight cells.
  EXPECT_THAT(24 * 24 * shares[20 + 5 + 1],
              testing::AnyOf(testing::DoubleNear(8, 1e-9), testing::DoubleNear(40, 1e-9)));
}

compiler::Compilation Compiled(const std::string& statements) {
  return CompileText("benchmark b { " + statements + " }");
}

plan::Scene SceneOf(const std::string& statements) {
  const compiler::Compilation result = Compiled(statements);
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return result.plans.at(0).runs.at(0).scene;
}

constexpr const char* kWorld = "world { side 10; wall_shape box } ";

TEST(Soft, PinsAreNamedByTheSides) {
  const auto pinned = [](const std::string& type, const std::string& pins) {
    const plan::Scene scene =
        SceneOf(std::string(kWorld) + "soft_world springs; objects { quantity 1; size 1; type " +
                type + "; soft { pin " + pins + " } }");
    return analysis::PinnedNodes(scene.groups[0],
                                 analysis::LatticeOf(scene.groups[0].settings.Get("type")));
  };
  EXPECT_THAT(pinned("rope(segments: 5)", "none"), ElementsAre());
  EXPECT_THAT(pinned("rope(segments: 5)", "left"), ElementsAre(0));
  EXPECT_THAT(pinned("rope(segments: 5)", "right"), ElementsAre(5));
  EXPECT_THAT(pinned("rope(segments: 5)", "ends"), ElementsAre(0, 5));
  EXPECT_THAT(pinned("cloth(columns: 2, rows: 1)", "back"), ElementsAre(0, 1, 2));
  EXPECT_THAT(pinned("cloth(columns: 2, rows: 1)", "front"), ElementsAre(3, 4, 5));
  EXPECT_THAT(pinned("cloth(columns: 2, rows: 1)", "corners"), ElementsAre(0, 2, 3, 5));
  EXPECT_THAT(pinned("cloth(columns: 2, rows: 1)", "left, right"), ElementsAre(0, 2, 3, 5));
  const std::string block = "block(columns: 2, rows: 1, layers: 1)";
  EXPECT_THAT(pinned(block, "left"), ElementsAre(0, 3, 6, 9));
  EXPECT_THAT(pinned(block, "back"), ElementsAre(0, 1, 2, 6, 7, 8));
  EXPECT_THAT(pinned(block, "bottom"), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(pinned(block, "top"), ElementsAre(6, 7, 8, 9, 10, 11));
  EXPECT_THAT(pinned(block, "corners"), ElementsAre(0, 2, 3, 5, 6, 8, 9, 11));
}

TEST(Soft, NodesAreCounted) {
  EXPECT_EQ(analysis::NodeCount(SceneOf("objects { quantity 3 }")), 0u);
  EXPECT_EQ(analysis::NodeCount(SceneOf(
                std::string(kWorld) +
                "objects a { quantity 3; size 1; type rope(segments: 4) } objects b { quantity 2; "
                "size 1; type cloth(columns: 2, rows: 3) } objects c { quantity 1; mass fixed }")),
            3u * 5 + 2 * 12);
  EXPECT_EQ(analysis::NodeCount(SceneOf(std::string(kWorld) +
                                        "soft_world springs; objects { quantity 3; size 1; type "
                                        "block(columns: 4, rows: 3, layers: 2) }")),
            3u * 60);
}

TEST(Soft, RigidObjectsBesideThemMayMove) {
  const plan::Scene scene = SceneOf(
      std::string(kWorld) +
      "record vertices, poses; objects s { quantity 1; size 1; type rope(segments: 3) } objects "
      "balls { quantity 3; mass density(500); linear_velocity uniform(-1, 1); restitution 0.5 } "
      "objects ground { quantity 2; type cuboid; mass fixed } objects spins { quantity 4; mass "
      "kinematic; angular_velocity (0, 1, 0) }");
  EXPECT_EQ(analysis::FreeRigidCount(scene), 3u);
}

TEST(Soft, RefusesByNameWhatSoftBodiesCannotHave) {
  struct Case {
    const char *statements, *message;
  };
  constexpr Case kCases[] = {
      {"detector grid", "'grid' does not know soft bodies"},
      {"narrow_phase batch", "'batch' does not know soft bodies"},
      {"contact faithful", "'contact' has no meaning"},
      {"solver.erp 0.5", "'solver.erp' has no meaning"},
      {"solver.warm_start 0", "'solver.warm_start' has no meaning"},
      {"accuracy { metrics rotation }", "the error of 'rotation' cannot be measured"},
      {"accuracy { metrics energy, contacts }", "the error of 'contacts' cannot be measured"},
      {"accuracy { metrics energy; closed_form flight }", "'accuracy.closed_form' has no meaning"},
      {"accuracy { metrics energy; reference { contact faithful } }",
       "'accuracy.reference.contact' has no meaning"},
      {"accuracy { metrics energy; reference { detector grid } }",
       "'grid' does not know soft bodies"},
      {"expect rest", "whether soft bodies rest is not judged"},
      {"expect energy", "whether soft bodies keep their energy is not judged"},
      {"record boxes", "'boxes' cannot be recorded with soft bodies"},
      {"record contacts", "'contacts' cannot be recorded with soft bodies"},
      {"record pairs", "'pairs' cannot be recorded with soft bodies"},
      {"acceleration every(5, (0, -9, 0))", "schedules do not reach"},
      {"omit solver", "'solver' cannot be omitted"},
      {"queries { count 5 }", "queries do not know soft bodies"},
      {"objects ball { quantity 1; ccd on }", "'ccd' has no meaning for ball beside"},
      {"objects ball { quantity 1; force (1, 0, 0) }", "'force' has no meaning for ball"},
      {"objects ball { quantity 1; torque (1, 0, 0) }", "'torque' has no meaning for ball"},
      {"objects ball { quantity 2; links { type ball } }", "'links.type' has no meaning for ball"},
      {"objects ball { quantity 1; collides_with none }", "'collides_with' has no meaning for"},
      {"objects ball { quantity 1; contact_stiffness 10 }", "'contact_stiffness' has no meaning"},
      {"objects ball { quantity 1; location pile }", "a pile is settled without soft bodies"},
      {"objects ball { quantity 1; linear_velocity every(5, (0, 1, 0)) }",
       "schedules do not reach rigid bodies"},
      {"objects ball { quantity 1; type bunny }", "must be a convex closed form"},
      {"objects torus { quantity 1; mass fixed; type torus }", "must be a convex closed form"},
      {"objects ball { quantity 1; mass fixed; soft { pin left } }", "ball has none"},
      {"objects s { restitution 0.5 }", "'restitution' has no meaning"},
      {"objects s { rolling_friction 0.5 }", "'rolling_friction' has no meaning"},
      {"objects s { angular_damping 0.5 }", "'angular_damping' has no meaning"},
      {"objects s { ccd on }", "'ccd' has no meaning"},
      {"objects s { contact_stiffness 10 }", "'contact_stiffness' has no meaning"},
      {"objects s { links { type ball } }", "'links.type' has no meaning"},
      {"objects s { collides_with none }", "'collides_with' has no meaning"},
      {"objects s { e1 0.5 }", "'e1' has no meaning"},
      {"objects s { soft { young_modulus 2e5 } }", "is of the material of blocks"},
      {"objects s { soft { poisson_ratio 0.4 } }", "is of the material of blocks"},
      {"objects s { soft { material linear } }", "is of the material of blocks"},
      {"objects s { soft { stiffness_damping 0.1 } }", "is of the material of blocks"},
      {"objects s { soft { pin top } }", "a rope has no 'top'"},
      {"objects s { mass fixed }", "the mass of a soft body is a number"},
      {"objects s { mass uniform(1, 2) }", "the mass of a soft body is a number"},
      {"objects s { mass density(5) }", "the mass of a soft body is a number"},
      {"objects s { location pile }", "'pile' does not place soft bodies"},
      {"objects s { aspect 1 : 2 : 1 }", "as thick as two margins"},
      {"objects s { soft { pin back } }", "a rope has no 'back'"},
      {"objects s { linear_velocity every(5, (0, 1, 0)) }", "schedules do not reach"},
      {"objects s { soft { stiffness 10 } }", "'soft.stiffness' has a meaning only with"},
      {"objects s { soft { damping 10 } }", "'soft.damping' has a meaning only with"},
      {"soft_world springs; objects s { soft { correction 0.5 } }",
       "'soft.correction' has a meaning only with"},
      {"soft_world springs; objects s { linear_damping 0.5 }",
       "'linear_damping' has a meaning only with"},
      {"soft_world springs; objects s { soft { self_collision on } }", "ropes have no faces"},
  };
  const std::string base =
      std::string(kWorld) + "objects s { quantity 1; size 1; type rope(segments: 3) } ";
  ASSERT_FALSE(Compiled(base).diagnostics.has_errors()) << dsl::Render(Compiled(base).diagnostics);
  for (const Case& one : kCases) {
    const compiler::Compilation result = Compiled(base + one.statements);
    EXPECT_TRUE(result.diagnostics.has_errors()) << one.statements;
    EXPECT_THAT(dsl::Render(result.diagnostics), HasSubstr(one.message)) << one.statements;
  }
}

TEST(Soft, RefusesOtherTypesSizesAndPlanes) {
  struct Case {
    const char *statements, *message;
  };
  constexpr Case kCases[] = {
      {"objects { quantity 1; size 1; type rope(segments: 3) }", "prisms"},
      {"world.walls none; objects { quantity 1; type rope(segments: 3); size uniform(1, 2) }",
       "the size of a soft body is a number"},
      {"world.walls none; objects { quantity 1; size 1; type any(rope(segments: 3), sphere) }",
       "one type"},
  };
  for (const Case& one : kCases)
    EXPECT_THAT(dsl::Render(Compiled(one.statements).diagnostics), HasSubstr(one.message));
}

TEST(Soft, RefusesByNameWhatBlocksCannotHave) {
  struct Case {
    const char *world, *settings, *message;
  };
  constexpr Case kCases[] = {
      {"soft_world positions", "", "soft_world positions knows no material"},
      {"soft_world springs", "soft { stiffness 5 }", "'soft.stiffness' is of links"},
      {"soft_world springs", "soft { damping 5 }", "'soft.damping' is of links"},
      {"soft_world springs", "soft { self_collision on }",
       "the self-collision of blocks is not examined"},
      {"soft_world springs", "soft { material corotated; stiffness_damping 0.1 }",
       "corotated material has no damping"},
      {"soft_world springs", "soft { correction 0.5 }",
       "'soft.correction' has a meaning only with soft_world positions"},
      {"soft_world springs", "mass fixed", "the mass of a soft body is a number"},
      {"soft_world springs", "size uniform(1, 2)", "the size of a soft body is a number"},
      {"soft_world springs", "restitution 0.5", "'restitution' has no meaning"},
  };
  for (const Case& one : kCases) {
    const bool has_size = std::string_view(one.settings).starts_with("size");
    EXPECT_THAT(
        dsl::Render(
            Compiled(std::string(kWorld) + one.world +
                     "; objects { quantity 1; type block(columns: 2, rows: 2, layers: 2); " +
                     (has_size ? "" : "size 1; ") + one.settings + " }")
                .diagnostics),
        HasSubstr(one.message))
        << one.settings;
  }
  EXPECT_THAT(dsl::Render(Compiled(std::string(kWorld) +
                                   "objects { quantity 1; size 1; type cloth(columns: 2, rows: 2); "
                                   "soft { pin bottom } }")
                              .diagnostics),
              HasSubstr("a cloth has no 'bottom'"));
  EXPECT_THAT(
      dsl::Render(Compiled(std::string(kWorld) +
                           "soft_world springs; objects { quantity 1; size 1; type block(columns: "
                           "99, rows: 99, layers: 100) }")
                      .diagnostics),
      HasSubstr("the block has 1010000 nodes"));
  EXPECT_FALSE(Compiled(std::string(kWorld) +
                        "soft_world springs; objects { quantity 1; size 1; type block(columns: 2, "
                        "rows: 2, layers: 2); aspect 1 : 2 : 3; soft { pin bottom, corners; "
                        "young_modulus 1 MPa } }")
                   .diagnostics.has_errors());
}

/// As in scenes without soft bodies.
TEST(Soft, SettingsWithoutEffectOnRigidObjectsBesideThemWarn) {
  const auto said = [](const char* rigid) {
    return dsl::Render(Compiled(std::string(kWorld) +
                                "objects s { quantity 1; size 1; type rope(segments: 3) } objects "
                                "r { quantity 1; size 1; " +
                                rigid + " }")
                           .diagnostics);
  };
  EXPECT_THAT(said("e1 0.5"), HasSubstr("no-effect"));
  EXPECT_THAT(said("mass fixed; linear_velocity (1, 0, 0)"), HasSubstr("no-effect"));
  EXPECT_THAT(said("mass kinematic"), HasSubstr("no-effect"));
  EXPECT_THAT(said("spinning_friction 0.1"), HasSubstr("no-effect"));
  EXPECT_EQ(said("type superellipsoid; e1 0.5; linear_velocity (1, 0, 0)").find("no-effect"),
            std::string::npos);
}

TEST(Soft, RefusesTheirSettingsWithoutThem) {
  for (const char* statements :
       {"soft_world springs", "soft_cell 0.1", "record vertices", "objects { soft { pin ends } }",
        "objects { soft { stiffness 5 } }", "objects { soft { young_modulus 5 } }"}) {
    const compiler::Compilation result =
        Compiled(std::string("objects { quantity 1 } ") + statements);
    EXPECT_TRUE(result.diagnostics.has_errors()) << statements;
    EXPECT_THAT(dsl::Render(result.diagnostics), HasSubstr("soft bodies")) << statements;
  }
}

TEST(Soft, EveryOpenQuestionIsNamed) {
  const analysis::Coverage coverage = analysis::CoverageOf(
      SceneOf(std::string(kWorld) +
              "objects s { quantity 1; size 1; type rope(segments: 3) } objects ground { quantity "
              "2; type cuboid; mass fixed }"));
  EXPECT_EQ(analysis::CheckedText(coverage), "stretch");
  std::set<std::string_view> open;
  for (const analysis::Coverage::Open& one : coverage.unchecked) {
    open.insert(one.question->name);
    EXPECT_THAT(one.why, HasSubstr("soft bodies"));
  }
  EXPECT_EQ(open, (std::set<std::string_view>{"energy", "losses", "passing", "edges", "friction",
                                              "impacts"}));
  EXPECT_FALSE(analysis::IsChecked(
      analysis::Question::kStretch,
      SceneOf(std::string(kWorld) +
              "soft_world springs; objects { quantity 1; size 1; type rope(segments: 3) }")));
  // And in no other scene.
  EXPECT_FALSE(
      analysis::IsChecked(analysis::Question::kStretch, SceneOf("objects { quantity 1 }")));
}

}  // namespace
}  // namespace cdb::tests
