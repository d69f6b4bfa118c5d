// Voxels as ground: what a scenario says of them, and that overlaps and distances are those of the
// union of their cells.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>

#include "compiler/plan/input_file.h"
#include "library/distributions/stream.h"
#include "library/exact/signed_distance.h"
#include "library/objects/distance.h"
#include "library/objects/solid_factory.h"
#include "library/scene_error.h"
#include "tests/library/objects/solid_cells.h"
#include "tests/support/files.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

class VoxelGround : public testing::Test {
 protected:
  std::string NewFile(const std::string& bytes) {
    const auto file = folder_ / "cells.raw";
    WriteFile(file, bytes);
    return file.string();
  }
  /// Cells of 1 m, with the origin of the file as that of the ground.
  objects::Solid SolidOf(const SolidCells& cells, const Vector3d& size = Vector3d::Zero(),
                         const Vector3d& aspect = Vector3d::Ones()) {
    const std::string file = NewFile(cells.bytes);
    objects::SolidFactory solids;
    return solids.Make(Layout("voxels", {{"file", schema::Text{file}},
                                         {"sha256", schema::Text{plan::Sha256Hex(cells.bytes)}},
                                         {"up", Word("y")},
                                         {"cell", 1.0},
                                         {"columns", static_cast<std::uint64_t>(cells.counts[0])},
                                         {"rows", static_cast<std::uint64_t>(cells.counts[1])},
                                         {"layers", static_cast<std::uint64_t>(cells.counts[2])},
                                         {"origin", Word("file")}}),
                       size, aspect);
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(VoxelGround, BallsAreAsFarAsFromTheUnionOfTheCells) {
  const SolidCells cells = MixedCells(1);
  const objects::Solid ground = SolidOf(cells);
  ASSERT_TRUE(ground.IsSurface());
  const objects::Pose at = objects::BodyOf(ground, {});
  distributions::Stream stream(5);
  int overlaps = 0, inside = 0, deep = 0;
  for (int i = 0; i < 100'000; ++i) {
    const Vector3d centre(stream.Uniform(-1, 10), stream.Uniform(-1, 8), stream.Uniform(-1, 9));
    const double radius = stream.Uniform(0.05, 0.8);
    const objects::Solid ball{objects::Shape::kEllipsoid, Vector3d::Constant(2 * radius)};
    const objects::Pose pose{centre, Eigen::Quaterniond::Identity()};
    const double gap = cells.DistanceTo(centre) - radius;
    if (std::abs(gap) < 1e-9) continue;
    ASSERT_EQ(objects::Overlap(ball, pose, ground, at), gap < 0) << centre.transpose();
    overlaps += gap < 0;
    if (i % 10 != 0) continue;
    const exact::SignedDistance found = exact::DistanceOf(ball, pose, ground, at, 1);
    if (gap == -radius) {  // the centre is in a cell
      ASSERT_TRUE(found.is_inside || found.upper < 0) << centre.transpose();
      ++inside;
      deep += found.is_inside;
    } else if (gap < 0.9) {
      ASSERT_FALSE(found.is_inside);
      ASSERT_NEAR(found.gap, gap, 1e-9) << centre.transpose();
    }
  }
  EXPECT_GT(overlaps, 20'000);
  EXPECT_GT(inside, 1000);
  EXPECT_GT(deep, 200) << "no triangle is near, and they overlap all the same";
}

TEST_F(VoxelGround, BoxesOverlapWhereTheyOverlapACell) {
  const SolidCells cells = MixedCells(2);
  const objects::Solid ground = SolidOf(cells);
  const objects::Pose at = objects::BodyOf(ground, {});
  distributions::Stream stream(6);
  int overlaps = 0, deep = 0;
  for (int i = 0; i < 100'000; ++i) {
    const Vector3d centre(stream.Uniform(-1, 10), stream.Uniform(-1, 8), stream.Uniform(-1, 9));
    const Vector3d sides(stream.Uniform(0.1, 1.2), stream.Uniform(0.1, 1.2),
                         stream.Uniform(0.1, 1.2));
    const objects::Pose pose{centre, stream.Turn()};
    const objects::Solid box{objects::Shape::kCuboid, sides};
    const double depth = cells.DepthOfBox(centre, pose.orientation.toRotationMatrix(), sides / 2);
    if (std::abs(depth) < 1e-9) continue;
    ASSERT_EQ(objects::Overlap(box, pose, ground, at), depth > 0) << centre.transpose();
    overlaps += depth > 0;
    if (i % 50 != 0) continue;
    const exact::SignedDistance found = exact::DistanceOf(box, pose, ground, at, 0);
    ASSERT_EQ(found.upper < 0 || found.is_inside, depth > 0) << centre.transpose();
    deep += found.is_inside;
  }
  EXPECT_GT(overlaps, 20'000);
  EXPECT_GT(deep, 10);
}

TEST_F(VoxelGround, IsScaledWithItsInside) {
  SolidCells cells{{3, 3, 3}, std::string(27, '\1')};
  const objects::Solid ground = SolidOf(cells, Vector3d::Constant(2), Vector3d(3, 1, 2));
  EXPECT_TRUE(ground.sides.isApprox(Vector3d(6, 2, 4)));
  const objects::Solid ball{objects::Shape::kEllipsoid, Vector3d::Constant(0.1)};
  const auto overlaps = [&](double x, double y, double z) {
    return objects::Overlap(ball, {Vector3d(x, y, z), Eigen::Quaterniond::Identity()}, ground,
                            objects::BodyOf(ground, {}));
  };
  EXPECT_TRUE(overlaps(5.8, 1.8, 3.8));
  EXPECT_FALSE(overlaps(6.2, 1.8, 3.8));
  EXPECT_FALSE(overlaps(5.8, 2.2, 3.8));
  EXPECT_EQ(objects::Distance(ball, {Vector3d(3, 1, 2), Eigen::Quaterniond::Identity()}, ground,
                              objects::BodyOf(ground, {})),
            0);
}

TEST_F(VoxelGround, NeedsToKnowWhichAxisIsUp) {
  const std::string file = NewFile("1");
  objects::SolidFactory solids;
  try {
    solids.Make(Layout("voxels", {{"file", schema::Text{file}},
                                  {"sha256", schema::Text{plan::Sha256Hex("1")}}}),
                Vector3d::Zero(), Vector3d::Ones());
    ADD_FAILURE() << "no error";
  } catch (const library::SceneError& error) {
    EXPECT_EQ(error.cause(), file + ": it does not say which of its axes is up");
    EXPECT_EQ(error.remedy(), "add `up: z`, or `up: y`");
  }
}

TEST_F(VoxelGround, SaysWhatItHas) {
  SolidCells cells{{3, 1, 1}, std::string("\1\0\1", 3)};
  const objects::Solid ground = SolidOf(cells);
  const std::string text = objects::ModelsText({ground.compound->shared_form()});
  EXPECT_TRUE(text.ends_with("): 2 of 3 x 1 x 1 cells of 1 m are solid, 24 triangles\n")) << text;
  cells.bytes = std::string(3, '\0');
  EXPECT_THROW(SolidOf(cells), library::SceneError);
}

}  // namespace
}  // namespace cdb::tests
