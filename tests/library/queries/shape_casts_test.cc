// Sweeps and distances compared with overlap tests at many places.
#include "library/queries/shape_casts.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "library/distributions/stream.h"
#include "library/objects/distance.h"
#include "tests/library/objects/random_solids.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using objects::Pose;
using objects::Shape;
using objects::Solid;
using queries::Placed;

struct Case {
  Solid shape, body;
  Pose pose;  ///< of the body
  Vector3d from, along;
};

/// A shape that passes near a body of every kind.
Case RandomCase(distributions::Stream& stream, int i) {
  const auto shape_at = [](int index) {
    return objects::kClosedShapes[static_cast<std::size_t>(index) % objects::kClosedShapes.size()];
  };
  Case made;
  made.shape = RandomSolid(stream, shape_at(i), 2);
  made.body = i % 10 == 9 ? Torus() : RandomSolid(stream, shape_at(i / 6), 4);
  made.pose = {Vector3d(stream.Normal(), stream.Normal(), stream.Normal()), stream.Turn()};
  made.along = RandomDirection(stream);
  const double scale = made.body.OuterRadius();
  made.from = made.pose.position +
              0.5 * scale * Vector3d(stream.Normal(), stream.Normal(), stream.Normal()) -
              stream.Uniform(0, 4) * scale * made.along;
  return made;
}

bool OverlapAt(const Case& of, const Vector3d& position) {
  return objects::Overlap(of.shape, {position, Eigen::Quaterniond::Identity()}, of.body, of.pose);
}

TEST(ShapeCasts, StopWhereTheyFirstOverlap) {
  distributions::Stream stream(3);
  int hits = 0, begins = 0;
  for (int i = 0; i < 600; ++i) {
    const Case of = RandomCase(stream, i);
    const double length = 20;
    const auto touch = queries::SweepTo({of.shape, of.from}, of.along, length, of.body, of.pose);
    const double until = touch ? touch->distance : length;
    for (int step = 0; step < 300; ++step) {
      const double at = until * step / 300;
      if (at < until - 1e-9) {
        ASSERT_FALSE(OverlapAt(of, of.from + at * of.along)) << i << " at " << at;
      }
    }
    if (!touch) continue;
    ++hits;
    begins += touch->distance == 0;
    ASSERT_TRUE(OverlapAt(of, of.from + (touch->distance + 1e-9) * of.along)) << i;
    if (touch->distance == 0) continue;
    EXPECT_NEAR(touch->normal.norm(), 1, 1e-9);
    EXPECT_LT(touch->normal.dot(of.along), 0);
  }
  EXPECT_GT(hits, 150);
  EXPECT_LT(hits, 590);
  EXPECT_GT(begins, 10);
}

TEST(ShapeCasts, HaveTheDistanceOfTheSolids) {
  distributions::Stream stream(4);
  int apart = 0;
  for (int i = 0; i < 600; ++i) {
    const Case of = RandomCase(stream, i);
    const double distance =
        objects::Distance(of.shape, {of.from, Eigen::Quaterniond::Identity()}, of.body, of.pose);
    const Placed at = {of.shape, of.from};
    const auto touch = queries::DistanceTo(at, 100, of.body, of.pose);
    ASSERT_TRUE(touch);
    EXPECT_NEAR(touch->distance, distance, 1e-10);
    if (distance == 0) continue;
    ++apart;
    EXPECT_FALSE(queries::DistanceTo(at, 0.99 * distance, of.body, of.pose));
    // The normal points along the shortest way: half of the distance brings it half as near.
    EXPECT_NEAR(
        objects::Distance(of.shape,
                          {of.from - distance / 2 * touch->normal, Eigen::Quaterniond::Identity()},
                          of.body, of.pose),
        distance / 2, 1e-7 * (1 + distance));
    EXPECT_FALSE(OverlapAt(of, of.from - 0.999 * distance * touch->normal));
  }
  EXPECT_GT(apart, 200);
}

TEST(ShapeCasts, MeetAHalfSpaceWithTheirLowestPoint) {
  distributions::Stream stream(5);
  for (int i = 0; i < 300; ++i) {
    const Case of = RandomCase(stream, i);
    const exact::HalfSpace floor = {RandomDirection(stream), stream.Normal()};
    double lowest = std::numeric_limits<double>::infinity();
    // No point of the shape is below its support point, and points come near it.
    for (int j = 0; j < 2000; ++j)
      lowest =
          std::min(lowest, floor.normal.dot(of.from + of.shape.Support(RandomDirection(stream))));
    const auto touch = queries::DistanceTo({of.shape, of.from}, 1000, floor);
    if (!touch) continue;
    EXPECT_LE(touch->distance, std::max(0.0, lowest - floor.offset) + 1e-9);
    EXPECT_NEAR(touch->distance, std::max(0.0, lowest - floor.offset), 0.1);
    const auto swept = queries::SweepTo({of.shape, of.from}, of.along, 1000, floor);
    const double speed = -floor.normal.dot(of.along);
    if (touch->distance > 0 && speed > 1e-2) {
      EXPECT_NEAR(swept.value().distance * speed, touch->distance, 1e-9);
    } else if (touch->distance > 0 && speed < 0) {
      EXPECT_FALSE(swept);
    }
  }
}

}  // namespace
}  // namespace cdb::tests
