// Points in solids compared with the exact overlap test.
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

TEST(SolidPoints, ContainsThePointsThatOverlapIt) {
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

}  // namespace
}  // namespace cdb::tests
