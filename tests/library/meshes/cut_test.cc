#include "library/meshes/cut.h"

#include <gtest/gtest.h>

#include <random>

#include "library/meshes/convex_hull.h"
#include "library/meshes/mass_properties.h"
#include "library/meshes/primitives.h"
#include "library/meshes/quick_hull.h"
#include "tests/library/meshes/test_meshes.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

Vector3d Drawn(std::mt19937& random) {
  std::uniform_real_distribution<double> in(-1, 1);
  const double x = in(random), y = in(random);
  return {x, y, in(random)};
}

meshes::Piece Whole(const meshes::Mesh& mesh) {
  meshes::Piece piece;
  piece.mesh = mesh;
  piece.caps.assign(mesh.triangles.size(), meshes::kSurface);
  piece.volume = meshes::SignedVolume(mesh);
  return piece;
}

TEST(QuickHull, AgreesWithQhull) {
  std::mt19937 random(1);
  meshes::QuickHull quick;
  for (int set = 0; set < 50; ++set) {
    std::vector<Vector3d> points;
    for (int i = 0; i < 5 + 20 * set; ++i) points.push_back(Drawn(random));
    const meshes::Hull hull = *meshes::TryConvexHull(points);
    const double volume = meshes::SignedVolume(meshes::SurfaceOf(hull));
    EXPECT_NEAR(quick.Volume(points), volume, 1e-6);
    std::vector<Vector3d> corners;
    for (const std::uint32_t i : quick.Corners()) corners.push_back(points[i]);
    EXPECT_EQ(corners, hull.vertices);
    EXPECT_LE(quick.Volume(points, 8, volume), volume + 1e-9);
    EXPECT_LE(quick.Corners().size(), 8u);
  }
}

TEST(QuickHull, FlatPointsHaveNoVolume) {
  meshes::QuickHull quick;
  EXPECT_EQ(quick.Volume(std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}), 0);
  EXPECT_TRUE(quick.Corners().empty());
  EXPECT_EQ(quick.Volume(std::vector<Vector3d>(9, Vector3d(1, 2, 3))), 0);
}

TEST(Cut, PiecesAddUpAndJoinAgain) {
  const meshes::Mesh torus = meshes::TorusMesh(2, 0.6, 24, 12);
  const meshes::Mesh hollow = Joined(SphereMesh(1, 2), InsideOut(SphereMesh(0.6, 2)));
  std::mt19937 random(2);
  for (const meshes::Mesh& mesh : {torus, hollow, AngleMesh()}) {
    const double volume = meshes::SignedVolume(mesh);
    std::vector<meshes::Piece> pieces{Whole(mesh)};
    for (int cut = 0; cut < 6; ++cut) {
      const Vector3d normal = Drawn(random).normalized();
      const meshes::Plane plane{normal, 0.3 * Drawn(random).x()};
      std::vector<meshes::Piece> parts;
      for (const meshes::Piece& piece : pieces)
        for (meshes::Piece& part : meshes::Cut(piece, plane, cut, 1e-6, 1e-9, 100))
          parts.push_back(std::move(part));
      pieces = std::move(parts);
      double sum = 0;
      for (const meshes::Piece& piece : pieces) {
        EXPECT_GT(piece.volume, 0);
        // Each vertex is in the solid, so the hull is that of the piece.
        meshes::QuickHull hull;
        EXPECT_GE(hull.Volume(piece.mesh.vertices), piece.volume * (1 - 1e-9));
        sum += piece.volume;
      }
      EXPECT_NEAR(sum, volume, 1e-6 * volume);
    }
    meshes::Piece whole = pieces[0];
    for (std::size_t i = 1; i < pieces.size(); ++i) whole = meshes::Joined(whole, pieces[i]);
    EXPECT_NEAR(meshes::SignedVolume(whole.mesh), volume, 1e-6 * volume);
    EXPECT_NEAR(whole.volume, volume, 1e-6 * volume);
  }
}

TEST(Cut, FacesInThePlaneAreInNeitherPart) {
  // Along the inner face of the angle: the parts are boxes.
  const std::vector<meshes::Piece> boxes =
      meshes::Cut(Whole(AngleMesh()), {Vector3d(1, 0, 0), 1}, 0, 1e-6, 1e-9, 100);
  ASSERT_EQ(boxes.size(), 2u);
  meshes::QuickHull hull;
  for (const meshes::Piece& box : boxes)
    EXPECT_NEAR(hull.Volume(box.mesh.vertices), box.volume, 1e-12);
  EXPECT_NEAR(boxes[0].volume, 2, 1e-12);
}

}  // namespace
}  // namespace cdb::tests
