// Points and paths in solids compared with the exact overlap test.
#include "runtime/engine/probes/press_watch.h"

#include <gtest/gtest.h>

#include "library/distributions/stream.h"
#include "library/objects/distance.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using objects::Shape;
using objects::Solid;

constexpr auto& kClosedForms = objects::kClosedShapes;

TEST(SolidCore, ContainsThePointsThatOverlapIt) {
  distributions::Stream stream(1);
  for (const Shape shape : kClosedForms) {
    const Solid solid{shape, {1, 3, 2}};
    int inside = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vector3d point(stream.Uniform(-0.6, 0.6), stream.Uniform(-2.4, 2.4),
                           stream.Uniform(-1.2, 1.2));
      const Solid dot{Shape::kEllipsoid, Vector3d::Constant(1e-9)};
      const bool overlaps =
          objects::Overlap(solid, {}, dot, {point, Eigen::Quaterniond::Identity()});
      inside += overlaps;
      EXPECT_EQ(probes::Contains(solid, point), overlaps)
          << static_cast<int>(shape) << " at " << point.transpose();
    }
    EXPECT_GT(inside, 100);
    EXPECT_LT(inside, 1900);
  }
}

TEST(SolidCore, MeetsPathsThatHaveAPointInside) {
  distributions::Stream stream(2);
  for (const Shape shape : kClosedForms) {
    const Solid solid{shape, {1, 3, 2}};
    const auto anywhere = [&] {
      return Vector3d(stream.Uniform(-1, 1), stream.Uniform(-3, 3), stream.Uniform(-2, 2));
    };
    int met = 0;
    for (int i = 0; i < 300; ++i) {
      const Vector3d from = anywhere(), to = anywhere();
      bool has_point = false;
      for (int k = 0; k <= 400; ++k)
        has_point = has_point ||
                    probes::Contains(probes::CoreOf(solid, 0.01), from + k / 400.0 * (to - from));
      if (has_point) {
        EXPECT_TRUE(probes::MeetsPath(solid, from, to));
      }
      met += probes::MeetsPath(solid, from, to);
    }
    EXPECT_GT(met, 20);
    EXPECT_LT(met, 280);
  }
  const Solid plate{Shape::kCuboid, {0.1, 4, 4}};
  EXPECT_TRUE(probes::MeetsPath(plate, {-1, 1.9, 0}, {1, 1.9, 0}));
  EXPECT_FALSE(probes::MeetsPath(plate, {-1, 2.1, 0}, {1, 2.1, 0}));
  EXPECT_FALSE(probes::MeetsPath(plate, {-1, 0, 0}, {-0.06, 0, 0}));
}

}  // namespace
}  // namespace cdb::tests
