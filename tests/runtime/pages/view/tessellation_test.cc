#include "runtime/pages/view/scene_document.h"

#include <gtest/gtest.h>

#include "library/objects/surface.h"
#include "tests/library/objects/random_solids.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

/// All vertices of a solid's parts in the body's frame.
std::vector<Vector3d> Vertices(const view::Tessellation& tessellation,
                               const std::vector<view::Part>& parts) {
  std::vector<Vector3d> vertices;
  for (const view::Part& part : parts)
    for (const Eigen::Vector3f& vertex : tessellation.meshes()[part.mesh].positions)
      vertices.push_back(Vector3d(0, part.offset_y, 0) +
                         part.rotation * part.scale.cwiseProduct(vertex.cast<double>()));
  return vertices;
}

/// Checks that no vertex is outside the solid, and that they extend nearly as far as it.
void ExpectFits(const objects::Solid& solid, double least) {
  view::Tessellation tessellation(100);
  const std::vector<Vector3d> vertices = Vertices(tessellation, tessellation.PartsOf(solid));
  auto stream = distributions::Stream(7);
  const double tolerance = 1e-5 * solid.sides.maxCoeff();
  for (int i = 0; i < 60; ++i) {
    const Vector3d direction = RandomDirection(stream);
    const double reach = direction.dot(solid.Support(direction));
    double most = -1e300;
    for (const Vector3d& vertex : vertices) most = std::max(most, direction.dot(vertex));
    EXPECT_LE(most, reach + tolerance);
    EXPECT_GE(most, least * reach - tolerance);
  }
}

TEST(Tessellation, HasTheExtentOfEverySolid) {
  auto stream = distributions::Stream(3);
  for (const objects::Shape shape : objects::kClosedShapes)
    for (int i = 0; i < 5; ++i) ExpectFits(RandomSolid(stream, shape, 4), 0.9);
  ExpectFits(Torus(), 0.999);
}

/// The volume of a closed mesh, by the divergence theorem; negative if faces point inwards.
double SignedVolume(const view::TriangleMesh& mesh) {
  double volume = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto corner = [&](std::size_t k) {
      return Vector3d(mesh.positions[mesh.indices[i + k]].cast<double>());
    };
    volume += corner(0).dot(corner(1).cross(corner(2))) / 6;
  }
  return volume;
}

TEST(Tessellation, HasItsFacesOutwards) {
  for (const objects::Shape shape : objects::kClosedShapes) {
    const double volume = objects::Solid{shape, Vector3d::Ones()}.Volume();
    view::Tessellation tessellation(1);
    const auto parts = tessellation.PartsOf({shape, Vector3d::Ones()});
    ASSERT_EQ(parts.size(), 1U);
    const view::TriangleMesh& mesh = tessellation.meshes()[parts[0].mesh];
    EXPECT_NEAR(SignedVolume(mesh), volume, 0.02 * volume) << mesh.name;
    for (const Eigen::Vector3f& normal : mesh.normals) EXPECT_NEAR(normal.norm(), 1, 1e-6);
  }
}

TEST(Tessellation, DrawsSomeHeightsOfALargeField) {
  terrain::HeightGrid grid;
  grid.columns = 1001;
  grid.rows = 3;
  for (std::size_t i = 0; i < grid.columns * grid.rows; ++i)
    grid.heights.push_back(static_cast<double>(i % grid.columns));
  const auto form = std::make_shared<const objects::ConvexDecomposition>(
      objects::MakeSurface("slope", std::make_shared<const terrain::HeightGrid>(grid)));
  objects::Solid solid{objects::Shape::kCompound, 20 * form->proportions};
  solid.compound = std::make_shared<const objects::Compound>(form, solid.sides);
  view::Tessellation tessellation(1);
  const std::vector<Vector3d> vertices = Vertices(tessellation, tessellation.PartsOf(solid));
  // Two triangles of each cell, seen from both sides; the first and the last height are there.
  EXPECT_EQ(vertices.size(), 143 * 2 * 2 * 2 * 3u);
  double least = 0, most = 0;
  for (const Vector3d& vertex : vertices) {
    least = std::min(least, vertex.x());
    most = std::max(most, vertex.x());
    EXPECT_NEAR(vertex.y(), vertex.x(), 1e-5);
  }
  EXPECT_NEAR(least, -10, 1e-5);
  EXPECT_NEAR(most, 10, 1e-5);
  EXPECT_EQ(view::HeightStep(2), 1u);
  EXPECT_EQ(view::HeightStep(161), 1u);
  EXPECT_EQ(view::HeightStep(162), 2u);
}

TEST(Tessellation, SharesTheMeshesOfEqualShapes) {
  view::Tessellation tessellation(1);
  const objects::Solid small{objects::Shape::kCuboid, {1, 2, 3}};
  const objects::Solid large{objects::Shape::kCuboid, {7, 7, 7}};
  EXPECT_EQ(tessellation.PartsOf(small)[0].mesh, tessellation.PartsOf(large)[0].mesh);
  EXPECT_EQ(tessellation.PartsOf({objects::Shape::kCapsule, {1, 3, 1}}).size(), 3U);
  EXPECT_EQ(tessellation.PartsOf({objects::Shape::kCapsule, {1, 1, 1}}).size(), 1U);
}

}  // namespace
}  // namespace cdb::tests
