// Ground by formulae beside the formulae themselves.
#include "library/terrain/zero_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include "library/scene_error.h"

namespace cdb::tests {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using terrain::Deviation;
using terrain::Function;

const AlignedBox3d kBox(Vector3d(-2, -2, -2), Vector3d(2, 2, 2));

double Ball(const Vector3d& at) { return at.norm() - 1.5; }

double VolumeOf(const meshes::Mesh& mesh) {
  double volume = 0;
  for (const meshes::Triangle& triangle : mesh.triangles) {
    const auto [a, b, c] = meshes::CornersOf(mesh, triangle);
    volume += a.dot(b.cross(c)) / 6;
  }
  return volume;
}

/// The edges that do not have as many triangles on one side as on the other.
std::size_t OpenEdges(const meshes::Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& [a, b, c] : mesh.triangles)
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
      edges[std::minmax(from, to)] += from < to ? 1 : -1;
  return static_cast<std::size_t>(
      std::ranges::count_if(edges, [](const auto& edge) { return edge.second != 0; }));
}

std::string ErrorOf(const auto& make) {
  try {
    make();
  } catch (const library::SceneError& error) {
    EXPECT_FALSE(error.remedy().empty());
    return error.cause();
  }
  return "no error";
}

TEST(ZeroSet, OfABallIsClosedAndNearIt) {
  Deviation coarse, fine;
  const meshes::Mesh mesh = terrain::ZeroSetOf(Ball, kBox, 0.2, coarse);
  for (const Vector3d& vertex : mesh.vertices) EXPECT_NEAR(vertex.norm(), 1.5, 1e-9);
  EXPECT_EQ(OpenEdges(mesh), 0u);
  const double volume = 4 * std::numbers::pi / 3 * std::pow(1.5, 3);
  EXPECT_NEAR(VolumeOf(mesh), volume, 0.02 * volume) << "faces are outwards";
  // A chord of twice the cell is half its square over eight radii off.
  EXPECT_GT(coarse.most, 0.2 * 0.2 / (8 * 1.5));
  EXPECT_LT(coarse.most, 0.4 * 0.4 / (4 * 1.5));
  terrain::ZeroSetOf(Ball, kBox, 0.1, fine);
  EXPECT_NEAR(coarse.most / fine.most, 4, 1.5);
  EXPECT_GT(fine.points, coarse.points);
}

TEST(ZeroSet, KeepsTheEdgesOfACube) {
  // Its faces are in no plane of the grid.
  const Vector3d half(0.93, 1.17, 1.31);
  const Function cube = [&](const Vector3d& at) { return (at.cwiseAbs() - half).maxCoeff(); };
  Deviation deviation;
  const meshes::Mesh mesh = terrain::ZeroSetOf(cube, kBox, 0.25, deviation);
  EXPECT_EQ(OpenEdges(mesh), 0u);
  EXPECT_NEAR(VolumeOf(mesh), 8 * half.prod(), 1e-6);
  EXPECT_LT(deviation.most, 1e-6);
}

TEST(ZeroSet, EndsAtTheSidesOfTheBox) {
  const Function slope = [](const Vector3d& at) { return at.y() - 0.3 * at.x() + 0.1; };
  Deviation deviation;
  const meshes::Mesh mesh = terrain::ZeroSetOf(slope, kBox, 0.3, deviation);
  AlignedBox3d box;
  for (const Vector3d& vertex : mesh.vertices) {
    EXPECT_NEAR(slope(vertex), 0, 1e-9);
    box.extend(vertex);
  }
  EXPECT_TRUE(box.min().isApprox(Vector3d(-2, -0.7, -2), 1e-9));
  EXPECT_TRUE(box.max().isApprox(Vector3d(2, 0.5, 2), 1e-9));
  EXPECT_LT(deviation.most, 1e-9);
  for (const meshes::Triangle& triangle : mesh.triangles) {
    const auto [a, b, c] = meshes::CornersOf(mesh, triangle);
    EXPECT_GE((b - a).cross(c - a).y(), 0) << "from where the formula is positive";
  }
}

TEST(ZeroSet, HasWallsWhereTheFormulaJumps) {
  const Function stairs = [](const Vector3d& at) { return at.y() - std::floor(at.x() + 0.05); };
  Deviation deviation;
  const meshes::Mesh mesh = terrain::ZeroSetOf(stairs, kBox, 0.2, deviation);
  double highest = -9;
  for (const Vector3d& vertex : mesh.vertices) highest = std::max(highest, vertex.y());
  EXPECT_NEAR(highest, 2, 1e-6);
  EXPECT_LT(deviation.most, 0.2) << "corners may be cut within their cells";
}

TEST(ZeroSet, MeasuresWhatItsCellsMiss) {
  // A groove much narrower than a cell, over the points of a few triangles.
  const Function groove = [](const Vector3d& at) {
    return at.y() + (std::abs(at.x() - 0.07) < 0.01 ? 0.1 : 0.0);
  };
  Deviation deviation;
  terrain::ZeroSetOf(groove, kBox, 0.1, deviation);
  EXPECT_NEAR(deviation.most, 0.1, 1e-3);
}

TEST(ZeroSet, IsRefusedInWords) {
  Deviation deviation;
  const auto error = [&](const Function& function, double cell) {
    return ErrorOf([&] { terrain::ZeroSetOf(function, kBox, cell, deviation); });
  };
  EXPECT_EQ(error([](const Vector3d& at) { return at.squaredNorm() + 1; }, 1),
            "the formula is not negative at all 125 points of its grid, so that it has no surface "
            "in the box");
  EXPECT_EQ(error([](const Vector3d&) { return -1.0; }, 1),
            "the formula is negative at all 125 points of its grid, so that it has no surface in "
            "the box");
  EXPECT_EQ(error([](const Vector3d& at) { return std::sqrt(at.x()); }, 1),
            "the formula has no finite value at (-2, -2, -2)");
  EXPECT_EQ(error(Ball, 0.001),
            "the formula would be evaluated at 6.4e+10 points; 8388608 is the maximum");
}

TEST(Heights, OfAFormulaAreItsValues) {
  const Function waves = [](const Vector3d& at) { return std::sin(at.x()) * std::cos(2 * at.z()); };
  Deviation coarse, fine;
  const terrain::HeightGrid grid = terrain::HeightsOf(waves, 6, 4, 0.1, coarse);
  EXPECT_EQ(grid.columns, 61u);
  EXPECT_EQ(grid.rows, 41u);
  EXPECT_NEAR(grid.heights[7 * 61 + 11], waves({1.1 - 3, 0, 0.7 - 2}), 1e-14);
  // Of a chord: an eighth of the square of its length times the second derivative.
  EXPECT_GT(coarse.most, 0.1 * 0.1 * 4 / 8 / 2);
  EXPECT_LT(coarse.most, 0.1 * 0.1 * (1 + 4) / 8);
  terrain::HeightsOf(waves, 6, 4, 0.05, fine);
  EXPECT_NEAR(coarse.most / fine.most, 4, 0.5);
  Deviation flat;
  terrain::HeightsOf([](const Vector3d& at) { return 0.25 * at.x() - 3; }, 6, 4, 0.5, flat);
  EXPECT_LT(flat.most, 1e-14);
  EXPECT_EQ(ErrorOf([&] {
              terrain::HeightsOf([](const Vector3d& at) { return 1 / at.x(); }, 2, 2, 1, flat);
            }),
            "the formula has no finite value at (0, 0, -1)");
}

}  // namespace
}  // namespace cdb::tests
