#include "library/layouts/placement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "library/distributions/stream.h"
#include "library/layouts/clearance.h"
#include "library/objects/distance.h"
#include "library/scene_error.h"
#include "tests/library/layouts/layout_scene.h"
#include "tests/support/sanitizers.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

/// A cube in which `quantity` equal objects of 50 m fill the fraction `fill`.
plan::Scene FilledScene(std::uint64_t quantity, double fill, const char* type) {
  plan::Scene scene = DefaultScene(quantity, 1e6);
  SetGroup(scene, "type", Word(type));
  SetWorld(scene, "world.side", 1e6 * std::cbrt(layouts::DrawObjects(scene).fill_fraction / fill));
  return scene;
}

/// Checks pair by pair that no objects touch.
void ExpectFree(const plan::Scene& scene, const layouts::InitialState& state) {
  const double half = scene.world.Real("world.side") / 2;
  for (std::size_t i = 0; i < state.objects.size(); ++i) {
    const layouts::ObjectState& a = state.objects[i];
    const objects::Box box = objects::Bounds(a.solid, a.pose.orientation);
    EXPECT_LT((a.pose.position + box.upper).maxCoeff(), half);
    EXPECT_GT((a.pose.position + box.lower).minCoeff(), -half);
  }
  ForEachNear(state, [&](std::size_t i, std::size_t j) {
    const layouts::ObjectState &a = state.objects[i], &b = state.objects[j];
    ASSERT_FALSE(objects::Overlap(a.solid, a.pose, b.solid, b.pose)) << i << " and " << j;
  });
}

TEST(Placement, NothingTouches) {
  for (const char* layout : {"uniform", "normal"}) {
    plan::Scene scene = DefaultScene(300, 700);
    SetGroup(scene, "type", AnyType());
    SetGroup(scene, "size", Uniform(10.0, 90.0));
    SetGroup(scene, "orientation", Word("random"));
    SetGroup(scene, "location", Word(layout));
    ExpectFree(scene, layouts::MakeInitialState(scene));
  }
}

TEST(Placement, LongThinObjects) {
  plan::Scene scene = DefaultScene(400, 500);
  SetGroup(scene, "type", AnyType());
  SetGroup(scene, "size", 4.0);
  SetGroup(scene, "aspect", schema::Ratio{Vector3d(1, 1, 50)});
  SetGroup(scene, "orientation", Word("random"));
  ExpectFree(scene, layouts::MakeInitialState(scene));
}

TEST(Placement, GroupsKeepClearOfEachOther) {
  plan::Scene scene = DefaultScene(20, 600);
  scene.groups.push_back(scene.groups[0]);
  scene.groups[1].name = "pebbles";
  SeedStreams(scene);
  SetGroup(scene, "size", 120.0, 0);
  SetGroup(scene, "size", 10.0, 1);
  SetGroup(scene, "quantity", std::uint64_t{400}, 1);
  SetGroup(scene, "type", Word("cuboid"), 1);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  ASSERT_EQ(state.objects.size(), 420u);
  EXPECT_EQ(state.objects[0].group, 0u);
  EXPECT_EQ(state.objects[419].group, 1u);
  ExpectFree(scene, state);
}

TEST(Placement, InsideTheCubeAlsoWithoutWallsAndForFixedObjects) {
  for (const char* walls : {"none", "floor"}) {
    plan::Scene scene = DefaultScene(50, 300);
    SetWorld(scene, "world.walls", Word(walls));
    SetGroup(scene, "mass", Word("fixed"));
    ExpectFree(scene, layouts::MakeInitialState(scene));
  }
}

TEST(Placement, NoObjects) {
  const layouts::InitialState state = layouts::MakeInitialState(DefaultScene(0, 500));
  EXPECT_TRUE(state.objects.empty());
  EXPECT_EQ(state.fill_fraction, 0);
}

TEST(Placement, UniformIsUniformWhereTheObjectFits) {
  const plan::Scene scene = DefaultScene(20000, 1e6);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const double reach = 1e6 / 2 - 25;
  for (int axis = 0; axis < 3; ++axis) {
    // The mean of n has the standard deviation reach sqrt(1/(3 n)); x^2 has the mean reach^2/3 and
    // the variance reach^4 4/45. Five standard deviations.
    double mean = 0, square = 0;
    for (const layouts::ObjectState& object : state.objects) {
      mean += object.pose.position[axis] / reach / 20000;
      square += std::pow(object.pose.position[axis] / reach, 2) / 20000;
    }
    EXPECT_NEAR(mean, 0, 5 * std::sqrt(1 / (3 * 20000.0)));
    EXPECT_NEAR(square, 1.0 / 3, 5 * std::sqrt(4.0 / 45 / 20000));
  }
}

TEST(Placement, NormalHasAThirdOfTheWallsCoordinate) {
  plan::Scene scene = DefaultScene(20000, 1e6);
  SetGroup(scene, "location", Word("normal"));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const double deviation = 1e6 / 2 / 3;
  // Cut at three standard deviations: variance 1 - 2 * 3 phi(3)/(2 Phi(3) - 1).
  const double phi = std::exp(-4.5) / std::sqrt(2 * std::numbers::pi);
  const double variance = 1 - 6 * phi / std::erf(3 / std::numbers::sqrt2);
  for (int axis = 0; axis < 3; ++axis) {
    double mean = 0, square = 0;
    for (const layouts::ObjectState& object : state.objects) {
      mean += object.pose.position[axis] / deviation / 20000;
      square += std::pow(object.pose.position[axis] / deviation, 2) / 20000;
    }
    EXPECT_NEAR(mean, 0, 5 * std::sqrt(1 / 20000.0));
    EXPECT_NEAR(square, variance, 5 * std::sqrt(2 / 20000.0));
  }
}

TEST(Placement, TooFullSaysHowFullAndWhatToChange) {
  // 500 balls of 50 m in a cube of 400 m: 51 %, more than random placement can fill.
  const std::string message = FailureOf(DefaultScene(500, 400));
  EXPECT_NE(message.find("51.1 % of the cube"), std::string::npos) << message;
  EXPECT_NE(message.find("world.side"), std::string::npos) << message;
  EXPECT_NE(message.find("of 500 (group `objects`)"), std::string::npos) << message;
}

TEST(Placement, TheSideThatItProposesWorks) {
  const std::string message = FailureOf(DefaultScene(500, 400));
  const std::size_t at = message.find("make world.side larger (");
  ASSERT_NE(at, std::string::npos) << message;
  const double side =
      std::stod(message.substr(at + std::string("make world.side larger (").size()));
  EXPECT_EQ(FailureOf(DefaultScene(500, side)), "");
}

TEST(Placement, LargerThanTheCube) {
  plan::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "size", 501.0);
  for (const char* layout : {"uniform", "normal"}) {
    for (const char* walls : {"all", "none"}) {
      SetGroup(scene, "location", Word(layout));
      SetWorld(scene, "world.walls", Word(walls));
      const std::string message = FailureOf(scene);
      EXPECT_NE(message.find("is 501 m long along x and does not fit"), std::string::npos)
          << message;
    }
  }
  SetGroup(scene, "size", 499.0);
  EXPECT_EQ(FailureOf(scene), "");
}

TEST(Placement, ATinyGapForANormalLayoutEnds) {
  plan::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "size", 500 - 1e-9);
  SetGroup(scene, "location", Word("normal"));
  EXPECT_NE(FailureOf(scene), "");
}

TEST(Placement, DenseFills) {
  struct {
    std::uint64_t quantity;
    double fill;
    const char* type;
  } const cases[] = {{2000, .30, "sphere"}, {4000, .35, "sphere"}, {2000, .38, "cuboid"}};
  for (const auto& [quantity, fill, type] : cases) {
    if (kAddressSanitizer && quantity > 2000) continue;  // slow, and covers no other code
    const plan::Scene scene = FilledScene(quantity, fill, type);
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    EXPECT_NEAR(state.fill_fraction, fill, 1e-9);
    ExpectFree(scene, state);
    const layouts::InitialState again = layouts::MakeInitialState(scene);
    for (std::size_t i = 0; i < quantity; ++i)
      ASSERT_EQ(state.objects[i].pose.position, again.objects[i].pose.position);
  }
}

TEST(Placement, DenseAndMixed) {
  // Denser than plain redrawing can place, with boxes of all sizes and orientations.
  plan::Scene scene = DefaultScene(300, 1);
  SetGroup(scene, "type", AnyType());
  SetGroup(scene, "size", Uniform(10.0, 40.0));
  SetGroup(scene, "orientation", Word("random"));
  SetWorld(scene, "world.side", std::cbrt(layouts::DrawObjects(scene).fill_fraction / .15));
  ExpectFree(scene, layouts::MakeInitialState(scene));
}

TEST(Placement, SaturationIsProvenAndSaysHowFullItGot) {
  for (const char* type : {"sphere", "cuboid"}) {
    const plan::Scene scene = FilledScene(900, .42, type);
    layouts::InitialState state = layouts::DrawObjects(scene);
    std::string message;
    try {
      layouts::Place(scene, state);
    } catch (const library::SceneError& error) {
      message = error.what();
    }
    const std::size_t at = message.find(" % was filled when no free position was left");
    ASSERT_NE(at, std::string::npos) << message;
    const double filled = std::stod(message.substr(message.rfind(' ', at - 1)));
    EXPECT_GT(filled, 30) << message;
    EXPECT_LT(filled, 42) << message;
    // The proof is right: no draw finds a free position among the objects placed so far.
    const std::size_t stand =
        std::stoul(message.substr(message.find("object ") + std::string("object ").size())) - 1;
    const double side = scene.world.Real("world.side");
    const objects::Box bounds =
        objects::Bounds(state.objects[0].solid, state.objects[0].pose.orientation);
    layouts::BoxGrid grid(side, std::vector<double>(stand, 50));
    const auto box_at = [&](const Vector3d& place) {
      return objects::Box{place + bounds.lower, place + bounds.upper};
    };
    for (std::uint32_t i = 0; i < stand; ++i) grid.Add(i, box_at(state.objects[i].pose.position));
    distributions::Stream stream(8);
    const double reach = side / 2 - 25;
    for (int i = 0; i < Cases(300000); ++i) {
      objects::Pose pose;
      for (double& x : pose.position) x = stream.Uniform(-reach, reach);
      ASSERT_TRUE(grid.AnyOf(box_at(pose.position), [&](std::uint32_t j) {
        const layouts::ObjectState& other = state.objects[j];
        return objects::Overlap(other.solid, pose, other.solid, other.pose);
      }));
    }
  }
}

TEST(Placement, WhatCanNeverFitIsRefusedBeforeTheFirstDraw) {
  // Far too many for a test that places them one by one.
  for (const auto& [fill, type] : {std::pair(.45, "sphere"), std::pair(.50, "cuboid")}) {
    const std::string message = FailureOf(FilledScene(100000, fill, type));
    EXPECT_NE(message.find("the 100000 objects of group `objects` fill"), std::string::npos)
        << message;
    EXPECT_NE(message.find("none was placed"), std::string::npos) << message;
    EXPECT_NE(message.find("world.side"), std::string::npos) << message;
  }
  const std::string message = FailureOf(FilledScene(10, 1.05, "sphere"));
  EXPECT_NE(message.find("would fill 105 % of the cube"), std::string::npos) << message;
}

TEST(Placement, LongObjectsMayFillMoreThanCompactOnes) {
  // The objects are as long as the cube, so that they leave no gap along z: the limit for many
  // objects does not apply.
  plan::Scene scene = DefaultScene(1000, 500);
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", 10.0);
  SetGroup(scene, "aspect", schema::Ratio{Vector3d(1, 1, 49.9)});
  SetWorld(scene, "world.side", 500.0 * std::sqrt(.8));
  EXPECT_NE(FailureOf(scene).find("does not fit"), std::string::npos);
  SetWorld(scene, "world.side", 500.0);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  EXPECT_GT(state.fill_fraction, .39);
  ExpectFree(scene, state);
}

TEST(Placement, SameSceneSamePlaces) {
  plan::Scene scene = DefaultScene(100, 700);
  const layouts::InitialState a = layouts::MakeInitialState(scene),
                              b = layouts::MakeInitialState(scene);
  SeedStreams(scene, 5);
  const layouts::InitialState c = layouts::MakeInitialState(scene);
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(a.objects[i].pose.position, b.objects[i].pose.position);
    EXPECT_NE(a.objects[i].pose.position, c.objects[i].pose.position);
  }
}

TEST(Placement, FillFractionIsTheObjectsVolume) {
  const double expected = 10 * std::numbers::pi / 6 * std::pow(50, 3) / std::pow(500, 3);
  EXPECT_NEAR(layouts::MakeInitialState(DefaultScene(10, 500)).fill_fraction, expected, 1e-15);
}

TEST(FreeVoxels, HoldWhatIsNotCoveredAndEndEmpty) {
  // One ball of radius 1 about the origin covers all of the cube of half side 1 but its corners.
  const auto in_ball = [](const objects::Box& box) {
    return box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).norm() <= 1;
  };
  layouts::FreeVoxels voxels(Vector3d::Constant(-1), Vector3d::Constant(1), 0.25, 1000, in_ball);
  double before = 8;
  for (int level = 0; level < 4; ++level) {
    double volume = 0;
    Vector3d lowest = Vector3d::Ones(), highest = -lowest;
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      const objects::Box box = voxels.BoxOf(i);
      EXPECT_FALSE(in_ball(box));
      volume += (box.upper - box.lower).prod();
      lowest = lowest.cwiseMin(box.lower);
      highest = highest.cwiseMax(box.upper);
    }
    EXPECT_GT(volume, 8 - 4 * std::numbers::pi / 3);
    EXPECT_LT(volume, before);
    EXPECT_EQ(lowest, Vector3d::Constant(-1));
    EXPECT_EQ(highest, Vector3d::Constant(1));
    before = volume;
    ASSERT_TRUE(voxels.CanSplit());
    voxels.Split(in_ball);
  }
  EXPECT_NEAR(before, 8 - 4 * std::numbers::pi / 3, 0.5);
  const std::size_t size = voxels.size();
  const objects::Box last = voxels.BoxOf(size - 1);
  voxels.Remove(0);
  EXPECT_EQ(voxels.size(), size - 1);
  EXPECT_EQ(voxels.BoxOf(0).lower, last.lower);
  voxels.Split([](const objects::Box&) { return true; });
  EXPECT_TRUE(voxels.empty());
}

TEST(BoxGrid, FindsWhatOverlapsAndNothingElse) {
  distributions::Stream stream(3);
  std::vector<objects::Box> boxes;
  std::vector<double> extents;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d half(stream.LogUniform(0.1, 20), stream.LogUniform(0.1, 20), 1);
    const Vector3d at(stream.Uniform(-50, 50), stream.Uniform(-50, 50), stream.Uniform(-50, 50));
    boxes.push_back({at - half, at + half});
    extents.push_back(2 * half.maxCoeff());
  }
  layouts::BoxGrid grid(100, extents);
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    std::vector<std::uint32_t> expected, found;
    for (std::uint32_t j = 0; j < i; ++j)
      if ((boxes[j].lower.array() <= boxes[i].upper.array()).all() &&
          (boxes[j].upper.array() >= boxes[i].lower.array()).all())
        expected.push_back(j);
    grid.AnyOf(boxes[i], [&](std::uint32_t j) {
      const double near = 1e-6 * 100;
      EXPECT_LE((boxes[j].lower - boxes[i].upper).maxCoeff(), near);
      EXPECT_LE((boxes[i].lower - boxes[j].upper).maxCoeff(), near);
      if (std::ranges::find(expected, j) == expected.end()) return false;
      found.push_back(j);
      return false;
    });
    std::ranges::sort(found);
    const auto [first, last] = std::ranges::unique(found);
    found.erase(first, last);
    ASSERT_EQ(found, expected);
    grid.Add(i, boxes[i]);
  }
}

}  // namespace
}  // namespace cdb::tests
