#include "library/layouts/emitter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "library/layouts/placement.h"
#include "tests/library/layouts/layout_scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

schema::Value BoxRegion(const Vector3d& lower, const Vector3d& upper) {
  return schema::Call{"box", {lower, upper}};
}

plan::Scene SpawningScene(std::uint64_t quantity, const Vector3d& half) {
  plan::Scene scene = DefaultScene(quantity, 100);
  SetGroup(scene, "size", 1.0);
  SetGroup(scene, "region", BoxRegion(-half, half));
  SetGroup(scene, "spawn.batch", std::uint64_t{1});
  SeedStreams(scene);
  return scene;
}

TEST(Emitter, PlacesTouchNothingAndLieInTheRegion) {
  plan::Scene scene = SpawningScene(300, Vector3d(4, 3, 5));
  MixObjects(scene);
  const std::size_t ground = AddGroup(scene, "ground", 1, Points({Vector3d(0.3, -1, 0.2)}));
  SetGroup(scene, "type", Word("cuboid"), ground);
  SetGroup(scene, "size", 4.0, ground);
  SetGroup(scene, "mass", Word("fixed"), ground);
  SetGroup(scene, "spawn.batch", Word("all"), ground);
  SetGroup(scene, "region", Word("cube"), ground);
  SeedStreams(scene);
  layouts::InitialState state = layouts::MakeInitialState(scene);
  EXPECT_TRUE(state.objects[0].pose.position.array().isNaN().all());
  EXPECT_EQ(state.objects[300].pose.position, Vector3d(0.3, -1, 0.2));

  layouts::Emitter emitter(scene, state.objects, 0);
  EXPECT_EQ(emitter.first(), 0u);
  EXPECT_EQ(emitter.end(), 300u);
  layouts::InitialState there;
  there.objects.push_back(state.objects[300]);
  // Emptied half-way: what is met again is still avoided.
  for (std::size_t i = 0; i < 300; ++i) {
    if (i % 50 == 0) {
      emitter.Begin();
      emitter.Meet(300, state.objects[300].pose);
      for (std::size_t k = 0; k < i; ++k)
        if (state.objects[k].pose.position.allFinite()) emitter.Meet(k, state.objects[k].pose);
    }
    const auto place = emitter.FindPlace(i);
    if (!place) continue;
    state.objects[i].pose.position = *place;
    const objects::Box box = Bounds(state.objects[i].solid, state.objects[i].pose.orientation);
    EXPECT_TRUE(((*place + box.upper).array() <= Vector3d(4, 3, 5).array()).all()) << i;
    EXPECT_TRUE(((*place + box.lower).array() >= Vector3d(-4, -3, -5).array()).all()) << i;
    there.objects.push_back(state.objects[i]);
  }
  EXPECT_GT(there.objects.size(), 200u);
  ExpectNothingTouches(scene, there);
}

// The mean and the variance of places of one object in an empty region.
TEST(Emitter, PlacesAreUniform) {
  const plan::Scene scene = SpawningScene(4000, Vector3d(2, 3, 4));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  layouts::Emitter emitter(scene, state.objects, 0);
  const Vector3d half(1.5, 2.5, 3.5);
  Vector3d sum = Vector3d::Zero(), squares = Vector3d::Zero();
  for (std::size_t i = 0; i < 4000; ++i) {
    emitter.Begin();
    const Vector3d place = emitter.FindPlace(i).value();
    sum += place;
    squares += place.cwiseAbs2();
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(sum[axis] / 4000, 0, 5 * half[axis] / std::sqrt(3 * 4000.0));
    EXPECT_NEAR(squares[axis] / 4000 / (half[axis] * half[axis] / 3), 1, 0.08);
  }
}

TEST(Emitter, FindsNoPlaceWhereThereIsNone) {
  const plan::Scene scene = SpawningScene(2, Vector3d(0.75, 0.75, 0.75));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  layouts::Emitter emitter(scene, state.objects, 0);
  emitter.Begin();
  emitter.Meet(0, {Vector3d::Zero(), Eigen::Quaterniond::Identity()});
  EXPECT_FALSE(emitter.FindPlace(1));
  emitter.Begin();
  emitter.Meet(0, {Vector3d(3, 0, 0), Eigen::Quaterniond::Identity()});
  EXPECT_TRUE(emitter.FindPlace(1));
}

TEST(Emitter, RefusesObjectsLargerThanTheRegion) {
  EXPECT_THAT(FailureOf(SpawningScene(1, Vector3d(0.4, 2, 2))),
              HasSubstr("does not fit into the region in which it spawns"));
  EXPECT_EQ(FailureOf(SpawningScene(1, Vector3d(0.6, 2, 2))), "");
}

// Far more than fit into the region, or the cube, at a time.
TEST(Emitter, QuantityIsNotLimitedByTheRoom) {
  plan::Scene scene = SpawningScene(100'000, Vector3d(2, 2, 2));
  SetWorld(scene, "world.side", 5.0);
  EXPECT_EQ(FailureOf(scene), "");
  EXPECT_EQ(layouts::DrawObjects(scene).fill_fraction, 0);
  std::uint64_t draws = 1000;
  layouts::CheckPlacement(scene, draws);
  EXPECT_EQ(draws, 1000u);
}

}  // namespace
}  // namespace cdb::tests
