#include "library/meshes/convex_hull.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "library/meshes/decompose.h"
#include "library/meshes/mass_properties.h"
#include "library/meshes/primitives.h"
#include "library/meshes/topology.h"
#include "tests/library/meshes/test_meshes.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using namespace testing;
using Eigen::Vector3d;

/// Deterministic points without a random generator, well spread in the unit cube.
Vector3d Spread(int i) {
  const auto part = [&](double step) { return i * step - std::floor(i * step); };
  return {part(0.8191725134), part(0.6710436067), part(0.5497004779)};
}

TEST(ConvexHull, OfABoxIsItsCorners) {
  meshes::Mesh box = BoxMesh({-1, -2, -3}, {1, 2, 3});
  const std::vector<Vector3d> corners = box.vertices;
  for (int i = 0; i < 500; ++i)
    box.vertices.push_back((2 * Spread(i) - Vector3d::Ones()).cwiseProduct(Vector3d(1, 2, 3)));
  // And some points on its faces and edges, which are not corners.
  box.vertices.insert(box.vertices.end(), {{1, 0, 0}, {1, 2, 0}, {0, 2, 3}, {0.5, -2, 0.5}});
  EXPECT_EQ(meshes::ConvexHull(box, "m").vertices, corners);
}

TEST(ConvexHull, SurfaceIsClosedConvexAndAroundAllPoints) {
  for (const double scale : {1e-6, 1.0, 1e9}) {
    std::vector<Vector3d> points;
    for (int i = 0; i < 400; ++i) points.push_back(scale * (Spread(i) + Vector3d(100, 0, 0)));
    const auto hull = meshes::TryConvexHull(points);
    ASSERT_TRUE(hull);
    const meshes::Mesh surface = meshes::SurfaceOf(*hull);
    EXPECT_EQ(meshes::Watertight(surface, "m"), surface);
    EXPECT_GT(meshes::SignedVolume(surface), 0.8 * std::pow(scale, 3));
    for (const meshes::Triangle& t : surface.triangles) {
      const auto [a, b, c] = meshes::CornersOf(surface, t);
      const Vector3d normal = (b - a).cross(c - a).normalized();
      for (const Vector3d& p : points) ASSERT_LE(normal.dot(p - a), 1e-12 * 100 * scale);
    }
  }
}

TEST(ConvexHull, CoplanarAndRepeatedPointsDoNoHarm) {
  // All points of a lattice; most are on faces.
  meshes::Mesh lattice;
  for (int i = 0; i < 6 * 6 * 6; ++i) lattice.vertices.emplace_back(i % 6, i / 6 % 6, i / 36);
  for (int i = 0; i < 6 * 6 * 6; ++i) lattice.vertices.push_back(lattice.vertices[216 / 2]);
  const meshes::Hull hull = meshes::ConvexHull(lattice, "m");
  EXPECT_EQ(hull.vertices.size(), 8u);
  EXPECT_NEAR(meshes::SignedVolume(meshes::Watertight(meshes::SurfaceOf(hull), "m")), 125, 1e-9);
  const meshes::Hull ring = meshes::ConvexHull(meshes::TorusMesh(2, 0.5, 40, 20), "m");
  EXPECT_EQ(meshes::Watertight(meshes::SurfaceOf(ring), "m").vertices.size(), ring.vertices.size());
}

TEST(ConvexHull, FlatSetsHaveNone) {
  std::vector<Vector3d> flat, line, point(9, Vector3d(1, 2, 3));
  for (int i = 0; i < 30; ++i) {
    flat.emplace_back(Spread(i).x(), Spread(i).y(), 2 * Spread(i).x() - Spread(i).y());
    line.push_back(Spread(i).x() * Vector3d(1, 2, 3));
  }
  EXPECT_FALSE(meshes::TryConvexHull(flat));
  EXPECT_FALSE(meshes::TryConvexHull(line));
  EXPECT_FALSE(meshes::TryConvexHull(point));
  EXPECT_FALSE(meshes::TryConvexHull(std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  for (Vector3d& p : flat) p.z() = 1;
  EXPECT_FALSE(meshes::TryConvexHull(flat));
  EXPECT_EQ(Refusal([&] {
              meshes::ConvexHull({flat, {}}, "m");
            }),
            "m: is flat, so its convex hull has no volume; a solid needs one");
}

TEST(ConvexHull, HasVerticesOfNoFaceOnlyIfThereAreNoFaces) {
  meshes::Mesh mesh = BoxMesh({0, 0, 0}, {1, 1, 1});
  mesh.vertices.emplace_back(5, 5, 5);
  EXPECT_EQ(meshes::ConvexHull(mesh, "m").vertices.size(), 8u);
  mesh.triangles.clear();
  EXPECT_EQ(meshes::ConvexHull(mesh, "m").vertices.size(), 8u);
  EXPECT_EQ(meshes::ConvexHull(mesh, "m").vertices.back(), Vector3d(5, 5, 5));
}

TEST(ConvexHull, FewerVerticesKeepMostOfTheVolume) {
  const meshes::Hull ball = meshes::ConvexHull(SphereMesh(1, 4), "m");
  EXPECT_EQ(ball.vertices.size(), 1026u);
  double volume = 0;
  for (const std::size_t count : {4u, 8u, 16u, 32u, 64u}) {
    const meshes::Hull fewer = meshes::WithFewerVertices(ball, count);
    EXPECT_EQ(fewer.vertices.size(), count);
    const double next = meshes::SignedVolume(meshes::SurfaceOf(fewer));
    EXPECT_GT(next, volume);
    volume = next;
  }
  EXPECT_GT(volume, 0.9 * 4 * std::numbers::pi / 3);
  EXPECT_EQ(meshes::WithFewerVertices(ball, 2000), ball);
  // The first points are the corners of a box.
  meshes::Mesh box = BoxMesh({-1, -1, -1}, {1, 1, 1});
  for (int i = 0; i < 50; ++i)  // points just outside its faces
    box.vertices.emplace_back(1 + 1e-4 * (i % 7), 1.5 * Spread(i).y() - 0.75,
                              1.5 * Spread(i).z() - 0.75);
  const meshes::Hull eight = meshes::WithFewerVertices(meshes::ConvexHull(box, "m"), 8);
  EXPECT_EQ(eight.vertices, std::vector<Vector3d>(box.vertices.begin(), box.vertices.begin() + 8));
}

TEST(OverlapVolume, OfBoxesIsExact) {
  const meshes::Mesh a = BoxMesh({0, 0, 0}, {4, 4, 4}), b = BoxMesh({1, 1, -1}, {2, 3, 1});
  // The faces of the boxes lie between rays, because the box around both is divided into 256.
  const meshes::OverlapVolume volume = meshes::OverlapVolumeOf(a, b);
  EXPECT_NEAR(volume.first, 64, 64e-6);
  EXPECT_NEAR(volume.second, 4, 4e-6);
  EXPECT_NEAR(volume.common, 2, 2e-6);
  EXPECT_NEAR(volume.IntersectionOverUnion(), 2.0 / 66, 1e-6);
}

TEST(OverlapVolume, CountsWhatIsInsideTwiceOnce) {
  const meshes::Mesh a = BoxMesh({0, 0, 0}, {2, 2, 2}), b = BoxMesh({1, 0, 0}, {3, 2, 2});
  EXPECT_NEAR(meshes::OverlapVolumeOf(Joined(a, b), a).first, 12, 1e-5);
  EXPECT_DOUBLE_EQ(meshes::SignedVolume(Joined(a, b)), 16);
  const meshes::Mesh hollow = Joined(a, InsideOut(BoxMesh({0.5, 0.5, 0.5}, {1.5, 1.5, 1.5})));
  EXPECT_NEAR(meshes::OverlapVolumeOf(hollow, a).first, 7, 1e-5);
}

TEST(OverlapVolume, AgreesWithTheIntegralsWhateverWayTheMeshIsTurned) {
  for (const meshes::Mesh& mesh :
       {SphereMesh(1, 4), meshes::TorusMesh(2, 0.5, 50, 30), AngleMesh()})
    for (int i = 0; i < Cases(6); ++i) {
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(i, Spread(i + 1).normalized()).toRotationMatrix();
      const meshes::Mesh moved = Moved(mesh, turn, Spread(i));
      const meshes::OverlapVolume volume = meshes::OverlapVolumeOf(moved, moved);
      EXPECT_NEAR(volume.first, meshes::SignedVolume(mesh), 2e-3 * meshes::SignedVolume(mesh));
      EXPECT_EQ(volume.IntersectionOverUnion(), 1);
    }
}

}  // namespace
}  // namespace cdb::tests
