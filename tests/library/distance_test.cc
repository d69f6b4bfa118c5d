#include "library/objects/distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "library/objects/overlap.h"
#include "tests/library/random_solids.h"

namespace cdb::library {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using test::RandomDirection;
using test::RandomSolid;

constexpr double kExact = 1e-12;

double SizeOf(const Solid& a, const Solid& b) { return a.sides.norm() + b.sides.norm(); }

/// Both poses moved alike, which changes no distance.
struct Motion {
  Quaterniond turn;
  Vector3d by;
  Pose operator()(const Pose& pose) const {
    return {by + turn * pose.position, (turn * pose.orientation).normalized()};
  }
};

Motion RandomMotion(Stream& stream, double far) {
  const Quaterniond turn = stream.Turn();
  return {turn, far * RandomDirection(stream)};
}

void ExpectDistance(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b,
                    double expected) {
  const double exact = kExact * (SizeOf(a, b) + expected);
  ASSERT_NEAR(Distance(a, pose_a, b, pose_b), expected, exact);
  ASSERT_NEAR(Distance(b, pose_b, a, pose_a), expected, exact);
}

/// Of two boxes along the axes, by what is between them along each.
double Between(const Vector3d& offset, const Vector3d& half_a, const Vector3d& half_b) {
  return (offset.cwiseAbs() - half_a - half_b).cwiseMax(0).norm();
}

TEST(Distance, Balls) {
  Stream stream(1);
  for (int i = 0; i < 1000; ++i) {
    const Solid a{Shape::kEllipsoid, Vector3d::Constant(stream.Uniform(1, 9))};
    const Solid b{Shape::kEllipsoid, Vector3d::Constant(stream.Uniform(1, 9))};
    const Vector3d offset = RandomDirection(stream) * stream.Uniform(0, 20);
    const double gap = offset.norm() - (a.sides.x() + b.sides.x()) / 2;
    ExpectDistance(a, {}, b, {offset, stream.Turn()}, std::max(gap, 0.0));
  }
}

TEST(Distance, BoxesSideBySide) {
  Stream stream(2);
  for (int i = 0; i < 2000; ++i) {
    const Solid a = RandomSolid(stream, Shape::kCuboid, 50);
    const Solid b = RandomSolid(stream, Shape::kCuboid, 50);
    const Vector3d offset = RandomDirection(stream) * stream.LogUniform(1, 1000);
    const Motion move = RandomMotion(stream, 10);
    ExpectDistance(a, move({}), b, move({offset, Quaterniond::Identity()}),
                   Between(offset, a.HalfExtents(), b.HalfExtents()));
  }
}

TEST(Distance, RoundCapsuleAndBox) {
  // A segment within a ball of its radius.
  Stream stream(3);
  for (int i = 0; i < 2000; ++i) {
    const double radius = stream.Uniform(0.5, 2), height = 2 * radius + stream.Uniform(0, 30);
    const Solid capsule{Shape::kCapsule, {2 * radius, height, 2 * radius}};
    const Solid box = RandomSolid(stream, Shape::kCuboid, 10);
    const Vector3d offset = RandomDirection(stream) * stream.Uniform(1, 40);
    const Vector3d segment(0, height / 2 - radius, 0);
    const double gap = Between(offset, segment, box.HalfExtents()) - radius;
    const Motion move = RandomMotion(stream, 10);
    ExpectDistance(capsule, move({}), box, move({offset, Quaterniond::Identity()}),
                   std::max(gap, 0.0));
  }
}

TEST(Distance, BallAndCylinder) {
  Stream stream(4);
  for (int i = 0; i < 2000; ++i) {
    const double width = stream.Uniform(1, 9), height = stream.Uniform(1, 9);
    const Solid cylinder{Shape::kCylinder, {width, height, width}};
    const Solid ball{Shape::kEllipsoid, Vector3d::Constant(stream.Uniform(1, 9))};
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
  // What is lowest of it is as far as it is high.
  Stream stream(5);
  const Solid floor{Shape::kCuboid, {1000, 10, 1000}};
  for (int i = 0; i < 3000; ++i) {
    const Solid solid = RandomSolid(stream, test::kConvexShapes[i % 6], 50);
    const double gap = stream.LogUniform(1e-6, 100);
    const Quaterniond turn = stream.Turn();
    const double lowest = Bounds(solid, turn).lower.y();
    const Motion move = RandomMotion(stream, 10);
    ExpectDistance(floor, move({}), solid,
                   move({{stream.Uniform(-90, 90), 5 + gap - lowest, 3}, turn}), gap);
  }
}

TEST(Distance, TipsOfCones) {
  const Solid cone{Shape::kCone, {2, 8, 4}};
  const Quaterniond over(Eigen::AngleAxisd(std::acos(-1.0), Vector3d::UnitX()));
  // Tip against tip, 6 above each centre of mass; tip above a base, 2 below it.
  ExpectDistance(cone, {}, cone, {{0, 12.25, 0}, over}, 0.25);
  ExpectDistance(cone, {}, cone, {{0, 8.25, 0}, Quaterniond::Identity()}, 0.25);
}

TEST(Distance, OfCompoundsGoesThroughTheHole) {
  const Solid ring = test::Torus();
  const Solid ball{Shape::kEllipsoid, {1, 1, 1}};
  const double hole = Distance(ring, {}, {Shape::kEllipsoid, {1e-9, 1e-9, 1e-9}}, {});
  EXPECT_GT(hole, 0.9);
  EXPECT_LE(hole, 1);
  EXPECT_NEAR(Distance(ring, {}, ball, {}), hole - 0.5, 1e-9);
  EXPECT_FALSE(Overlap(ring, {}, ball, {}));
  EXPECT_TRUE(Overlap(ring, {}, ball, {{0.9, 0, 0}, Quaterniond::Identity()}));
}

TEST(Distance, PropertiesForAllPairs) {
  Stream stream(6);
  std::vector<Solid> solids = {test::Torus()};
  for (const double most : {1.0, 3.0, 50.0})
    for (const Shape shape : test::kConvexShapes)
      solids.push_back(RandomSolid(stream, shape, most));
  int apart = 0, overlapping = 0;
  for (const Solid& a : solids) {
    for (const Solid& b : solids) {
      for (int i = 0; i < 10; ++i) {
        const double size = SizeOf(a, b);
        const Pose pa{Vector3d::Zero(), stream.Turn()};
        const double away = stream.LogUniform(0.1, 2);
        const Pose pb{RandomDirection(stream) * size * away, stream.Turn()};
        const double distance = Distance(a, pa, b, pb);
        const double exact = kExact * (size + distance);
        ASSERT_EQ(distance > 0, !Overlap(a, pa, b, pb));
        (distance > 0 ? apart : overlapping) += 1;
        ASSERT_NEAR(Distance(b, pb, a, pa), distance, exact);
        const Motion move = RandomMotion(stream, size);
        ASSERT_NEAR(Distance(a, move(pa), b, move(pb)), distance, 10 * exact);
        // As much as b moves, and no more.
        const double step = stream.LogUniform(1e-6, 1) * size;
        const Pose moved{pb.position + step * RandomDirection(stream), pb.orientation};
        ASSERT_LE(std::abs(Distance(a, pa, b, moved) - distance), step + exact);
        // No plane keeps them farther apart.
        const Vector3d normal = RandomDirection(stream);
        const auto reach = [&](const Solid& solid, const Pose& pose, const Vector3d& direction) {
          return direction.dot(pose.position) +
                 direction.dot(pose.orientation *
                               solid.Support(pose.orientation.conjugate() * direction));
        };
        ASSERT_LE(-reach(b, pb, -normal) - reach(a, pa, normal), distance + exact);
      }
    }
  }
  EXPECT_GT(apart, 500);
  EXPECT_GT(overlapping, 500);
}

TEST(Approach, IsAsNearAsAskedAndWasNeverNearer) {
  Stream stream(7);
  std::vector<Solid> solids = {test::Torus()};
  for (const Shape shape : test::kConvexShapes) {
    solids.push_back(RandomSolid(stream, shape, 1));
    solids.push_back(RandomSolid(stream, shape, 20));
  }
  int passed_by = 0;
  for (const Solid& a : solids) {
    for (const Solid& b : solids) {
      for (const double times : {1e-6, 1e-3, 0.1, 100.0}) {
        const double size = SizeOf(a, b), wanted = times * size;
        const Vector3d direction = RandomDirection(stream);
        const Pose pa{Vector3d::Zero(), stream.Turn()};
        Pose pb{Vector3d::Zero(), stream.Turn()};
        const auto apart = Approach(a, pa, b, pb, direction, wanted);
        if (!apart) {
          ++passed_by;
          EXPECT_TRUE(a.compound || b.compound);
          continue;
        }
        pb.position = *apart * direction;
        ASSERT_NEAR(Distance(a, pa, b, pb), wanted, kExact * (size + wanted));
        for (int i = 1; i <= 20; ++i) {
          pb.position = (*apart + i * 0.1 * size) * direction;
          ASSERT_GE(Distance(a, pa, b, pb), wanted);
        }
      }
    }
  }
  EXPECT_LT(passed_by, 20);
}

TEST(Approach, PassesThroughAHole) {
  const Solid ring = test::Torus();
  const Solid ball{Shape::kEllipsoid, {1, 1, 1}};
  // The ring's axis is y in its mesh.
  const Vector3d axis = ring.compound->from_mesh() * Vector3d::UnitY();
  const Vector3d across = ring.compound->from_mesh() * Vector3d::UnitX();
  EXPECT_FALSE(Approach(ring, {}, ball, {}, axis, 0.1));
  EXPECT_TRUE(Approach(ring, {}, ball, {}, axis, 0.6));
  EXPECT_NEAR(Approach(ring, {}, ball, {}, across, 0.1).value(), 2.6, 0.05);
}

}  // namespace
}  // namespace cdb::library
