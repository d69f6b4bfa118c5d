#include "library/objects/distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "library/distributions/stream.h"
#include "tests/library/objects/random_solids.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

constexpr auto& kShapes = objects::kClosedShapes;

Vector3d Direction(distributions::Stream& stream) {
  return Vector3d(stream.Normal(), stream.Normal(), stream.Normal()).normalized();
}

objects::Solid AnySolid(distributions::Stream& stream, double most = 10) {
  const auto shape = kShapes[static_cast<std::size_t>(stream.Uniform(0, std::size(kShapes)))];
  return {shape,
          {stream.LogUniform(1, most), stream.LogUniform(1, most), stream.LogUniform(1, most)}};
}

/// Separating axes of two boxes (S. Gottschalk et al., OBBTree, 1996): exact.
bool BoxesOverlap(const objects::Solid& a, const objects::Pose& pa, const objects::Solid& b,
                  const objects::Pose& pb) {
  const Eigen::Matrix3d ra = pa.orientation.toRotationMatrix();
  const Eigen::Matrix3d rb = pb.orientation.toRotationMatrix();
  std::vector<Vector3d> axes;
  for (int i = 0; i < 3; ++i) {
    axes.push_back(ra.col(i));
    axes.push_back(rb.col(i));
    for (int j = 0; j < 3; ++j) axes.push_back(ra.col(i).cross(rb.col(j)));
  }
  return std::none_of(axes.begin(), axes.end(), [&](const Vector3d& axis) {
    if (axis.norm() < 1e-9) return false;
    const double reach = (ra.transpose() * axis).cwiseAbs().dot(a.sides / 2) +
                         (rb.transpose() * axis).cwiseAbs().dot(b.sides / 2);
    return std::abs(axis.dot(pb.position - pa.position)) > reach;
  });
}

TEST(Overlap, BoxesAsTheirSeparatingAxesSay) {
  distributions::Stream stream(1);
  int overlapping = 0;
  for (int i = 0; i < Cases(20000); ++i) {
    const objects::Solid a{objects::Shape::kCuboid,
                           {stream.Uniform(1, 5), stream.Uniform(1, 5), 2}};
    const objects::Solid b{objects::Shape::kCuboid,
                           {stream.Uniform(1, 5), 3, stream.Uniform(1, 5)}};
    const objects::Pose pa{Vector3d::Zero(), stream.Turn()};
    const objects::Pose pb{Direction(stream) * stream.Uniform(1, 6), stream.Turn()};
    const bool expected = BoxesOverlap(a, pa, b, pb);
    overlapping += expected;
    ASSERT_EQ(objects::Overlap(a, pa, b, pb), expected) << i;
    ASSERT_EQ(objects::Overlap(b, pb, a, pa), expected) << i;
  }
  EXPECT_GT(overlapping, Cases(2000));
  EXPECT_LT(overlapping, Cases(18000));
}

TEST(Overlap, BallAndBoxAsTheirDistanceSays) {
  distributions::Stream stream(2);
  for (int i = 0; i < Cases(20000); ++i) {
    const objects::Solid box{objects::Shape::kCuboid,
                             {stream.Uniform(1, 5), stream.Uniform(1, 5), 2}};
    const double radius = stream.Uniform(0.5, 3);
    const objects::Solid ball{objects::Shape::kEllipsoid, Vector3d::Constant(2 * radius)};
    const objects::Pose at_box{Vector3d(1, 2, 3), stream.Turn()};
    const objects::Pose at_ball{Vector3d(1, 2, 3) + Direction(stream) * stream.Uniform(0, 6),
                                stream.Turn()};
    const Vector3d centre = at_box.orientation.conjugate() * (at_ball.position - at_box.position);
    const Vector3d nearest = centre.cwiseMin(box.sides / 2).cwiseMax(-box.sides / 2);
    const double gap = (centre - nearest).norm() - radius;
    if (std::abs(gap) < 1e-9) continue;
    ASSERT_EQ(objects::Overlap(box, at_box, ball, at_ball), gap < 0) << i << " gap " << gap;
  }
}

TEST(Overlap, SolidsWithACommonPointOverlap) {
  distributions::Stream stream(3);
  for (int i = 0; i < Cases(20000); ++i) {
    const objects::Solid a = AnySolid(stream, 50), b = AnySolid(stream, 50);
    const objects::Pose pa{Direction(stream) * 100, stream.Turn()};
    // A point of a's surface is moved to a point of b between its centre of mass and its surface.
    const Vector3d common = WorldSupport(a, pa, Direction(stream));
    objects::Pose pb{Vector3d::Zero(), stream.Turn()};
    pb.position = common - stream.Uniform(0, 1) * WorldSupport(b, pb, Direction(stream));
    ASSERT_TRUE(objects::Overlap(a, pa, b, pb)) << i;
  }
}

TEST(Overlap, SolidsWithAPlaneBetweenThemAreApart) {
  distributions::Stream stream(4);
  for (int i = 0; i < Cases(20000); ++i) {
    const objects::Solid a = AnySolid(stream, 50), b = AnySolid(stream, 50);
    const objects::Pose pa{Direction(stream) * 100, stream.Turn()};
    const Vector3d normal = Direction(stream);
    const double gap = stream.LogUniform(1e-9, 10);
    // b touches the plane `gap` above a's highest point, anywhere along it.
    objects::Pose pb{Vector3d::Zero(), stream.Turn()};
    const double height = normal.dot(WorldSupport(a, pa, normal)) + gap;
    const Vector3d along = normal.cross(Direction(stream)) * stream.Uniform(0, 30);
    pb.position = along + pa.position - normal * normal.dot(pa.position);
    pb.position += normal * (height - normal.dot(WorldSupport(b, pb, -normal)));
    ASSERT_FALSE(objects::Overlap(a, pa, b, pb)) << i << " gap " << gap;
    ASSERT_FALSE(objects::Overlap(b, pb, a, pa)) << i << " gap " << gap;
  }
}

TEST(Overlap, TouchingCounts) {
  const objects::Solid ball{objects::Shape::kEllipsoid, {2, 2, 2}};
  EXPECT_TRUE(objects::Overlap(ball, {}, ball, {{2, 0, 0}, Eigen::Quaterniond::Identity()}));
  EXPECT_FALSE(
      objects::Overlap(ball, {}, ball, {{2 + 1e-12, 0, 0}, Eigen::Quaterniond::Identity()}));
  const objects::Solid box{objects::Shape::kCuboid, {2, 2, 2}};
  EXPECT_TRUE(objects::Overlap(box, {}, box, {{2, 0, 0}, Eigen::Quaterniond::Identity()}));
  EXPECT_FALSE(objects::Overlap(box, {}, box, {{2 + 1e-9, 0, 0}, Eigen::Quaterniond::Identity()}));
  EXPECT_TRUE(objects::Overlap(box, {}, box, {}));
}

TEST(Overlap, LongThinSolids) {
  // Two crossed rods of 1 x 1 x 1000 whose axes are 2 apart: the gap is 1.
  const objects::Solid rod{objects::Shape::kCuboid, {1, 1, 1000}};
  const Eigen::Quaterniond across(Eigen::AngleAxisd(std::acos(0.0), Vector3d::UnitY()));
  EXPECT_FALSE(objects::Overlap(rod, {}, rod, {{0, 2, 0}, across}));
  EXPECT_TRUE(objects::Overlap(rod, {}, rod, {{0, 0.999, 0}, across}));
  const objects::Solid needle{objects::Shape::kCone, {1, 1000, 1}};
  EXPECT_FALSE(
      objects::Overlap(needle, {}, needle, {{1.001, 0, 0}, Eigen::Quaterniond::Identity()}));
  EXPECT_TRUE(
      objects::Overlap(needle, {}, needle, {{0.999, 0, 0}, Eigen::Quaterniond::Identity()}));
}

}  // namespace
}  // namespace cdb::tests
