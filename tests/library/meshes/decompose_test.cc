#include "library/meshes/decompose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "library/meshes/mass_properties.h"
#include "library/meshes/primitives.h"
#include "library/meshes/topology.h"
#include "tests/library/meshes/test_meshes.h"

namespace cdb::tests {
namespace {

using namespace testing;
using Eigen::Vector3d;

/// Options for a small decomposition, so that HACD takes little time.
meshes::DecomposeOptions Coarse() {
  meshes::DecomposeOptions options;
  options.faces = 400;
  return options;
}

void ExpectWellFormed(const meshes::Decomposition& pieces, const meshes::Mesh& mesh,
                      const meshes::DecomposeOptions& options) {
  for (const meshes::Hull& hull : pieces.hulls) {
    EXPECT_LE(hull.vertices.size(), options.vertices_per_hull);
    EXPECT_GE(meshes::SignedVolume(meshes::Watertight(meshes::SurfaceOf(hull), "hull")),
              options.least_volume * meshes::SignedVolume(mesh));
  }
}

TEST(Decompose, AConvexMeshIsOneHull) {
  const meshes::Mesh box = BoxMesh({-1, -2, -3}, {1, 2, 3});
  const meshes::Decomposition one = meshes::Decompose(box, "m");
  ASSERT_EQ(one.hulls.size(), 1u);
  EXPECT_EQ(one.hulls[0].vertices, box.vertices);
  EXPECT_NEAR(one.iou, 1, 1e-12);
  EXPECT_NEAR(one.volume_error, 0, 1e-12);
  const meshes::Mesh ball = SphereMesh(1, 3);
  const meshes::Decomposition round = meshes::Decompose(ball, "m");
  ASSERT_EQ(round.hulls.size(), 1u);
  EXPECT_EQ(round.hulls[0].vertices.size(), 64u);
  EXPECT_GT(round.iou, 0.9);
}

TEST(Decompose, AnAngleIsACoupleOfBoxes) {
  const meshes::Mesh angle = AngleMesh();
  const meshes::Decomposition pieces = meshes::Decompose(angle, "m", Coarse());
  ExpectWellFormed(pieces, angle, Coarse());
  EXPECT_GE(pieces.hulls.size(), 2u);
  EXPECT_LE(pieces.hulls.size(), 12u);
  EXPECT_GT(pieces.iou, 0.9);
  EXPECT_LT(pieces.volume_error, 0.1);
}

TEST(Decompose, IsTheSameToTheByteEachTime) {
  const meshes::Mesh ring = meshes::TorusMesh(2, 0.6, 40, 20);
  const meshes::Decomposition first = meshes::Decompose(ring, "m", Coarse());
  ExpectWellFormed(first, ring, Coarse());
  EXPECT_GT(first.hulls.size(), 3u);
  EXPECT_GT(first.iou, 0.6);
  EXPECT_EQ(meshes::Decompose(ring, "m", Coarse()), first);
}

TEST(Decompose, DoesNotDependOnSizeOrPlaceBeyondRounding) {
  // Powers of two, so that there is no rounding error.
  const meshes::Mesh angle = AngleMesh();
  const meshes::Decomposition pieces = meshes::Decompose(angle, "m", Coarse());
  const meshes::Decomposition large = meshes::Decompose(
      Moved(angle, 1024 * Eigen::Matrix3d::Identity(), Vector3d::Zero()), "m", Coarse());
  ASSERT_EQ(large.hulls.size(), pieces.hulls.size());
  EXPECT_NEAR(large.iou, pieces.iou, 1e-9);
}

TEST(Decompose, PartsMayBeApart) {
  const meshes::Mesh two = Joined(BoxMesh({0, 0, 0}, {1, 1, 1}), BoxMesh({5, 0, 0}, {6, 1, 1}));
  const meshes::Decomposition pieces = meshes::Decompose(two, "m", Coarse());
  ExpectWellFormed(pieces, two, Coarse());
  EXPECT_GT(pieces.iou, 0.9);
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
