#include "library/objects/surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "library/objects/distance.h"
#include "library/objects/solid_factory.h"
#include "library/objects/solid_pair.h"
#include "library/scene_error.h"
#include "tests/support/files.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using objects::Pose;
using objects::Solid;

/// A square of side 2 in the plane y = 0, as two triangles.
meshes::Mesh Square() {
  return {{{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}}, {{0, 2, 1}, {0, 3, 2}}};
}

/// A wavy height field over a grid of n by n cells.
meshes::Mesh Waves(std::uint32_t n) {
  meshes::Mesh mesh;
  for (std::uint32_t z = 0; z <= n; ++z)
    for (std::uint32_t x = 0; x <= n; ++x)
      mesh.vertices.emplace_back(x, std::sin(0.7 * x) * std::cos(0.5 * z), z);
  for (std::uint32_t z = 0; z < n; ++z)
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t a = z * (n + 1) + x, b = a + n + 1;
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({a + 1, b, b + 1});
    }
  return mesh;
}

Solid SurfaceOf(const meshes::Mesh& mesh, double size) {
  const auto form =
      std::make_shared<const objects::ConvexDecomposition>(objects::MakeSurface("test", mesh));
  Solid solid{objects::Shape::kCompound, size * form->proportions};
  solid.compound = std::make_shared<const objects::Compound>(form, solid.sides);
  return solid;
}

Pose At(const Vector3d& position) { return {position, Quaterniond::Identity()}; }

TEST(Surface, HasAPlaceAndSidesAndNoInside) {
  const Solid square = SurfaceOf(Square(), 10);
  EXPECT_TRUE(square.IsSurface());
  EXPECT_EQ(square.PieceCount(), 2u);
  EXPECT_EQ(square.Volume(), 0);
  EXPECT_EQ(square.InnerRadius(), 0);
  EXPECT_NEAR(square.OuterRadius(), 5 * std::sqrt(2.0), 1e-12);
  const objects::Box box = Bounds(square, Quaterniond::Identity());
  EXPECT_EQ(box.lower, Vector3d(-5, 0, -5));
  EXPECT_EQ(box.upper, Vector3d(5, 0, 5));
  const Solid ball{objects::Shape::kEllipsoid, {2, 2, 2}};
  for (const double y : {-1.01, -0.99, 0.5, 0.99, 1.01}) {
    EXPECT_EQ(Overlap(square, {}, ball, At({2, y, 3})), std::abs(y) < 1) << y;
    EXPECT_EQ(Overlap(ball, At({2, y, 3}), square, {}), std::abs(y) < 1) << y;
  }
  EXPECT_FALSE(Overlap(square, {}, ball, At({6.01, 0, 0})));
  EXPECT_FALSE(Overlap(square, {}, square, {}));
}

/// Compared with each triangle separately.
TEST(Surface, OverlapsWhatOneOfItsTrianglesOverlaps) {
  const Solid waves = SurfaceOf(Waves(12), 24);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-12, 12), height(-3, 3), turn(-1, 1);
  int overlaps = 0;
  for (int i = 0; i < 300; ++i) {
    const Solid other{i % 2 == 0 ? objects::Shape::kCuboid : objects::Shape::kCone, {1, 2, 0.7}};
    const auto random_turn = [&] {
      return Quaterniond(turn(random), turn(random), turn(random), turn(random)).normalized();
    };
    const Pose pose{{0.5, -0.2, 0.1}, random_turn()};
    const Pose at{
        pose.orientation * Vector3d(place(random), height(random), place(random)) + pose.position,
        random_turn()};
    const objects::SolidPair pair(waves, pose.orientation, other, at.orientation);
    bool expected = false;
    for (std::size_t triangle = 0; triangle < waves.PieceCount(); ++triangle)
      expected = expected || pair.PiecesOverlap(triangle, 0, at.position - pose.position);
    EXPECT_EQ(Overlap(waves, pose, other, at), expected) << i;
    overlaps += expected;
  }
  EXPECT_GT(overlaps, 50);
  EXPECT_LT(overlaps, 250);
}

TEST(Surface, IsCrossedOnce) {
  const Solid square = SurfaceOf(Square(), 10);
  const auto crosses = [&](const Vector3d& from, const Vector3d& to) {
    return Crosses(*square.compound, from, to);
  };
  EXPECT_TRUE(crosses({1, 1, 2}, {1, -1, 2}));
  EXPECT_TRUE(crosses({1, -1, 2}, {1.5, 1, 2}));
  EXPECT_TRUE(crosses({0, 1, 0}, {0, -1, 0})) << "on the edge of both";
  EXPECT_FALSE(crosses({1, 1, 2}, {1, 0.1, 2}));
  EXPECT_FALSE(crosses({6, 1, 2}, {6, -1, 2})) << "beside it";
  // In two steps, one of which ends on the surface.
  EXPECT_NE(crosses({1, 1, 2}, {1, 0, 2}), crosses({1, 0, 2}, {1, -1, 2}));
}

TEST(Surface, LeavesOutTrianglesWithoutArea) {
  meshes::Mesh mesh = Square();
  mesh.triangles.push_back({0, 1, 1});
  mesh.vertices.emplace_back(9, 9, 9);  // not part of a triangle
  EXPECT_EQ(objects::MakeSurface("m", mesh).pieces.size(), 2u);
  EXPECT_EQ(SurfaceOf(mesh, 10).OuterRadius(), SurfaceOf(Square(), 10).OuterRadius());
  mesh.triangles = {{0, 1, 1}};
  try {
    objects::MakeSurface("m", mesh);
    FAIL();
  } catch (const library::SceneError& error) {
    EXPECT_EQ(error.cause(), "m: its triangles have no area");
  }
  mesh.triangles.clear();
  try {
    objects::MakeSurface("m", mesh);
    FAIL();
  } catch (const library::SceneError& error) {
    EXPECT_STREQ(error.what(), "m: has no faces; hull takes its vertices");
  }
}

TEST(Surface, IsMadeOfOpenMeshesToo) {
  const TemporaryFolder folder;
  const std::string file = (folder / "square.obj").string();
  WriteFile(file, "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 4 3 2\n");
  const auto call = [&](const char* word) { return Layout(word, {{"file", schema::Text{file}}}); };
  objects::SolidFactory solids;
  const Solid solid = solids.Make(call("surface"), Vector3d::Constant(6), Vector3d::Ones());
  EXPECT_TRUE(solid.IsSurface());
  EXPECT_NEAR(solid.OuterRadius(), 3 * std::sqrt(2.0), 1e-12);
  EXPECT_EQ(objects::ModelsText(solids.Forms()), "surface(\"" + file + "\"): 2 triangles\n");
  EXPECT_THROW(solids.Make(call("mesh"), Vector3d::Ones(), Vector3d::Ones()), library::SceneError);
}

}  // namespace
}  // namespace cdb::tests
