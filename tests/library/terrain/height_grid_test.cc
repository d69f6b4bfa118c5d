#include "library/terrain/height_grid.h"

#include <gtest/gtest.h>

#include "library/objects/surface.h"
#include "library/scene_error.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

std::string HeightsFault(const std::string& csv) {
  try {
    meshes::ParseHeights(csv, "hill.csv", 1);
  } catch (const library::SceneError& error) {
    return error.what();
  }
  return "";
}

TEST(Heights, AreRowsAlongZ) {
  const meshes::HeightGrid grid =
      meshes::ParseHeights("\xEF\xBB\xBF# a hill\r\n 0, 1 ,0\r\n\n+2,-3.5,4e-1", "hill.csv", 2);
  EXPECT_EQ(grid.columns, 3u);
  EXPECT_EQ(grid.rows, 2u);
  EXPECT_EQ(grid.heights, (std::vector<double>{0, 1, 0, 2, -3.5, 0.4}));
  const meshes::Mesh mesh = meshes::MeshOf(grid);
  ASSERT_EQ(mesh.vertices.size(), 6u);
  EXPECT_EQ(mesh.vertices[4], Vector3d(2, -3.5, 2));
  ASSERT_EQ(mesh.triangles.size(), 4u);
  for (const meshes::Triangle& triangle : mesh.triangles) {
    const auto corners = meshes::CornersOf(mesh, triangle);
    EXPECT_GT((corners[1] - corners[0]).cross(corners[2] - corners[0]).y(), 0) << "from above";
  }
  const objects::ConvexDecomposition form = objects::MakeSurface("hill", mesh);
  EXPECT_EQ(form.pieces.size(), 4u);
  EXPECT_EQ(form.proportions, Vector3d(4, 5.5, 2) / 5.5);
}

TEST(Heights, AreRefusedByLine) {
  const std::pair<const char*, const char*> rows[] = {
      {"", "hill.csv: it has 0 by 0 heights; a height field needs at least 2 by 2"},
      {"1,2\n", "hill.csv: it has 1 by 2 heights"},
      {"1\n2\n", "hill.csv: it has 2 by 1 heights"},
      {"1,2\n# no\n3\n", "hill.csv:3: 1 heights in this row, but 2 in the first; write as many"},
      {"1,2\n3,4,\n", "hill.csv:2: `` is not a height; write numbers, separated by commas"},
      {"1,x\n", "hill.csv:1: `x` is not a height"},
      {"1,nan\n", "hill.csv:1: `nan` is not a height"},
  };
  for (const auto& [csv, message] : rows)
    EXPECT_NE(HeightsFault(csv).find(message), std::string::npos) << csv << "\n"
                                                                  << HeightsFault(csv);
}

}  // namespace
}  // namespace cdb::tests
