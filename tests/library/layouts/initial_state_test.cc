#include <gtest/gtest.h>

#include <cmath>

#include "library/layouts/initial_state.h"
#include "tests/library/layouts/layout_scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

schema::Value At(double x, double y, double z) {
  return Layout("at", {{"x", x}, {"y", y}, {"z", z}});
}

void SetFixedCuboid(plan::Scene& scene, const Vector3d& sides, std::size_t group) {
  SetGroup(scene, "type", Word("cuboid"), group);
  SetGroup(scene, "mass", Word("fixed"), group);
  SetGroup(scene, "aspect", schema::Ratio{sides}, group);
}

TEST(LayoutErrors, ObjectsOfOneGroup) {
  EXPECT_EQ(FailureOf(LayoutScene(2, 50, Layout("grid", {{"spacing", 0.75}}))),
            "object 2 of 2 (group `objects`) overlaps object 1 of 2 (group `objects`) by 0.25 m "
            "along the line between their centres of mass; make spacing larger (fit grows with "
            "world.side) or the size smaller");
  EXPECT_EQ(
      FailureOf(LayoutScene(8, 20, Layout("ring", {{"radius", 1.0}}))).substr(0, 85),
      "object 2 of 8 (group `objects`) overlaps object 1 of 8 (group `objects`) by 0.2346 m ");
  const std::string stack = FailureOf(
      LayoutScene(4, 20, Layout("stack", {{"height", std::uint64_t{2}}, {"spacing", 0.5}})));
  EXPECT_NE(stack.find("object 3 of 4 (group `objects`) overlaps object 1 of 4"), std::string::npos)
      << stack;
  EXPECT_NE(stack.find("make gap or spacing larger"), std::string::npos) << stack;
}

TEST(LayoutErrors, ObjectsOfTwoGroups) {
  plan::Scene scene = LayoutScene(1, 50, At(1, 2, 3));
  AddGroup(scene, "probe", 1, At(1, 2, 3.5));
  EXPECT_EQ(FailureOf(scene),
            "object 2 of 2 (group `probe`) overlaps object 1 of 2 (group `objects`) by 0.5 m along "
            "the line between their centres of mass; give one of the two groups another place");
  SetGroup(scene, "location", At(1, 2, 3), 1);
  EXPECT_NE(FailureOf(scene).find("by 1 m along the line"), std::string::npos);
  SetGroup(scene, "location", At(1, 2, 4 + 1e-6), 1);
  EXPECT_EQ(FailureOf(scene), "");
}

TEST(LayoutErrors, Walls) {
  EXPECT_EQ(FailureOf(LayoutScene(1, 10, At(0, 0, 4.75))),
            "object 1 of 1 (group `objects`) reaches 0.25 m through the cube's wall +z; move it "
            "inwards or make world.side larger");
  EXPECT_EQ(FailureOf(LayoutScene(1, 10, At(0, -8, 0))),
            "object 1 of 1 (group `objects`) lies 2.5 m beyond the cube's wall -y; move it inwards "
            "or make world.side larger");
  EXPECT_NE(FailureOf(LayoutScene(20, 10, Layout("stack")))
                .find("through the cube's wall +y; make "
                      "height, gap, spacing"),
            std::string::npos);
  plan::Scene open = LayoutScene(1, 10, At(0, 0, 4.75));
  SetWorld(open, "world.walls", Word("none"));
  EXPECT_NE(FailureOf(open), "");
}

/// A position in the corner -x -y -z of a cube of side 3 m. Its coordinates are no binary
/// fractions.
schema::Value InCorner(const Vector3d& sides, double above = 0) {
  const Vector3d place = Vector3d::Constant(-1.5) + sides / 2;
  return At(place.x(), place.y() + above, place.z());
}

TEST(Touching, WallsIsNoOverlap) {
  for (const double size : {0.1, 0.3, 0.7, 1.0, 3.0}) {
    plan::Scene scene = LayoutScene(1, 3, InCorner(Vector3d::Constant(size)));
    SetGroup(scene, "size", size);
    EXPECT_EQ(FailureOf(scene), "") << size;
    SetGroup(scene, "location", InCorner(Vector3d::Constant(size), -1e-12));
    EXPECT_NE(FailureOf(scene).find("reaches 1e-12 m through the cube's wall -y"),
              std::string::npos)
        << size << FailureOf(scene);
  }
  for (const char* layout : {"stack", "pyramid"}) {
    plan::Scene scene = LayoutScene(5, 20, Layout(layout, {{"gap", 0.0}}));
    SetGroup(scene, "type", Word("cuboid"));
    SetGroup(scene, "size", 0.7);
    EXPECT_EQ(FailureOf(scene), "") << layout;
  }
}

TEST(Touching, IsNotSaidWherePlacesAreCoarserThanObjects) {
  // Adjacent doubles are 0.06 m apart here, so the object has no exact position.
  EXPECT_NE(FailureOf(LayoutScene(1, 1e15, Layout("stack", {{"gap", 0.0}}))), "");
  EXPECT_EQ(FailureOf(LayoutScene(1, 1e7, Layout("stack", {{"gap", 0.0}}))), "");
}

TEST(Touching, ObjectsIsNoOverlap) {
  for (const char* type : {"sphere", "cuboid", "cylinder", "cone", "capsule", "torus"}) {
    plan::Scene scene = LayoutScene(8, 50, Layout("grid", {{"spacing", 0.7}}));
    SetGroup(scene, "type", Word(type));
    SetGroup(scene, "size", 0.7);
    EXPECT_EQ(FailureOf(scene), "") << type;
    SetGroup(scene, "location", Layout("grid", {{"spacing", 0.7 - 1e-11}}));
    plan::Scene pair = LayoutScene(2, 50, Layout("pair", {{"distance", 0.0}}));
    SetGroup(pair, "type", Word(type));
    SetGroup(pair, "orientation", Word("random"));
    EXPECT_EQ(FailureOf(pair), "") << type;
    if (std::string(type) != "cone") {
      EXPECT_NE(FailureOf(scene).find("overlaps"), std::string::npos) << type;
    }
  }
}

TEST(Touching, IsSeenOffTheCentres) {
  // A wide plate lies on a small cube near its edge, and on its corner.
  for (const Vector3d& off : {Vector3d(49.8, 0, 0), Vector3d(50.1, 0, 50.1), Vector3d(0, 0, 3)}) {
    plan::Scene scene = LayoutScene(1, 300, At(off.x(), 0.35 - 10, off.z()));
    SetGroup(scene, "type", Word("cuboid"));
    SetGroup(scene, "size", 0.7);
    const std::size_t plate = AddGroup(scene, "plate", 1, At(0, 0.7 + 0.05 - 10, 0));
    SetGroup(scene, "size", 100.0, plate);
    SetGroup(scene, "aspect", schema::Ratio{{1, 0.001, 1}}, plate);
    EXPECT_EQ(FailureOf(scene), "") << off.transpose();
    SetGroup(scene, "location", At(0, 0.7 + 0.05 - 10 - 1e-10, 0), plate);
    EXPECT_NE(FailureOf(scene).find("overlaps"), std::string::npos) << off.transpose();
  }
  // A ball on the edge of a cuboid.
  plan::Scene scene = LayoutScene(1, 50, At(0, 0, 0));
  SetGroup(scene, "type", Word("cuboid"));
  const double out = 0.5 + 0.5 * std::sqrt(0.5);
  const std::size_t ball = AddGroup(scene, "ball", 1, At(out, out, 0.3));
  SetGroup(scene, "type", Word("sphere"), ball);
  EXPECT_EQ(FailureOf(scene), "");
  SetGroup(scene, "location", At(out - 1e-11, out, 0.3), ball);
  EXPECT_NE(FailureOf(scene).find("overlaps"), std::string::npos);
}

TEST(LayoutErrors, Quantities) {
  EXPECT_EQ(FailureOf(LayoutScene(3, 10, At(0, 0, 0))),
            "group `objects` has 3 objects, but `at` places one object; make the quantity 1, or "
            "list a point for each object");
  EXPECT_EQ(
      FailureOf(LayoutScene(3, 10, Points({{0, 0, 0}, {2, 0, 0}}))),
      "group `objects` has 3 objects, but `at` places 2 objects; list a point for each object");
  const schema::Value pair = Layout("pair", {{"distance", 1.0}});
  for (const std::uint64_t quantity : {1, 3})
    EXPECT_NE(FailureOf(LayoutScene(quantity, 10, pair)).find("`pair` takes two objects"),
              std::string::npos);
  for (const char* layout : {"grid", "stack", "pyramid", "pile", "ring"})
    EXPECT_EQ(FailureOf(LayoutScene(0, 10, Layout(layout))), "") << layout;
}

TEST(LayoutErrors, Piles) {
  EXPECT_EQ(FailureOf(LayoutScene(3, 10, Layout("pile", {{"width", 1.0}}))),
            "the pile of group `objects` is 1 m wide, and its largest object needs 1.05 m to turn "
            "in; make width larger or the size smaller");
  EXPECT_EQ(FailureOf(LayoutScene(10, 10, Layout("pile", {{"width", 1.5}}))),
            "the 10 objects of group `objects` are dropped from 10 layers, 10.5 m high together, "
            "and the cube is 10 m high; make width or world.side larger, or the size or the "
            "quantity smaller");
  EXPECT_EQ(FailureOf(LayoutScene(10, 100, Layout("pile", {{"width", 1e300}}))), "");
}

TEST(LayoutErrors, PairThatNeverComesSoNear) {
  // Two balls come this close in any direction; only objects with holes could miss each other.
  EXPECT_EQ(FailureOf(LayoutScene(2, 1e6, Layout("pair", {{"distance", 1e5}}))), "");
  EXPECT_NE(FailureOf(LayoutScene(2, 10, Layout("pair", {{"distance", 1e5}})))
                .find("make distance or the size smaller"),
            std::string::npos);
}

TEST(LayoutErrors, FixedObjectsMayOverlapAndLeaveTheCube) {
  plan::Scene scene = LayoutScene(27, 3, Layout("grid", {{"spacing", 1.0}}));
  SetFixedCuboid(scene, Vector3d::Ones(), 0);
  EXPECT_EQ(FailureOf(scene), "");
  AddGroup(scene, "far", 1, At(1e6, 0.5, 0));
  AddGroup(scene, "inside", 1, At(0.3, 0.2, 0));
  EXPECT_EQ(FailureOf(scene), "");
  // But no moving object may overlap them, whichever comes first.
  AddGroup(scene, "probe", 1, At(0.1, 0.05, 0.1));
  SetGroup(scene, "mass", 1.0, 3);
  std::string message = FailureOf(scene);
  EXPECT_NE(message.find("object 30 of 30 (group `probe`) overlaps"), std::string::npos) << message;
  std::swap(scene.groups[0], scene.groups[3]);
  message = FailureOf(scene);
  EXPECT_NE(message.find("overlaps object 1 of 30 (group `probe`)"), std::string::npos) << message;
}

TEST(LayoutErrors, ObjectsMayOverlapWhereBothSaySo) {
  plan::Scene scene = LayoutScene(2, 50, Layout("line", {{"gap", -0.25}}));
  EXPECT_EQ(FailureOf(scene),
            "object 2 of 2 (group `objects`) overlaps object 1 of 2 (group `objects`) by 0.25 m "
            "along the line between their centres of mass; make gap larger, or write overlap on");
  SetGroup(scene, "overlap", true);
  EXPECT_EQ(FailureOf(scene), "");
  // They overlap each other; they may overlap another group only if it agrees.
  SetGroup(scene, "location", Layout("line", {{"gap", -1.0}}));
  EXPECT_EQ(FailureOf(scene), "");
  const std::size_t other = AddGroup(scene, "others", 1, At(0, 0, 0));
  EXPECT_EQ(FailureOf(scene), "");
  SetGroup(scene, "overlap", false, other);
  EXPECT_NE(FailureOf(scene).find("give one of the two groups another place"), std::string::npos);
  // Drawn objects still get free positions, and walls still apply.
  SetGroup(scene, "location", Word("uniform"), other);
  EXPECT_EQ(FailureOf(scene), "");
  SetGroup(scene, "location", Layout("line", {{"gap", 60.0}}));
  EXPECT_NE(FailureOf(scene).find("beyond the cube's wall"), std::string::npos);
}

TEST(LayoutErrors, AFixedGroupThatIsDrawnStaysInside) {
  plan::Scene scene = LayoutScene(1, 10, Word("uniform"));
  SetFixedCuboid(scene, {11, 1, 1}, 0);
  EXPECT_NE(FailureOf(scene).find("does not fit between walls"), std::string::npos);
}

TEST(LayoutErrors, LargeAmongSmallIsFound) {
  // A plate of 100 m through a lattice of 1000 balls, whichever comes first.
  for (const bool plate_first : {false, true}) {
    plan::Scene scene = LayoutScene(1000, 50, Layout("grid"));
    AddGroup(scene, "plate", 1, At(0, 2.5, 0));
    SetFixedCuboid(scene, {100, 0.1, 100}, 1);
    if (plate_first) std::swap(scene.groups[0], scene.groups[1]);
    EXPECT_NE(FailureOf(scene).find("overlaps"), std::string::npos);
    SetGroup(scene, "location", At(0, 0, 0), plate_first ? 0 : 1);
    EXPECT_EQ(FailureOf(scene), "");
  }
}

TEST(LayoutErrors, WhatIsInAHoleIsFree) {
  plan::Scene scene = LayoutScene(1, 50, At(1, 2, 3));
  SetGroup(scene, "type", Word("torus"));
  SetGroup(scene, "size", 10.0);
  AddGroup(scene, "ball", 1, At(1, 2, 3));
  SetGroup(scene, "type", Word("sphere"), 1);
  SetGroup(scene, "size", 4.0, 1);
  EXPECT_EQ(FailureOf(scene), "");
  SetGroup(scene, "size", 5.5, 1);
  EXPECT_NE(FailureOf(scene).find("overlaps"), std::string::npos);
}

}  // namespace
}  // namespace cdb::tests
