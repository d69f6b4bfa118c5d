// Values drawn for an object: sizes from a single draw, masses from densities.
#include <gtest/gtest.h>

#include <cmath>

#include "library/layouts/initial_state.h"
#include "tests/library/layouts/layout_scene.h"

namespace cdb::tests {
namespace {

TEST(DrawnObjects, SameIsOneDrawForAllSides) {
  plan::Scene scene = DefaultScene(1000, 500);
  SetGroup(scene, "size", Uniform(1.0, 5.0));
  const layouts::InitialState each = layouts::DrawObjects(scene);
  SetGroup(scene, "size", Layout("same", {{"value", Uniform(1.0, 5.0)}}));
  const layouts::InitialState same = layouts::DrawObjects(scene);
  int ellipsoids = 0;
  double sum = 0;
  for (std::size_t i = 0; i < 1000; ++i) {
    const Eigen::Vector3d& sides = same.objects[i].solid.sides;
    EXPECT_EQ(sides, Eigen::Vector3d::Constant(sides.x()));
    sum += sides.x();
    ellipsoids += each.objects[i].solid.sides.x() != each.objects[i].solid.sides.y();
    // The draws are consecutive values of the same stream.
    if (i < 333) {
      EXPECT_EQ(same.objects[3 * i].solid.sides.x(), each.objects[i].solid.sides.x());
    }
  }
  EXPECT_EQ(ellipsoids, 1000);
  EXPECT_NEAR(sum / 1000, 3, 5 * 4 / std::sqrt(12.0 * 1000));
}

TEST(DrawnObjects, AspectStillAppliesToSame) {
  plan::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "size", Layout("same", {{"value", 2.0}}));
  SetGroup(scene, "aspect", schema::Ratio{Eigen::Vector3d(1, 2, 3)});
  EXPECT_EQ(layouts::DrawObjects(scene).objects[0].solid.sides, Eigen::Vector3d(2, 4, 6));
}

TEST(DrawnObjects, DensityGivesTheMassOfTheVolume) {
  plan::Scene scene = DefaultScene(200, 500);
  MixObjects(scene);
  SetGroup(scene, "mass", Layout("density", {{"value", 2700.0}}));
  for (const layouts::ObjectState& object : layouts::DrawObjects(scene).objects) {
    EXPECT_GT(object.solid.Volume(), 0);
    EXPECT_EQ(object.mass, 2700.0 * object.solid.Volume());
  }
  SetGroup(scene, "type", Word("sphere"));
  SetGroup(scene, "aspect", schema::Ratio{Eigen::Vector3d(1, 1, 1)});
  SetGroup(scene, "size", 2.0);
  EXPECT_DOUBLE_EQ(layouts::DrawObjects(scene).objects[0].mass, 2700 * 4 * M_PI / 3);
}

TEST(DrawnObjects, DensitiesAreDrawn) {
  plan::Scene scene = DefaultScene(1000, 500);
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", 2.0);
  SetGroup(scene, "mass", Layout("density", {{"value", Uniform(100.0, 200.0)}}));
  double sum = 0;
  for (const layouts::ObjectState& object : layouts::DrawObjects(scene).objects) {
    EXPECT_GE(object.mass, 800);
    EXPECT_LE(object.mass, 1600);
    sum += object.mass / 1000;
  }
  EXPECT_NEAR(sum, 1200, 5 * 800 / std::sqrt(12.0 * 1000));
}

}  // namespace
}  // namespace cdb::tests
