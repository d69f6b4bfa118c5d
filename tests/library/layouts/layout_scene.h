// Scenes with layouts that have arguments.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "library/layouts/initial_state.h"
#include "library/objects/distance.h"
#include "library/scene_error.h"
#include "tests/support/scene.h"

namespace cdb::tests {

/// A scene with one group; see DefaultScene.
inline plan::Scene LayoutScene(std::uint64_t quantity, double side, schema::Value layout) {
  plan::Scene scene = DefaultScene(quantity, side);
  SetGroup(scene, "size", 1.0);
  SetGroup(scene, "location", std::move(layout));
  return scene;
}

/// The layout `at` with a point for each object.
inline schema::Value Points(const std::vector<Eigen::Vector3d>& points) {
  return schema::Call{"at", {points.begin(), points.end()}};
}

/// Adds a group like the last one; returns its index.
inline std::size_t AddGroup(plan::Scene& scene, std::string name, std::uint64_t quantity,
                            schema::Value layout) {
  scene.groups.push_back(scene.groups.back());
  scene.groups.back().name = std::move(name);
  const std::size_t index = scene.groups.size() - 1;
  SetGroup(scene, "quantity", quantity, index);
  SetGroup(scene, "location", std::move(layout), index);
  SeedStreams(scene);
  return index;
}

/// Gives the group objects of every type, size, aspect ratio and orientation.
inline void MixObjects(plan::Scene& scene, std::size_t group = 0) {
  schema::Distribution types{schema::DistributionKind::kAny, {}, {}};
  for (const char* type :
       {"sphere", "cuboid", "cylinder", "cone", "capsule", "tetrahedron", "torus"}) {
    types.arguments.push_back(Word(type));
    types.weights.push_back(1);
  }
  SetGroup(scene, "type", types, group);
  SetGroup(scene, "size", Uniform(0.3, 1.0), group);
  SetGroup(scene, "aspect", schema::Ratio{Eigen::Vector3d(1, 0.5, 2)}, group);
  SetGroup(scene, "orientation", Word("random"), group);
}

/// Calls `check(i, j)` for each two objects that are close enough to touch, found by a sweep along
/// x.
template <typename Check>
void ForEachNear(const layouts::InitialState& state, Check check) {
  struct Extent {
    double low, high;  ///< of the bounding sphere
    std::size_t object;
  };
  std::vector<Extent> along;
  for (const layouts::ObjectState& object : state.objects) {
    const double x = object.pose.position.x(), reach = object.solid.sides.norm();
    along.push_back({x - reach, x + reach, along.size()});
  }
  std::ranges::sort(along, {}, &Extent::low);
  for (std::size_t i = 0; i < along.size(); ++i)
    for (std::size_t j = i + 1; j < along.size() && along[j].low <= along[i].high; ++j)
      check(along[i].object, along[j].object);
}

/// Checks pair by pair that no moving object touches a wall or another object.
inline void ExpectNothingTouches(const plan::Scene& scene, const layouts::InitialState& state) {
  const double half = scene.world.Real("world.side") / 2;
  for (std::size_t i = 0; i < state.objects.size(); ++i) {
    const layouts::ObjectState& a = state.objects[i];
    if (!a.IsFixed()) {
      const objects::Box box = Bounds(a.solid, a.pose.orientation);
      EXPECT_LT((a.pose.position + box.upper).maxCoeff(), half) << i;
      EXPECT_GT((a.pose.position + box.lower).minCoeff(), -half) << i;
    }
  }
  ForEachNear(state, [&](std::size_t i, std::size_t j) {
    const layouts::ObjectState &a = state.objects[i], &b = state.objects[j];
    if (a.IsFixed() && b.IsFixed()) return;
    ASSERT_FALSE(Overlap(a.solid, a.pose, b.solid, b.pose)) << i << " and " << j;
  });
}

/// The error of MakeInitialState for the scene; empty if there is none.
inline std::string FailureOf(const plan::Scene& scene) {
  try {
    layouts::MakeInitialState(scene);
  } catch (const library::SceneError& error) {
    return error.what();
  }
  return "";
}

}  // namespace cdb::tests
