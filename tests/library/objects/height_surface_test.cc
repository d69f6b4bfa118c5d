#include "library/objects/height_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <set>
#include <utility>

#include "library/objects/surface.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kColumns = 75, kRows = 40;  // three blocks by two

terrain::HeightGrid Rough() {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> height(-1, 3);
  terrain::HeightGrid grid{
      .columns = kColumns, .rows = kRows, .heights = {}, .scale = {0.5, 0.25, 0.75}};
  for (std::size_t i = 0; i < kColumns * kRows; ++i) grid.heights.push_back(height(random));
  return grid;
}

/// Written apart from HeightSurface.
meshes::Mesh MeshOf(const terrain::HeightGrid& grid) {
  meshes::Mesh mesh;
  for (std::size_t row = 0; row < grid.rows; ++row)
    for (std::size_t column = 0; column < grid.columns; ++column)
      mesh.vertices.push_back(grid.scale.cwiseProduct(
          Vector3d(static_cast<double>(column), grid.heights[row * grid.columns + column],
                   static_cast<double>(row))));
  for (std::size_t row = 0; row + 1 < grid.rows; ++row)
    for (std::size_t column = 0; column + 1 < grid.columns; ++column) {
      const auto a = static_cast<std::uint32_t>(row * grid.columns + column);
      const auto b = a + static_cast<std::uint32_t>(grid.columns);
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({a + 1, b, b + 1});
    }
  return mesh;
}

objects::Compound CompoundOf(objects::ConvexDecomposition form) {
  const Vector3d sides = 9 * form.proportions;
  return {std::make_shared<const objects::ConvexDecomposition>(std::move(form)), sides};
}

struct Both {
  explicit Both(const terrain::HeightGrid& rows)
      : field(CompoundOf(
            objects::MakeSurface("rough", std::make_shared<const terrain::HeightGrid>(rows)))),
        mesh(CompoundOf(objects::MakeSurface("rough", MeshOf(rows)))) {}
  objects::Compound field, mesh;
};

TEST(HeightSurface, IsTheMeshOfItsTriangles) {
  const Both both(Rough());
  EXPECT_EQ(both.field.sides(), both.mesh.sides());
  EXPECT_EQ(both.field.form().native_side, both.mesh.form().native_side);
  EXPECT_EQ(both.field.form().file_origin, both.mesh.form().file_origin);
  EXPECT_NEAR(both.field.outer_radius(), both.mesh.outer_radius(), 1e-13);
  ASSERT_EQ(both.field.form().PieceCount(), both.mesh.form().PieceCount());
  for (std::size_t triangle = 0; triangle < both.mesh.form().PieceCount(); ++triangle) {
    std::set<std::size_t> found;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        if ((both.field.Corner(triangle, i) - both.mesh.Corner(triangle, j)).norm() < 1e-13)
          found.insert(j);
    EXPECT_EQ(found.size(), 3u) << triangle;
    const Vector3d a = both.field.Corner(triangle, 0);
    EXPECT_GT((both.field.Corner(triangle, 1) - a).cross(both.field.Corner(triangle, 2) - a).y(), 0)
        << "from above";
  }
}

TEST(HeightSurface, FindsTheFarthestPointsAndTheTrianglesInABox) {
  const Both both(Rough());
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> part(-1, 1);
  for (int i = 0; i < 300; ++i) {
    const Vector3d direction(part(random), part(random), i % 3 == 0 ? 0 : part(random));
    EXPECT_NEAR(direction.dot(both.field.Support(direction)),
                direction.dot(both.mesh.Support(direction)), 1e-12);
    const Vector3d middle = 5 * Vector3d(part(random), 0.1 * part(random), part(random)),
                   half = Vector3d(part(random), 0.1 * part(random), part(random)).cwiseAbs() *
                          (i % 2 == 0 ? 1 : 6);
    const Eigen::AlignedBox3d box(middle - half, middle + half);
    std::multiset<std::size_t> in_field, in_mesh;
    both.field.AnyPieceIn(box, [&](std::size_t piece) { return in_field.insert(piece), false; });
    both.mesh.AnyPieceIn(box, [&](std::size_t piece) { return in_mesh.insert(piece), false; });
    EXPECT_EQ(in_field, in_mesh);
  }
}

TEST(HeightSurface, HasNoTrianglesInBoxesThatAreNoNumbersOrFarAway) {
  const Both both(Rough());
  const auto count = [&](const Eigen::AlignedBox3d& box) {
    std::size_t triangles = 0;
    both.field.AnyPieceIn(box, [&](std::size_t) { return ++triangles, false; });
    return triangles;
  };
  const double none = std::nan(""), most = 1e300;
  EXPECT_EQ(count({Vector3d::Constant(none), Vector3d::Constant(none)}), 0u);
  EXPECT_EQ(count({Vector3d(1e9, -1, -1), Vector3d(1e10, 1, 1)}), 0u);
  EXPECT_EQ(count({Vector3d::Constant(-most), Vector3d::Constant(most)}),
            2 * (kColumns - 1) * (kRows - 1));
}

TEST(HeightSurface, MayBeFlat) {
  terrain::HeightGrid level = Rough();
  std::ranges::fill(level.heights, 7);
  const Both both(level);
  EXPECT_EQ(both.field.sides(), both.mesh.sides());
  EXPECT_EQ(both.field.Corner(0, 0).y(), 0);
}

}  // namespace
}  // namespace cdb::tests
