#include "library/meshes/decompose.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "library/meshes/mass_properties.h"
#include "library/meshes/primitives.h"
#include "library/meshes/topology.h"
#include "tests/library/meshes/test_meshes.h"

namespace cdb::tests {
namespace {

using namespace testing;
using Eigen::Vector3d;

void ExpectWellFormed(const meshes::Decomposition& pieces, const meshes::Mesh& mesh) {
  for (const meshes::Hull& hull : pieces.hulls)
    EXPECT_GE(meshes::SignedVolume(meshes::Watertight(meshes::SurfaceOf(hull), "hull")),
              meshes::DecomposeOptions().least_volume * meshes::SignedVolume(mesh));
}

/// A polygon, counter-clockwise and star-shaped about its first corner, between z = 0 and z =
/// height.
meshes::Mesh PrismMesh(const std::vector<std::array<double, 2>>& corners, double height) {
  meshes::Mesh mesh;
  const auto count = static_cast<std::uint32_t>(corners.size());
  for (const double z : {0.0, height})
    for (const auto& [x, y] : corners) mesh.vertices.emplace_back(x, y, z);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t k = (i + 1) % count;
    if (i > 0 && k > 0) {
      mesh.triangles.push_back({count, count + i, count + k});
      mesh.triangles.push_back({0, k, i});
    }
    mesh.triangles.push_back({i, k, k + count});
    mesh.triangles.push_back({i, k + count, i + count});
  }
  return mesh;
}

/// 1 x 1 x 0.2, open above, with walls and a floor of this thickness.
meshes::Mesh TrayMesh(double wall) {
  meshes::Mesh mesh;
  const double far = 1 - wall, top = 0.2;
  mesh.vertices = {{0, 0, 0},          {1, 0, 0},         {1, 1, 0},        {0, 1, 0},
                   {0, 0, top},        {1, 0, top},       {1, 1, top},      {0, 1, top},
                   {wall, wall, top},  {far, wall, top},  {far, far, top},  {wall, far, top},
                   {wall, wall, wall}, {far, wall, wall}, {far, far, wall}, {wall, far, wall}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {12, 13, 14}, {12, 14, 15}};
  for (std::uint32_t i = 0; i < 4; ++i)
    for (const std::uint32_t low : {0u, 4u, 8u}) {
      const std::uint32_t k = low + (i + 1) % 4;
      mesh.triangles.push_back({low + i, k, k + 4});
      mesh.triangles.push_back({low + i, k + 4, low + i + 4});
    }
  return mesh;
}

TEST(Decompose, AConvexMeshIsOneHull) {
  const meshes::Mesh box = BoxMesh({-1, -2, -3}, {1, 2, 3});
  const meshes::Decomposition one = meshes::Decompose(box, "m");
  ASSERT_EQ(one.hulls.size(), 1u);
  EXPECT_EQ(one.hulls[0].vertices, box.vertices);
  EXPECT_NEAR(one.iou, 1, 1e-12);
  EXPECT_NEAR(one.volume_error, 0, 1e-12);
  const meshes::Decomposition round = meshes::Decompose(SphereMesh(1, 4), "m");
  ASSERT_EQ(round.hulls.size(), 1u);
  EXPECT_LE(round.hulls[0].vertices.size(), 256u);
  EXPECT_GT(round.iou, 0.97);
}

TEST(Decompose, SimpleSolidsAreExact) {
  struct KnownSolid {
    std::string name;
    meshes::Mesh mesh;
    double volume;
    std::size_t hulls;
  };
  std::vector<std::array<double, 2>> star;
  for (int i = 0; i < 10; ++i) {
    const double r = i % 2 == 0 ? 0.4 : 1, angle = std::numbers::pi * i / 5;
    star.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  meshes::Mesh comb = BoxMesh({0, 0, 0}, {10, 1, 1});
  for (int i = 0; i < 10; ++i) comb = Joined(comb, BoxMesh({i + 0.2, 0.5, 0.1}, {i + 0.8, 5, 0.9}));
  const meshes::Mesh ball = SphereMesh(1, 3);
  const double star_volume = 10 * 0.4 * std::sin(std::numbers::pi / 5) / 2;
  const KnownSolid solids[] = {
      {"angle", AngleMesh(), 3, 2},
      {"tray", TrayMesh(0.03), 0.2 - 0.94 * 0.94 * 0.17, 5},
      {"thin tray", TrayMesh(0.005), 0.2 - 0.99 * 0.99 * 0.195, 5},
      {"star", PrismMesh(star, 1), star_volume, 6},
      {"crossed boxes",
       Joined(BoxMesh({-2, -0.5, -0.5}, {2, 0.5, 0.5}), BoxMesh({-0.5, -2, -0.5}, {0.5, 2, 0.5})),
       7, 3},
      {"comb", comb, 10 + 10 * 0.6 * 4 * 0.8, 11},
      {"ball in a shell",
       Joined(Joined(BoxMesh({0, 0, 0}, {4, 4, 4}), InsideOut(BoxMesh({1, 1, 1}, {3, 3, 3}))),
              BoxMesh({1.5, 1.5, 1.5}, {2.5, 2.5, 2.5})),
       57, 7}};
  for (const KnownSolid& c : solids) {
    SCOPED_TRACE(c.name);
    const meshes::Mesh mesh = meshes::Watertight(c.mesh, c.name);
    const meshes::Decomposition pieces = meshes::Decompose(mesh, c.name);
    ExpectWellFormed(pieces, mesh);
    EXPECT_LE(pieces.hulls.size(), c.hulls);
    double volume = 0;
    for (const meshes::Hull& hull : pieces.hulls)
      volume += meshes::SignedVolume(meshes::SurfaceOf(hull));
    EXPECT_NEAR(volume / c.volume, 1, 0.02);
    EXPECT_GT(pieces.iou, 0.98);
    EXPECT_LT(pieces.hull_overlap, 0.01);
  }
}

TEST(Decompose, RoundSolidsAreWithinTheError) {
  const meshes::Mesh ring = meshes::TorusMesh(2, 0.6, 40, 20);
  const meshes::Decomposition first = meshes::Decompose(ring, "m");
  ExpectWellFormed(first, ring);
  EXPECT_LE(first.hulls.size(), 20u);
  EXPECT_GT(first.iou, 0.94);
  EXPECT_LT(first.volume_error, 0.04);
  EXPECT_LT(first.hull_overlap, 0.01);
  // The same bytes each time.
  EXPECT_EQ(meshes::Decompose(ring, "m"), first);
  const meshes::Mesh hollow = Joined(SphereMesh(1, 3), InsideOut(SphereMesh(0.7, 3)));
  const meshes::Decomposition shell = meshes::Decompose(hollow, "m");
  EXPECT_LE(shell.hulls.size(), meshes::DecomposeOptions().hulls);
  EXPECT_GT(shell.iou, 0.85);
}

TEST(Decompose, OptionsBoundHullsAndError) {
  const meshes::Mesh ring = meshes::TorusMesh(2, 0.6, 40, 20);
  const meshes::Decomposition few = meshes::Decompose(ring, "m", {.hulls = 4});
  EXPECT_LE(few.hulls.size(), 4u);
  const meshes::Decomposition fine = meshes::Decompose(ring, "m", {.error = 0.01});
  EXPECT_GT(fine.iou, few.iou);
  // No more than one hull is needed for an error of all of its volume.
  EXPECT_EQ(meshes::Decompose(ring, "m", {.error = 2}).hulls.size(), 1u);
}

TEST(Decompose, RefusesMeshesThatTakeTooLong) {
  meshes::DecomposeOptions options;
  options.most_triangles = 19;
  EXPECT_EQ(
      Refusal([&] { meshes::Decompose(AngleMesh(), "m", options); }),
      "m: has 20 triangles, and decomposing more than 19 takes longer than a minute; simplify "
      "it, or use its convex hull");
  options.most_triangles = 20;
  EXPECT_EQ(meshes::Decompose(AngleMesh(), "m", options).hulls.size(), 2u);
}

TEST(Decompose, DoesNotDependOnSizeBeyondRounding) {
  // Powers of two, so that there is no rounding error.
  const meshes::Mesh angle = AngleMesh();
  const meshes::Decomposition pieces = meshes::Decompose(angle, "m");
  const meshes::Decomposition large =
      meshes::Decompose(Moved(angle, 1024 * Eigen::Matrix3d::Identity(), Vector3d::Zero()), "m");
  ASSERT_EQ(large.hulls.size(), pieces.hulls.size());
  EXPECT_NEAR(large.iou, pieces.iou, 1e-9);
}

/// An OBJ file with each mesh as a group; faces of all groups share the list of vertices.
std::string ToGroups(const std::vector<meshes::Mesh>& parts) {
  std::string text;
  std::size_t base = 1;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    text += fmt::format("{} part{}\n", i % 2 == 0 ? "o" : "g", i);
    for (const Vector3d& v : parts[i].vertices)
      text += fmt::format("v {:.17g} {:.17g} {:.17g}\n", v.x(), v.y(), v.z());
    for (const meshes::Triangle& t : parts[i].triangles)
      text += fmt::format("f {} {} {}\n", base + t[0], base + t[1], base + t[2]);
    base += parts[i].vertices.size();
  }
  return text;
}

TEST(JoinConvexParts, TakesTheGroupsOfAnObjFileAsTheyAre) {
  const std::vector<meshes::Mesh> boxes = {
      BoxMesh({0, 0, 0}, {1, 1, 1}), BoxMesh({1, 0, 0}, {3, 1, 1}), BoxMesh({0, 1, 0}, {1, 4, 1})};
  const std::vector<meshes::Mesh> parts = meshes::ParseParts(ToGroups(boxes), "m.obj", 3);
  EXPECT_EQ(parts, boxes);
  std::vector<meshes::Hull> hulls;
  const meshes::Mesh mesh = meshes::JoinConvexParts(parts, "m", hulls);
  ASSERT_EQ(hulls.size(), 3u);
  const meshes::Decomposition pieces = meshes::Assessed(hulls, mesh);
  EXPECT_NEAR(pieces.iou, 1, 1e-9);
  EXPECT_NEAR(meshes::SignedVolume(mesh), 6, 1e-12);
  EXPECT_EQ(Refusal([&] { meshes::ParseParts(ToGroups(boxes), "m.obj", 2); }),
            "m.obj: has 3 parts; at most 2 can be taken as they are");
}

TEST(JoinConvexParts, TakesConnectedPartsOfOtherFiles) {
  const meshes::Mesh two = Joined(BoxMesh({0, 0, 0}, {1, 1, 1}), BoxMesh({2, 0, 0}, {3, 1, 1}));
  const auto parts = meshes::ParseParts(ToStl(two), "m.stl", 10);
  ASSERT_EQ(parts.size(), 2u);
  std::vector<meshes::Hull> hulls;
  EXPECT_NEAR(meshes::SignedVolume(meshes::JoinConvexParts(parts, "m", hulls)), 2, 1e-12);
}

TEST(JoinConvexParts, RefusesPartsThatAreNotConvexOrNotClosed) {
  std::vector<meshes::Hull> hulls;
  const std::vector<meshes::Mesh> parts = {BoxMesh({5, 0, 0}, {6, 1, 1}), AngleMesh()};
  EXPECT_EQ(Refusal([&] { meshes::JoinConvexParts(parts, "m", hulls); }),
            "m: part 2 of 2, about (1, 1, 0.5), is not convex: its convex hull has 16.7 % more "
            "volume; decompose the mesh instead: remove `parts: given`");
  meshes::Mesh open = BoxMesh({0, 0, 0}, {1, 1, 1});
  open.triangles.pop_back();
  EXPECT_TRUE(Refusal([&] {
                meshes::JoinConvexParts({{open}}, "m", hulls);
              }).starts_with("m: part 1 of 1: is not watertight"));
}

TEST(Decompose, PartsMayBeApart) {
  const meshes::Mesh two = Joined(BoxMesh({0, 0, 0}, {1, 1, 1}), BoxMesh({5, 0, 0}, {6, 1, 1}));
  const meshes::Decomposition pieces = meshes::Decompose(two, "m");
  ExpectWellFormed(pieces, two);
  EXPECT_EQ(pieces.hulls.size(), 2u);
  EXPECT_GT(pieces.iou, 0.999);
}

TEST(Decompose, TheAssessmentCountsBothWays) {
  const meshes::Mesh cube = BoxMesh({0, 0, 0}, {2, 2, 2});
  const auto hull = [](const Vector3d& low, const Vector3d& high) {
    return meshes::Hull{BoxMesh(low, high).vertices};
  };
  const meshes::Decomposition half = meshes::Assessed({hull({0, 0, 0}, {1, 2, 2})}, cube);
  EXPECT_NEAR(half.iou, 0.5, 1e-6);
  EXPECT_NEAR(half.volume_error, 0.5, 1e-6);
  // Overlapping pieces count once. Excess and missing parts cancel each other in the volume, but
  // not in the IoU.
  const meshes::Decomposition aside =
      meshes::Assessed({hull({1, 0, 0}, {3, 2, 2}), hull({1.5, 0, 0}, {2.5, 2, 2})}, cube);
  EXPECT_NEAR(aside.volume_error, 0, 1e-6);
  EXPECT_NEAR(aside.iou, 1.0 / 3, 1e-6);
}

TEST(Decompose, TheAssessmentNamesTheVolumeThatIsCountedTwice) {
  const meshes::Hull hull{BoxMesh({0, 0, 0}, {3, 1, 1}).vertices};
  const meshes::Mesh apart = Joined(BoxMesh({0, 0, 0}, {1, 1, 1}), BoxMesh({2, 0, 0}, {3, 1, 1}));
  EXPECT_NEAR(meshes::Assessed({hull}, apart).overlap, 0, 1e-6);
  // Two of 3 m^3, which have 1 of 3 m^3 in common.
  const meshes::Mesh twice = Joined(BoxMesh({0, 0, 0}, {2, 1, 1}), BoxMesh({1, 0, 0}, {3, 1, 1}));
  const meshes::Decomposition pieces = meshes::Assessed({hull}, twice);
  EXPECT_NEAR(pieces.overlap, 1.0 / 3, 1e-6);
  EXPECT_NEAR(pieces.volume_error, 0, 1e-6);
}

TEST(Primitives, TorusHullsComeCloserTheMoreThereAre) {
  double error = 1;
  for (const std::size_t segments : {6u, 12u, 24u, 48u}) {
    const meshes::Decomposition pieces = meshes::TorusHulls(2, 0.5, segments);
    ASSERT_EQ(pieces.hulls.size(), segments);
    for (const meshes::Hull& hull : pieces.hulls) {
      EXPECT_EQ(hull.vertices.size(), 2 * meshes::kTorusCorners);
      // The hull is convex with all vertices as corners, and each of them is on the torus.
      EXPECT_EQ(meshes::TryConvexHull(hull.vertices)->vertices.size(), hull.vertices.size());
      for (const Vector3d& v : hull.vertices)
        EXPECT_NEAR(std::hypot(std::hypot(v.x(), v.z()) - 2, v.y()), 0.5, 1e-12);
    }
    EXPECT_LT(1 - pieces.iou, error);
    error = 1 - pieces.iou;
  }
  EXPECT_LT(error, 0.05);
}

TEST(Primitives, AreSolids) {
  const meshes::Mesh torus = meshes::TorusMesh(2, 0.5, 64, 64);
  EXPECT_EQ(meshes::Watertight(torus, "m"), torus);
  EXPECT_NEAR(meshes::SignedVolume(
                  meshes::TorusMesh(2, 0.5, meshes::kTorusFineness, meshes::kTorusFineness)) /
                  (2 * std::numbers::pi * std::numbers::pi * 2 * 0.25),
              1, 1e-3);
  EXPECT_EQ(meshes::Watertight(meshes::TetrahedronMesh(2), "m"), meshes::TetrahedronMesh(2));
  for (const meshes::Triangle& t : meshes::TetrahedronMesh(2).triangles)
    for (int i = 0; i < 3; ++i) {
      const auto corners = meshes::CornersOf(meshes::TetrahedronMesh(2), t);
      EXPECT_NEAR(
          (corners[static_cast<std::size_t>(i)] - corners[static_cast<std::size_t>((i + 1) % 3)])
              .norm(),
          2, 1e-14);
    }
  EXPECT_EQ(Refusal([] { meshes::TorusMesh(1, 1, 8, 8); }),
            "torus: the tube's radius 1 must be above 0 and below the ring's radius 1");
  EXPECT_EQ(Refusal([] { meshes::TorusHulls(2, 1, 2); }),
            "torus: 2 corners round; 3 to 4096 are possible");
  EXPECT_EQ(Refusal([] { meshes::TetrahedronMesh(NAN); }),
            "tetrahedron: its edge nan must be above 0");
}

}  // namespace
}  // namespace cdb::tests
