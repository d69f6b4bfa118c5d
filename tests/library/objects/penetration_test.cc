#include "library/objects/distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/library/objects/random_solids.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

objects::Solid Ball(double size) { return {objects::Shape::kEllipsoid, Vector3d::Constant(size)}; }
objects::Pose PoseAt(double x, double y, double z) { return {Vector3d(x, y, z)}; }

/// The displacement along `normal` that separates a from b, for any shapes.
double MoveAlong(const Vector3d& normal, const objects::Solid& a, const objects::Pose& pose_a,
                 const objects::Solid& b, const objects::Pose& pose_b) {
  return normal.dot(WorldSupport(b, pose_b, normal) - WorldSupport(a, pose_a, -normal));
}

struct Case {
  objects::Solid a, b;
  objects::Pose pose_a, pose_b;
};

/// Balls and cuboids that overlap or are close to each other.
Case RandomCase(distributions::Stream& stream) {
  const auto solid = [&] {
    return stream.Uniform(0, 1) < 0.4 ? Ball(stream.LogUniform(0.3, 3))
                                      : RandomSolid(stream, objects::Shape::kCuboid, 4);
  };
  Case drawn{solid(), solid(), {}, {}};
  drawn.pose_a = {RandomDirection(stream) * stream.Uniform(0, 3), stream.Turn()};
  drawn.pose_b = {RandomDirection(stream) * stream.Uniform(0, 1), stream.Turn()};
  return drawn;
}

TEST(ExactContact, NoDirectionOutIsShorterAndItsOwnIsAsLong) {
  distributions::Stream stream(1);
  int overlapping = 0;
  for (int i = 0; i < Cases(2000); ++i) {
    const Case c = RandomCase(stream);
    const auto exact = objects::ExactContact(c.a, c.pose_a, c.b, c.pose_b);
    if (!exact) continue;
    EXPECT_NEAR(exact->normal.norm(), 1, 1e-12);
    EXPECT_NEAR(MoveAlong(exact->normal, c.a, c.pose_a, c.b, c.pose_b), exact->depth, 1e-12);
    EXPECT_GE(exact->next_depth, exact->depth);
    if (exact->depth <= 0) continue;
    ++overlapping;
    // In any direction, and near the direction that is claimed to be the shortest.
    for (int k = 0; k < Cases(500); ++k) {
      const double spread = k % 2 == 0 ? 10 : 1e-3;
      const Vector3d other = (exact->normal + spread * RandomDirection(stream)).normalized();
      ASSERT_GE(MoveAlong(other, c.a, c.pose_a, c.b, c.pose_b), exact->depth - 1e-12);
    }
  }
  EXPECT_GT(overlapping, Cases(500));
}

TEST(ExactContact, OverlapsWhereTheyOverlapAndIsUndoneByItsMove) {
  distributions::Stream stream(2);
  for (int i = 0; i < Cases(2000); ++i) {
    Case c = RandomCase(stream);
    const auto exact = objects::ExactContact(c.a, c.pose_a, c.b, c.pose_b);
    const bool is_deep = exact && exact->depth > 1e-9;
    if (exact && std::fabs(exact->depth) < 1e-9) continue;
    ASSERT_EQ(is_deep, objects::Overlap(c.a, c.pose_a, c.b, c.pose_b));
    if (!is_deep) continue;
    c.pose_a.position += (exact->depth + 1e-6) * exact->normal;
    EXPECT_FALSE(objects::Overlap(c.a, c.pose_a, c.b, c.pose_b));
  }
}

TEST(ExactContact, IsTheOtherWayRoundForTheOtherOrder) {
  distributions::Stream stream(3);
  for (int i = 0; i < Cases(2000); ++i) {
    const Case c = RandomCase(stream);
    const auto one = objects::ExactContact(c.a, c.pose_a, c.b, c.pose_b);
    const auto other = objects::ExactContact(c.b, c.pose_b, c.a, c.pose_a);
    ASSERT_EQ(one.has_value(), other.has_value());
    if (!one) continue;
    EXPECT_NEAR(one->depth, other->depth, 1e-12);
    EXPECT_NEAR((one->normal + other->normal).norm(), 0, 1e-9);
  }
}

TEST(ExactContact, OfBallsIsTheirReachLessTheirDistance) {
  const auto exact = objects::ExactContact(Ball(2), PoseAt(0, 1.5, 0), Ball(4), objects::Pose());
  EXPECT_DOUBLE_EQ(exact->depth, 1.5);
  EXPECT_EQ(exact->normal, Vector3d::UnitY());
  EXPECT_DOUBLE_EQ(objects::ExactContact(Ball(2), PoseAt(0, 0, 7), Ball(4), objects::Pose())->depth,
                   -4);
  const auto same = objects::ExactContact(Ball(2), objects::Pose(), Ball(4), objects::Pose());
  EXPECT_DOUBLE_EQ(same->depth, 3);
  EXPECT_DOUBLE_EQ(same->next_depth, 3) << "any way is as good";
}

TEST(ExactContact, OfABallInACuboidIsToTheNearestFace) {
  const objects::Solid cuboid{objects::Shape::kCuboid, {8, 4, 6}};
  const auto exact = objects::ExactContact(Ball(1), PoseAt(3.5, -1, 0), cuboid, objects::Pose());
  EXPECT_DOUBLE_EQ(exact->depth, 1);
  EXPECT_EQ(exact->normal, Vector3d::UnitX());
  EXPECT_DOUBLE_EQ(exact->next_depth, 1.5);
  // At a corner, and separated.
  const auto corner = objects::ExactContact(Ball(1), PoseAt(5, 3, 4), cuboid, objects::Pose());
  EXPECT_DOUBLE_EQ(corner->depth, 0.5 - std::sqrt(3));
  EXPECT_NEAR((corner->normal - Vector3d::Ones() / std::sqrt(3)).norm(), 0, 1e-15);
}

TEST(ExactContact, OfAStackedBoxHasOneNormalThoughTwoFacesSayIt) {
  const objects::Solid box{objects::Shape::kCuboid, Vector3d::Constant(10)};
  const auto exact = objects::ExactContact(box, PoseAt(1, 9.5, 2), box, objects::Pose());
  EXPECT_DOUBLE_EQ(exact->depth, 0.5);
  EXPECT_EQ(exact->normal, Vector3d::UnitY());
  EXPECT_DOUBLE_EQ(exact->next_depth, 8);
}

TEST(ExactContact, OfEdgesAcrossIsAlongTheirProduct) {
  // Each box stands on an edge, one along x and the other along z.
  const objects::Solid box{objects::Shape::kCuboid, Vector3d::Constant(2)};
  const double turn = std::numbers::pi / 4, height = 2 * std::sqrt(2.0);
  objects::Pose a = PoseAt(0, height - 0.25, 0), b;
  a.orientation = Eigen::AngleAxisd(turn, Vector3d::UnitX());
  b.orientation = Eigen::AngleAxisd(turn, Vector3d::UnitZ());
  const auto exact = objects::ExactContact(box, a, box, b);
  EXPECT_NEAR(exact->depth, 0.25, 1e-12);
  EXPECT_NEAR((exact->normal - Vector3d::UnitY()).norm(), 0, 1e-12);
}

TEST(ExactContact, WithAHalfSpaceIsOfTheDeepestPoint) {
  distributions::Stream stream(4);
  for (const objects::Shape shape : objects::kClosedShapes) {
    for (int i = 0; i < 50; ++i) {
      const objects::Solid solid = RandomSolid(stream, shape, 4);
      const objects::Pose pose{RandomDirection(stream), stream.Turn()};
      const Vector3d normal = RandomDirection(stream);
      const double offset = stream.Uniform(-2, 2);
      const auto exact = objects::ExactContact(solid, pose, normal, offset);
      // Raised by its depth, it stands on the plane; a box as wide as the world gives the same
      // result.
      const objects::Solid ground{objects::Shape::kCuboid, Vector3d::Constant(100)};
      const Eigen::AngleAxisd from_y(std::acos(normal.y()),
                                     Vector3d::UnitY().cross(normal).normalized());
      objects::Pose below{normal * (offset - 50), Eigen::Quaterniond(from_y)};
      objects::Pose lifted = pose;
      lifted.position += (exact->depth + 1e-6) * normal;
      EXPECT_FALSE(objects::Overlap(solid, lifted, ground, below));
      lifted.position -= 2e-6 * normal;
      EXPECT_TRUE(objects::Overlap(solid, lifted, ground, below));
      EXPECT_EQ(exact->normal, normal);
    }
  }
}

TEST(ExactContact, IsNotToldOfOtherPairs) {
  const objects::Solid cuboid{objects::Shape::kCuboid, Vector3d::Ones()},
      cone{objects::Shape::kCone, Vector3d::Ones()};
  const objects::Solid egg{objects::Shape::kEllipsoid, {1, 2, 1}};
  EXPECT_FALSE(objects::ExactContact(cuboid, objects::Pose(), cone, objects::Pose()));
  EXPECT_FALSE(objects::ExactContact(egg, objects::Pose(), Ball(1), objects::Pose()));
  EXPECT_FALSE(objects::ExactContact(cuboid, objects::Pose(), cuboid, PoseAt(1.5, 0, 0)))
      << "apart";
  EXPECT_FALSE(objects::ExactContact(Torus(), objects::Pose(), Vector3d::UnitY(), 0));
}

}  // namespace
}  // namespace cdb::tests
