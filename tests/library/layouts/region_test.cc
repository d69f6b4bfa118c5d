// Layouts in a region: where the objects are, and which regions are refused.
#include "library/layouts/region.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "library/layouts/placement.h"
#include "tests/library/layouts/layout_scene.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

const schema::Value kFit = Word("fit");

schema::Value BoxFrom(const Vector3d& lower, const Vector3d& upper) {
  return schema::Call{"box", {lower, upper}};
}

/// The box around the objects of group `index`.
objects::Box BoxAround(const layouts::InitialState& state, std::size_t index) {
  objects::Box all{Vector3d::Constant(HUGE_VAL), Vector3d::Constant(-HUGE_VAL)};
  for (const layouts::ObjectState& object : state.objects) {
    if (object.group != index) continue;
    const objects::Box box = Bounds(object.solid, object.pose.orientation);
    all.lower = all.lower.cwiseMin(object.pose.position + box.lower);
    all.upper = all.upper.cwiseMax(object.pose.position + box.upper);
  }
  return all;
}

/// Objects of every type in a group `objects`, and a fixed table of 8 x 3 x 6 m at `centre`, which
/// comes first.
plan::Scene TableScene(std::uint64_t quantity, schema::Value layout, const Vector3d& centre) {
  plan::Scene scene = LayoutScene(1, 40, Points({centre}));
  scene.groups[0].name = "table";
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "aspect", schema::Ratio{Vector3d(8, 3, 6)});
  SetGroup(scene, "mass", Word("fixed"));
  AddGroup(scene, "objects", quantity, std::move(layout));
  MixObjects(scene, 1);
  SetGroup(scene, "mass", 1.0, 1);
  return scene;
}

bool IsWithin(const objects::Box& inner, const objects::Box& outer) {
  return (inner.lower.array() >= outer.lower.array()).all() &&
         (inner.upper.array() <= outer.upper.array()).all();
}

std::vector<schema::Value> Layouts(bool are_small) {
  const schema::Value spacing = are_small ? schema::Value(0.9) : kFit;
  return {Word("uniform"),
          Word("normal"),
          schema::Call{"grid", {kFit}},
          schema::Call{"stack", {std::uint64_t{2}, kFit, spacing}},
          schema::Call{"pyramid", {kFit}},
          schema::Call{"ring", {kFit}},
          schema::Call{"line", {kFit, Vector3d(1, 0, 0)}}};
}

TEST(Region, OfABoxHoldsTheObjectsOfEveryLayout) {
  const Vector3d lower(2, -5, -18), upper(14, 5, -4);
  for (const schema::Value& layout : Layouts(false)) {
    plan::Scene scene = LayoutScene(8, 40, layout);
    MixObjects(scene);
    SetGroup(scene, "region", BoxFrom(lower, upper));
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    const objects::Box around = BoxAround(state, 0);
    EXPECT_TRUE(IsWithin(around, {lower, upper})) << ToText(layout);
    ExpectNothingTouches(scene, state);
  }
}

TEST(Region, CentresALayoutAndBearsAStack) {
  const Vector3d lower(2, -5, -18), upper(14, 5, -4), centre(8, 0, -11);
  plan::Scene scene = LayoutScene(8, 40, schema::Call{"grid", {2.0}});
  SetGroup(scene, "region", BoxFrom(lower, upper));
  objects::Box box = BoxAround(layouts::MakeInitialState(scene), 0);
  EXPECT_TRUE(((box.lower + box.upper) / 2).isApprox(centre, 1e-12));
  EXPECT_TRUE((box.upper - box.lower).isApprox(Vector3d::Constant(3), 1e-12));
  SetGroup(scene, "location", schema::Call{"stack", {Word("all"), 0.0, kFit}});
  box = BoxAround(layouts::MakeInitialState(scene), 0);
  EXPECT_TRUE(box.lower.isApprox(Vector3d(7.5, -5, -11.5), 1e-12));
  EXPECT_TRUE(box.upper.isApprox(Vector3d(8.5, 3, -10.5), 1e-12));
}

TEST(Region, OfTheFloorIsStoodUpon) {
  for (const schema::Value& layout : Layouts(false)) {
    plan::Scene scene = LayoutScene(12, 40, layout);
    MixObjects(scene);
    SetGroup(scene, "region", Word("floor"));
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    const objects::Box box = BoxAround(state, 0);
    EXPECT_GT(box.lower.y(), -20) << ToText(layout);
    EXPECT_LT(box.lower.y(), -20 + 2e-3 * 2) << ToText(layout);
    ExpectNothingTouches(scene, state);
    if (schema::AsCall(layout) != nullptr) continue;
    for (const layouts::ObjectState& object : state.objects) {
      const double bottom =
          object.pose.position.y() + Bounds(object.solid, object.pose.orientation).lower.y();
      EXPECT_LT(bottom, -20 + 1.5e-3 * 2);
    }
  }
}

TEST(Region, AboveAndOnAndBesideAGroup) {
  const Vector3d centre(5, -9, 2), half(4, 1.5, 3);
  const objects::Box table{centre - half, centre + half};
  const auto place = [&](const schema::Value& layout, schema::Value region) {
    plan::Scene scene = TableScene(5, layout, centre);
    SetGroup(scene, "region", std::move(region), 1);
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    ExpectNothingTouches(scene, state);
    return BoxAround(state, 1);
  };
  const schema::Value by_name = Word("table");
  for (const schema::Value& layout : Layouts(true)) {
    const objects::Box above = place(layout, schema::Call{"above", {by_name, kFit}});
    EXPECT_TRUE(IsWithin(above, {{1, -7.5, -1}, {9, 20, 5}})) << ToText(layout);
    const objects::Box on = place(layout, schema::Call{"on_top", {by_name}});
    EXPECT_TRUE(IsWithin(on, {{1, -7.5, -1}, {9, 20, 5}})) << ToText(layout);
    EXPECT_LT(on.lower.y(), -7.5 + 2e-3 * 2) << ToText(layout);
  }
  for (const char* layout : {"uniform", "normal"}) {
    EXPECT_TRUE(IsWithin(place(Word(layout), schema::Call{"above", {by_name, 3.0}}),
                         {{1, -7.5, -1}, {9, -4.5, 5}}));
    EXPECT_TRUE(IsWithin(place(Word(layout), schema::Call{"beside", {by_name, Word("right"), 4.0}}),
                         {{9, -10.5, -1}, {13, -7.5, 5}}));
    EXPECT_TRUE(
        IsWithin(place(Word(layout), schema::Call{"beside", {by_name, Vector3d(0, 0, -2), kFit}}),
                 {{1, -10.5, -20}, {9, -7.5, -1}}));
  }
  EXPECT_EQ(table.upper.y(), -7.5);
}

TEST(Region, DrawnPositionsFillIt) {
  plan::Scene scene = LayoutScene(4000, 100, Word("uniform"));
  SetGroup(scene, "size", 0.01);
  SetGroup(scene, "region", BoxFrom({10, -40, -50}, {30, -38, 0}));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  Vector3d mean = Vector3d::Zero();
  for (const layouts::ObjectState& object : state.objects) mean += object.pose.position / 4000;
  // Five standard errors of the mean: extent / sqrt(12 n).
  EXPECT_NEAR(mean.x(), 20, 5 * 20 / std::sqrt(12 * 4000.0));
  EXPECT_NEAR(mean.y(), -39, 5 * 2 / std::sqrt(12 * 4000.0));
  EXPECT_NEAR(mean.z(), -25, 5 * 50 / std::sqrt(12 * 4000.0));
}

TEST(Region, ThatCannotBeIsRefused) {
  const auto failure = [](schema::Value layout, schema::Value region) {
    plan::Scene scene = TableScene(5, std::move(layout), {5, -9, 2});
    SetGroup(scene, "region", std::move(region), 1);
    std::uint64_t draws = 1'000'000;
    std::string checked;
    try {
      layouts::CheckPlacement(scene, draws);
    } catch (const library::SceneError& error) {
      EXPECT_EQ(error.group(), "objects");
      checked = error.what();
    }
    EXPECT_EQ(checked, FailureOf(scene)) << "check says what a run says";
    return checked;
  };
  const auto expect = [&](schema::Value layout, schema::Value region, const char* part) {
    const std::string message = failure(std::move(layout), std::move(region));
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect(Word("uniform"), BoxFrom({0, 0, 0}, {1, -1, 1}), "is not below its upper one");
  expect(Word("uniform"), BoxFrom({0, 0, 0}, {1, 0.1, 1}), "does not fit into its region");
  expect(Word("uniform"), BoxFrom({30, 0, 0}, {40, 10, 10}), "does not fit into its region");
  expect(Word("uniform"), schema::Call{"above", {Word("chair"), kFit}}, "no group `chair`");
  expect(Word("uniform"), schema::Call{"above", {Word("objects"), kFit}}, "its own group");
  expect(Word("uniform"), schema::Call{"beside", {Word("table"), Vector3d(1, 1, 0), kFit}},
         "not along an axis");
  expect(Points({Vector3d(1, 2, 3)}), Word("floor"), "does not place");
  expect(schema::Call{"pile", {kFit}}, BoxFrom({0, 0, 0}, {9, 9, 9}), "does not place");
}

TEST(Region, ThatIsFullIsRefused) {
  plan::Scene scene = LayoutScene(60, 40, Word("uniform"));
  SetGroup(scene, "region", BoxFrom({0, 0, 0}, {3, 3, 3}));
  EXPECT_NE(FailureOf(scene).find("no free position"), std::string::npos);
  EXPECT_NE(FailureOf(scene).find("would fill 222 % of it"), std::string::npos) << FailureOf(scene);
  SetGroup(scene, "region", Word("floor"));
  SetWorld(scene, "world.side", 5.0);
  EXPECT_NE(FailureOf(scene).find("would fill 240 % of its floor"), std::string::npos);
  SetGroup(scene, "quantity", std::uint64_t{2000});
  SetWorld(scene, "world.side", 40.0);
  SetGroup(scene, "region", BoxFrom({0, 0, 0}, {6, 6, 6}));
  EXPECT_NE(FailureOf(scene).find("% of the region"), std::string::npos) << FailureOf(scene);
  SetGroup(scene, "quantity", std::uint64_t{8});
  EXPECT_EQ(FailureOf(scene), "");
}

TEST(Region, NamesAGroupThatIsPlacedBefore) {
  plan::Scene scene = TableScene(5, schema::Call{"grid", {kFit}}, {5, -9, 2});
  SetGroup(scene, "region", schema::Call{"above", {Word("objects"), kFit}});
  SetGroup(scene, "location", Word("uniform"));
  EXPECT_NE(FailureOf(scene).find("write `objects` first"), std::string::npos);
  SetGroup(scene, "region", Word("cube"));
  SetGroup(scene, "region", schema::Call{"above", {Word("table"), kFit}}, 1);
  EXPECT_NE(FailureOf(scene).find("placed at random"), std::string::npos);
  SetGroup(scene, "location", Word("uniform"), 1);
  SetGroup(scene, "region", schema::Call{"above", {Word("table"), 1.5}}, 1);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  EXPECT_GE(BoxAround(state, 1).lower.y(), BoxAround(state, 0).upper.y());
}

TEST(CheckPlacement, SaysWhatARunSaysOfACrowdedCube) {
  for (const char* type : {"cuboid", "sphere"}) {
    plan::Scene scene = LayoutScene(900, 10, Word("uniform"));
    SetGroup(scene, "type", Word(type));
    std::uint64_t draws = 50'000'000;
    const std::uint64_t before = draws;
    EXPECT_THROW(layouts::CheckPlacement(scene, draws), library::SceneError);
    EXPECT_LT(draws, before);
    // Too few draws to tell.
    draws = 100;
    EXPECT_NO_THROW(layouts::CheckPlacement(scene, draws));
    EXPECT_EQ(draws, 0u);
  }
  plan::Scene sparse = LayoutScene(100, 10, Word("uniform"));
  std::uint64_t draws = 1000;
  EXPECT_NO_THROW(layouts::CheckPlacement(sparse, draws));
  EXPECT_EQ(draws, 1000u) << "none needed";
}

TEST(CheckPlacement, RefusesNumbersThatThePrecisionCannotHold) {
  const auto expect = [](auto change) {
    plan::Scene scene = LayoutScene(1, 1e9, Points({Vector3d(1, 2, 3)}));
    change(scene);
    std::uint64_t draws = 0;
    try {
      layouts::CheckPlacement(scene, draws);
      ADD_FAILURE() << "it is accepted";
    } catch (const library::SceneError& error) {
      EXPECT_NE(std::string(error.what()).find("out of reach of single precision"),
                std::string::npos)
          << error.what();
    }
    SetWorld(scene, "precision", Word("double"));
    EXPECT_NO_THROW(layouts::CheckPlacement(scene, draws));
  };
  expect([](plan::Scene& scene) { SetGroup(scene, "mass", 1e39); });
  expect([](plan::Scene& scene) { SetGroup(scene, "mass", 1e-39); });
  expect([](plan::Scene& scene) { SetGroup(scene, "size", 1e-25); });
  expect([](plan::Scene& scene) { SetGroup(scene, "linear_velocity", Vector3d(0, 1e39, 0)); });
  expect([](plan::Scene& scene) { SetGroup(scene, "angular_velocity", Vector3d(-1e39, 0, 0)); });
  expect([](plan::Scene& scene) { SetWorld(scene, "acceleration", Vector3d(0, 0, 1e39)); });
  expect([](plan::Scene& scene) {
    SetWorld(scene, "world.side", 1e41);
    SetGroup(scene, "location", Points({Vector3d(1, 2, 1e39)}));
  });
}

TEST(CheckPlacement, RefusesASpringWithoutADirection) {
  plan::Scene scene = LayoutScene(2, 20, Points({Vector3d(1, 2, 3), Vector3d(1, 2, 3)}));
  SetGroup(scene, "overlap", true);
  SetGroup(scene, "links.type", Word("spring"));
  std::uint64_t draws = 0;
  EXPECT_THROW(layouts::CheckPlacement(scene, draws), library::SceneError);
  SetGroup(scene, "location", Points({Vector3d(1, 2, 3), Vector3d(1, 2, 3.1)}));
  EXPECT_NO_THROW(layouts::CheckPlacement(scene, draws));
}

}  // namespace
}  // namespace cdb::tests
