#include "library/objects/distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/library/objects/random_solids.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kDistanceError = 1e-12;

double SizeOf(const objects::Solid& a, const objects::Solid& b) {
  return a.sides.norm() + b.sides.norm();
}

/// A common motion of both poses, which changes no distance.
struct Motion {
  Quaterniond turn;
  Vector3d by;
  objects::Pose operator()(const objects::Pose& pose) const {
    return {by + turn * pose.position, (turn * pose.orientation).normalized()};
  }
};

Motion RandomMotion(distributions::Stream& stream, double far) {
  const Quaterniond turn = stream.Turn();
  return {turn, far * RandomDirection(stream)};
}

void ExpectDistance(const objects::Solid& a, const objects::Pose& pose_a, const objects::Solid& b,
                    const objects::Pose& pose_b, double expected) {
  const double exact = kDistanceError * (SizeOf(a, b) + expected);
  ASSERT_NEAR(objects::Distance(a, pose_a, b, pose_b), expected, exact);
  ASSERT_NEAR(objects::Distance(b, pose_b, a, pose_a), expected, exact);
}

/// The distance of two axis-aligned boxes, from the gaps along the axes.
double Between(const Vector3d& offset, const Vector3d& half_a, const Vector3d& half_b) {
  return (offset.cwiseAbs() - half_a - half_b).cwiseMax(0).norm();
}

TEST(Distance, Balls) {
  distributions::Stream stream(1);
  for (int i = 0; i < Cases(1000); ++i) {
    const objects::Solid a{objects::Shape::kEllipsoid, Vector3d::Constant(stream.Uniform(1, 9))};
    const objects::Solid b{objects::Shape::kEllipsoid, Vector3d::Constant(stream.Uniform(1, 9))};
    const Vector3d offset = RandomDirection(stream) * stream.Uniform(0, 20);
    const double gap = offset.norm() - (a.sides.x() + b.sides.x()) / 2;
    ExpectDistance(a, {}, b, {offset, stream.Turn()}, std::max(gap, 0.0));
  }
}

TEST(Distance, BoxesSideBySide) {
  distributions::Stream stream(2);
  for (int i = 0; i < Cases(2000); ++i) {
    const objects::Solid a = RandomSolid(stream, objects::Shape::kCuboid, 50);
    const objects::Solid b = RandomSolid(stream, objects::Shape::kCuboid, 50);
    const Vector3d offset = RandomDirection(stream) * stream.LogUniform(1, 1000);
    const Motion move = RandomMotion(stream, 10);
    ExpectDistance(a, move({}), b, move({offset, Quaterniond::Identity()}),
                   Between(offset, a.HalfExtents(), b.HalfExtents()));
  }
}

TEST(Distance, RoundCapsuleAndBox) {
  // The solid is a segment expanded by a ball of its radius.
  distributions::Stream stream(3);
  for (int i = 0; i < Cases(2000); ++i) {
    const double radius = stream.Uniform(0.5, 2), height = 2 * radius + stream.Uniform(0, 30);
    const objects::Solid capsule{objects::Shape::kCapsule, {2 * radius, height, 2 * radius}};
    const objects::Solid box = RandomSolid(stream, objects::Shape::kCuboid, 10);
    const Vector3d offset = RandomDirection(stream) * stream.Uniform(1, 40);
    const Vector3d segment(0, height / 2 - radius, 0);
    const double gap = Between(offset, segment, box.HalfExtents()) - radius;
    const Motion move = RandomMotion(stream, 10);
    ExpectDistance(capsule, move({}), box, move({offset, Quaterniond::Identity()}),
                   std::max(gap, 0.0));
  }
}

TEST(Distance, BallAndCylinder) {
  distributions::Stream stream(4);
  for (int i = 0; i < Cases(2000); ++i) {
    const double width = stream.Uniform(1, 9), height = stream.Uniform(1, 9);
    const objects::Solid cylinder{objects::Shape::kCylinder, {width, height, width}};
    const objects::Solid ball{objects::Shape::kEllipsoid, Vector3d::Constant(stream.Uniform(1, 9))};
    const Vector3d offset = RandomDirection(stream) * stream.Uniform(1, 30);
    const double aside = std::max(std::hypot(offset.x(), offset.z()) - width / 2, 0.0);
    const double above = std::max(std::abs(offset.y()) - height / 2, 0.0);
    const double gap = std::hypot(aside, above) - ball.sides.x() / 2;
    const Motion move = RandomMotion(stream, 10);
    ExpectDistance(cylinder, move({}), ball, move({offset, Quaterniond::Identity()}),
                   std::max(gap, 0.0));
  }
}

TEST(Distance, EverythingAboveALargeFace) {
  // The distance is the height of the lowest point.
  distributions::Stream stream(5);
  const objects::Solid floor{objects::Shape::kCuboid, {1000, 10, 1000}};
  for (int i = 0; i < Cases(3000); ++i) {
    const objects::Solid solid = RandomSolid(stream, objects::kClosedShapes[i % 6], 50);
    const double gap = stream.LogUniform(1e-6, 100);
    const Quaterniond turn = stream.Turn();
    const double lowest = objects::Bounds(solid, turn).lower.y();
    const Motion move = RandomMotion(stream, 10);
    ExpectDistance(floor, move({}), solid,
                   move({{stream.Uniform(-90, 90), 5 + gap - lowest, 3}, turn}), gap);
  }
}

TEST(Distance, TipsOfCones) {
  const objects::Solid cone{objects::Shape::kCone, {2, 8, 4}};
  const Quaterniond over(Eigen::AngleAxisd(std::acos(-1.0), Vector3d::UnitX()));
  // Tip to tip, 6 above each centre of mass; tip to base, 2 below it.
  ExpectDistance(cone, {}, cone, {{0, 12.25, 0}, over}, 0.25);
  ExpectDistance(cone, {}, cone, {{0, 8.25, 0}, Quaterniond::Identity()}, 0.25);
}

TEST(Distance, OfCompoundsGoesThroughTheHole) {
  const objects::Solid ring = Torus();
  const objects::Solid ball{objects::Shape::kEllipsoid, {1, 1, 1}};
  const double hole =
      objects::Distance(ring, {}, {objects::Shape::kEllipsoid, {1e-9, 1e-9, 1e-9}}, {});
  EXPECT_GT(hole, 0.9);
  EXPECT_LE(hole, 1);
  EXPECT_NEAR(objects::Distance(ring, {}, ball, {}), hole - 0.5, 1e-9);
  EXPECT_FALSE(objects::Overlap(ring, {}, ball, {}));
  EXPECT_TRUE(objects::Overlap(ring, {}, ball, {{0.9, 0, 0}, Quaterniond::Identity()}));
}

TEST(Distance, PropertiesForAllPairs) {
  distributions::Stream stream(6);
  std::vector<objects::Solid> solids = {Torus()};
  for (const double most : {1.0, 3.0, 50.0})
    for (const objects::Shape shape : objects::kClosedShapes)
      solids.push_back(RandomSolid(stream, shape, most));
  int apart = 0, overlapping = 0;
  for (const objects::Solid& a : solids) {
    for (const objects::Solid& b : solids) {
      for (int i = 0; i < Cases(10); ++i) {
        const double size = SizeOf(a, b);
        const objects::Pose pa{Vector3d::Zero(), stream.Turn()};
        const double away = stream.LogUniform(0.1, 2);
        const objects::Pose pb{RandomDirection(stream) * size * away, stream.Turn()};
        const double distance = objects::Distance(a, pa, b, pb);
        const double exact = kDistanceError * (size + distance);
        ASSERT_EQ(distance > 0, !objects::Overlap(a, pa, b, pb));
        (distance > 0 ? apart : overlapping) += 1;
        ASSERT_NEAR(objects::Distance(b, pb, a, pa), distance, exact);
        const Motion move = RandomMotion(stream, size);
        ASSERT_NEAR(objects::Distance(a, move(pa), b, move(pb)), distance, 10 * exact);
        // The distance changes by at most the movement of b.
        const double step = stream.LogUniform(1e-6, 1) * size;
        const objects::Pose moved{pb.position + step * RandomDirection(stream), pb.orientation};
        ASSERT_LE(std::abs(objects::Distance(a, pa, b, moved) - distance), step + exact);
        // No separating plane gives a larger distance.
        const Vector3d normal = RandomDirection(stream);
        const auto reach = [&](const objects::Solid& solid, const objects::Pose& pose,
                               const Vector3d& direction) {
          return direction.dot(pose.position) +
                 direction.dot(pose.orientation *
                               solid.Support(pose.orientation.conjugate() * direction));
        };
        ASSERT_LE(-reach(b, pb, -normal) - reach(a, pa, normal), distance + exact);
      }
    }
  }
  EXPECT_GT(apart, Cases(500));
  EXPECT_GT(overlapping, Cases(500));
}

TEST(Approach, IsAsNearAsAskedAndWasNeverNearer) {
  distributions::Stream stream(7);
  std::vector<objects::Solid> solids = {Torus()};
  for (const objects::Shape shape : objects::kClosedShapes) {
    solids.push_back(RandomSolid(stream, shape, 1));
    solids.push_back(RandomSolid(stream, shape, 20));
  }
  int passed_by = 0;
  for (const objects::Solid& a : solids) {
    for (const objects::Solid& b : solids) {
      for (const double times : {1e-6, 1e-3, 0.1, 100.0}) {
        const double size = SizeOf(a, b), wanted = times * size;
        const Vector3d direction = RandomDirection(stream);
        const objects::Pose pa{Vector3d::Zero(), stream.Turn()};
        objects::Pose pb{Vector3d::Zero(), stream.Turn()};
        const auto apart = objects::Approach(a, pa, b, pb, direction, wanted);
        if (!apart) {
          ++passed_by;
          EXPECT_TRUE(a.compound || b.compound);
          continue;
        }
        pb.position = *apart * direction;
        ASSERT_NEAR(objects::Distance(a, pa, b, pb), wanted, kDistanceError * (size + wanted));
        for (int i = 1; i <= Cases(20); ++i) {
          pb.position = (*apart + i * 0.1 * size) * direction;
          ASSERT_GE(objects::Distance(a, pa, b, pb), wanted);
        }
      }
    }
  }
  EXPECT_LT(passed_by, 20);
}

TEST(Approach, PassesThroughAHole) {
  const objects::Solid ring = Torus();
  const objects::Solid ball{objects::Shape::kEllipsoid, {1, 1, 1}};
  // The ring's axis is y in its mesh.
  const Vector3d axis = ring.compound->from_mesh() * Vector3d::UnitY();
  const Vector3d across = ring.compound->from_mesh() * Vector3d::UnitX();
  EXPECT_FALSE(objects::Approach(ring, {}, ball, {}, axis, 0.1));
  EXPECT_TRUE(objects::Approach(ring, {}, ball, {}, axis, 0.6));
  EXPECT_NEAR(objects::Approach(ring, {}, ball, {}, across, 0.1).value(), 2.6, 0.05);
}

}  // namespace
}  // namespace cdb::tests
