#include "library/layouts/exact_layouts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <utility>

#include "library/layouts/placement.h"
#include "library/objects/distance.h"
#include "tests/library/layouts/layout_scene.h"
#include "tests/library/objects/random_solids.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

constexpr double kPlacementError = 1e-12;

Vector3d BoxCentre(const layouts::ObjectState& object) {
  const objects::Box box = objects::Bounds(object.solid, object.pose.orientation);
  return object.pose.position + (box.lower + box.upper) / 2;
}

Vector3d Extents(const layouts::ObjectState& object) {
  const objects::Box box = objects::Bounds(object.solid, object.pose.orientation);
  return box.upper - box.lower;
}

double Bottom(const layouts::ObjectState& object) {
  return BoxCentre(object).y() - Extents(object).y() / 2;
}

void ExpectAt(const layouts::ObjectState& object, const Vector3d& centre) {
  EXPECT_LE((BoxCentre(object) - centre).norm(), kPlacementError * (1 + centre.norm()));
}

TEST(Layout, GridFillsTheCube) {
  // 3 cells along each edge for 10 objects: a layer of 9, and one.
  const layouts::InitialState state = layouts::MakeInitialState(LayoutScene(10, 6, Layout("grid")));
  ExpectAt(state.objects[0], {-2, -2, -2});
  ExpectAt(state.objects[1], {0, -2, -2});
  ExpectAt(state.objects[3], {-2, -2, 0});
  ExpectAt(state.objects[8], {2, -2, 2});
  ExpectAt(state.objects[9], {-2, 0, -2});
  // A full cube needs no larger lattice.
  const layouts::InitialState full = layouts::MakeInitialState(LayoutScene(27, 6, Layout("grid")));
  ExpectAt(full.objects[26], {2, 2, 2});
}

schema::Value RelativeTo(std::string_view group, const Vector3d& offset) {
  return schema::Call{"relative_to", {Word(group), schema::Value(offset)}};
}

TEST(Layout, RelativeToIsInTheFrameOfTheOther) {
  plan::Scene scene = LayoutScene(2, 20, Layout("line", {{"gap", 3.0}}));
  SetGroup(scene, "orientation", Vector3d(0, 0, std::numbers::pi / 2));
  const std::size_t child = AddGroup(scene, "child", 2, RelativeTo("objects", {0, -1.5, 0.25}));
  SetGroup(scene, "orientation", Vector3d(0, 1, 0), child);
  AddGroup(scene, "grandchild", 2, RelativeTo("child", {0, -1.5, 0}));
  const auto state = layouts::MakeInitialState(scene);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ()));
  const Eigen::Quaterniond own(Eigen::AngleAxisd(1, Vector3d::UnitY()));
  for (std::size_t i = 0; i < 2; ++i) {
    const Vector3d& first = state.objects[i].pose.position;
    ExpectAt(state.objects[2 + i], first + Vector3d(1.5, 0, 0.25));
    ExpectAt(state.objects[4 + i], first + Vector3d(3, 0, 0.25));
    EXPECT_NEAR(state.objects[2 + i].pose.orientation.angularDistance(turn * own), 0, 1e-7);
  }
}

TEST(Layout, RelativeToNeedsAGroupBefore) {
  const auto refused = [](const std::function<void(plan::Scene&)>& change) {
    plan::Scene scene = LayoutScene(2, 20, Layout("line", {{"gap", 3.0}}));
    AddGroup(scene, "child", 2, RelativeTo("objects", {0, -1.5, 0}));
    change(scene);
    try {
      layouts::MakeInitialState(scene);
    } catch (const library::SceneError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refused([](plan::Scene&) {}), "accepted");
  EXPECT_NE(refused([](plan::Scene& scene) {
              SetGroup(scene, "quantity", std::uint64_t{3});
            }).find("group `child` has 2 objects, but `relative_to` places one at each of the 3"),
            std::string::npos);
  EXPECT_NE(refused([](plan::Scene& scene) {
              SetGroup(scene, "location", Word("uniform"));
            }).find("is placed at random"),
            std::string::npos);
  EXPECT_NE(refused([](plan::Scene& scene) {
              std::swap(scene.groups[0], scene.groups[1]);
            }).find("is written after it"),
            std::string::npos);
  EXPECT_NE(refused([](plan::Scene& scene) {
              SetGroup(scene, "location", RelativeTo("child", {1, 0, 0}), 1);
            }).find("it is at its own group"),
            std::string::npos);
  EXPECT_NE(refused([](plan::Scene& scene) {
              SetGroup(scene, "location", RelativeTo("objects", {0, -0.5, 0}), 1);
            }).find("overlap"),
            std::string::npos);
}

TEST(Layout, ListedPoints) {
  plan::Scene scene = LayoutScene(3, 100, Points({{1, 2, 3}, {0, -5, 0}, {-7, 0, 7}}));
  SetGroup(scene, "type", Word("cone"));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  // The centre of mass, as for a single object.
  EXPECT_EQ(state.objects[0].pose.position, Vector3d(1, 2, 3));
  EXPECT_EQ(state.objects[1].pose.position, Vector3d(0, -5, 0));
  EXPECT_EQ(state.objects[2].pose.position, Vector3d(-7, 0, 7));
  EXPECT_NE(FailureOf(LayoutScene(2, 100, Points({{0, 0, 0}, {0.9, 0, 0}}))).find("overlaps"),
            std::string::npos);
}

TEST(Layout, GridWithASpacing) {
  plan::Scene scene = LayoutScene(8, 100, Layout("grid", {{"spacing", 1.5}}));
  SetGroup(scene, "type", Word("cone"));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  ExpectAt(state.objects[0], {-0.75, -0.75, -0.75});
  ExpectAt(state.objects[7], {0.75, 0.75, 0.75});
  // The box's centre, not the centre of mass, which is a quarter of the height above the base.
  EXPECT_NEAR(state.objects[0].pose.position.y(), -0.75 - 0.25, kPlacementError);
  ExpectAt(layouts::MakeInitialState(LayoutScene(1, 100, Layout("grid"))).objects[0],
           Vector3d::Zero());
}

TEST(Layout, StackStandsOnTheFloor) {
  const schema::Value layout =
      Layout("stack", {{"height", std::uint64_t{3}}, {"gap", 0.1}, {"spacing", 2.0}});
  const layouts::InitialState state = layouts::MakeInitialState(LayoutScene(14, 10, layout));
  // 5 columns on a lattice of 3 by 3; the last is not full.
  for (std::size_t i = 0; i < 14; ++i) {
    const std::size_t column = i / 3;
    ExpectAt(state.objects[i], {2.0 * static_cast<double>(column % 3) - 2,
                                -5 + 0.6 + 1.1 * static_cast<double>(i % 3),
                                2.0 * static_cast<double>(column / 3) - 2});
  }
}

TEST(Layout, LineIsCentredAndTheFirstIsFirst) {
  // Downwards, a tenth of the largest extent between surfaces: 3.2 long in all.
  const layouts::InitialState state = layouts::MakeInitialState(LayoutScene(3, 20, Layout("line")));
  for (std::size_t i = 0; i < 3; ++i)
    ExpectAt(state.objects[i], {0, 1.1 - 1.1 * static_cast<double>(i), 0});
}

TEST(Layout, LineAlongAVectorLeavesItsGapBetweenSurfaces) {
  const schema::Value layout = Layout("line", {{"gap", 0.5}, {"along", Vector3d(3, 0, 4)}});
  plan::Scene scene = LayoutScene(4, 40, layout);
  const Vector3d along(0.6, 0, 0.8);
  const layouts::InitialState balls = layouts::MakeInitialState(scene);
  for (std::size_t i = 0; i < 4; ++i)
    ExpectAt(balls.objects[i], 1.5 * (static_cast<double>(i) - 1.5) * along);
  MixObjects(scene);
  SeedStreams(scene);
  const layouts::InitialState mixed = layouts::MakeInitialState(scene);
  const auto reach = [](const layouts::ObjectState& object, const Vector3d& direction) {
    const Vector3d local = object.pose.orientation.conjugate() * direction;
    return object.pose.position.dot(direction) + object.solid.Support(local).dot(local);
  };
  for (std::size_t i = 0; i + 1 < 4; ++i)
    EXPECT_NEAR(-reach(mixed.objects[i + 1], -along) - reach(mixed.objects[i], along), 0.5,
                kPlacementError);
  EXPECT_NEAR(reach(mixed.objects[0], -along), reach(mixed.objects[3], along), kPlacementError);
}

TEST(Layout, AHeavyEndIsTheLastObjectsMass) {
  plan::Scene scene = LayoutScene(3, 20, Layout("line"));
  SetGroup(scene, "mass", 2.0);
  SetGroup(scene, "links.end_mass", 50.0);
  EXPECT_EQ(layouts::MakeInitialState(scene).objects[2].mass, 2) << "without links";
  SetGroup(scene, "links.type", Word("ball"));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  EXPECT_EQ(state.objects[1].mass, 2);
  EXPECT_EQ(state.objects[2].mass, 50);
}

TEST(Layout, StackOfEverythingFits) {
  for (const std::uint64_t height : {1, 4, 40}) {
    plan::Scene scene = LayoutScene(40, 60, Layout("stack", {{"height", height}}));
    MixObjects(scene);
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    ExpectNothingTouches(scene, state);
    double widest = 0;
    for (const layouts::ObjectState& object : state.objects)
      widest = std::max({widest, Extents(object).x(), Extents(object).z()});
    if (height < 40) {
      EXPECT_NEAR(BoxCentre(state.objects[height]).x() - BoxCentre(state.objects[0]).x(),
                  1.5 * widest, kPlacementError * 60);
    }
    for (std::size_t i = 0; i < 40; ++i) {
      const layouts::ObjectState& object = state.objects[i];
      if (i % height == 0) {
        EXPECT_NEAR(Bottom(object), -30 + 1e-3 * Extents(object).y(), kPlacementError * 30);
        continue;
      }
      const layouts::ObjectState& below = state.objects[i - 1];
      EXPECT_NEAR(BoxCentre(object).x(), BoxCentre(below).x(), kPlacementError * 30);
      EXPECT_NEAR(Bottom(object) - Bottom(below) - Extents(below).y(),
                  1e-3 * std::max(Extents(object).y(), Extents(below).y()), kPlacementError * 60);
    }
  }
  // All in one column.
  const layouts::InitialState column =
      layouts::MakeInitialState(LayoutScene(5, 10, Layout("stack")));
  for (int i = 0; i < 5; ++i)
    ExpectAt(column.objects[static_cast<std::size_t>(i)], {0, -5 + 0.501 + 1.001 * i, 0});
}

TEST(Layout, PyramidRestsEachOnFour) {
  // 4 x 4, 3 x 3, and 3 of 2 x 2.
  plan::Scene scene = LayoutScene(28, 20, Layout("pyramid", {{"gap", 0.25}}));
  SetGroup(scene, "aspect", schema::Ratio{Vector3d(1, 2, 3)});
  SetGroup(scene, "type", Word("cuboid"));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  ExpectNothingTouches(scene, state);
  const Vector3d cell(1.25, 2.25, 3.25);
  const auto at = [&](double x, double layer, double z) {
    return Vector3d(x * cell.x(), -10 + 0.25 + 1 + layer * cell.y(), z * cell.z());
  };
  ExpectAt(state.objects[0], at(-1.5, 0, -1.5));
  ExpectAt(state.objects[1], at(-0.5, 0, -1.5));
  ExpectAt(state.objects[4], at(-1.5, 0, -0.5));
  ExpectAt(state.objects[15], at(1.5, 0, 1.5));
  ExpectAt(state.objects[16], at(-1, 1, -1));
  ExpectAt(state.objects[24], at(1, 1, 1));
  ExpectAt(state.objects[27], at(-0.5, 2, 0.5));
  // One object more than four layers hold needs a fifth one.
  EXPECT_NEAR(
      BoxCentre(layouts::MakeInitialState(LayoutScene(30, 20, Layout("pyramid"))).objects[0]).x(),
      -1.5 * 1.001, kPlacementError * 10);
  EXPECT_NEAR(
      BoxCentre(layouts::MakeInitialState(LayoutScene(31, 20, Layout("pyramid"))).objects[0]).x(),
      -2 * 1.001, kPlacementError * 10);
}

TEST(Layout, RingIsEven) {
  const layouts::InitialState state =
      layouts::MakeInitialState(LayoutScene(12, 20, Layout("ring", {{"radius", 5.0}})));
  for (int i = 0; i < 12; ++i) {
    const double angle = i * std::numbers::pi / 6;
    ExpectAt(state.objects[static_cast<std::size_t>(i)],
             {5 * std::cos(angle), 0, 5 * std::sin(angle)});
  }
}

TEST(Layout, RingFitsClosely) {
  // Two: 1.1 between the centres. Four: 1.1 along x or along z, whichever separates them first.
  ExpectAt(layouts::MakeInitialState(LayoutScene(2, 20, Layout("ring"))).objects[0], {0.55, 0, 0});
  const double r =
      layouts::MakeInitialState(LayoutScene(4, 20, Layout("ring"))).objects[0].pose.position.x();
  EXPECT_NEAR(std::hypot(r - 1, r - 1), 0.1, kPlacementError);
  ExpectAt(layouts::MakeInitialState(LayoutScene(1, 20, Layout("ring"))).objects[0],
           Vector3d::Zero());
  for (const std::uint64_t quantity : {3, 7, 50, 200}) {
    plan::Scene scene = LayoutScene(quantity, 500, Layout("ring"));
    MixObjects(scene);
    SetGroup(scene, "aspect", schema::Ratio{Vector3d::Ones()});
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    ExpectNothingTouches(scene, state);
    double largest = 0, least = HUGE_VAL;
    for (std::size_t i = 0; i < quantity; ++i) {
      const layouts::ObjectState &a = state.objects[i], &b = state.objects[(i + 1) % quantity];
      largest = std::max(largest, Extents(a).maxCoeff());
      const Vector3d apart = (BoxCentre(a) - BoxCentre(b)).cwiseAbs();
      least = std::min(least, (apart - (Extents(a) + Extents(b)) / 2).cwiseMax(0).norm());
    }
    EXPECT_NEAR(least, 0.1 * largest, 1e-9);
  }
}

TEST(Layout, AtIsTheCentreOfMass) {
  plan::Scene scene = LayoutScene(1, 20, Layout("at", {{"x", 1.0}, {"y", -2.0}, {"z", 3.5}}));
  SetGroup(scene, "type", Word("cone"));
  EXPECT_EQ(layouts::MakeInitialState(scene).objects[0].pose.position, Vector3d(1, -2, 3.5));
}

TEST(Layout, PairIsJustSoFarApart) {
  distributions::Stream stream(1);
  std::vector<objects::Solid> solids = {Torus()};
  for (const objects::Shape shape : objects::kClosedShapes)
    solids.push_back(RandomSolid(stream, shape, 5));
  for (const objects::Solid& a : solids) {
    for (const objects::Solid& b : solids) {
      const double size = a.sides.norm() + b.sides.norm();
      for (const double times : {1e-6, 1e-3, 1.0, 100.0}) {
        const double distance = times * size;
        plan::Scene scene = LayoutScene(2, 10000, Layout("pair", {{"distance", distance}}));
        layouts::InitialState state = layouts::DrawObjects(scene);
        layouts::ObjectState &first = state.objects[0], &second = state.objects[1];
        first.solid = a;
        second.solid = b;
        for (int seed = 0; seed < Cases(100); ++seed) {
          SeedStreams(scene, seed);
          first.pose.orientation = stream.Turn();
          second.pose.orientation = stream.Turn();
          layouts::Place(scene, state);
          ASSERT_NEAR(objects::Distance(a, first.pose, b, second.pose), distance,
                      1e-9 * (size + distance));
          ASSERT_LE((first.pose.position + second.pose.position).norm(), kPlacementError * size);
        }
      }
    }
  }
}

TEST(Layout, PairsDirectionIsUniform) {
  plan::Scene scene = LayoutScene(2, 10000, Layout("pair", {{"distance", 1.0}}));
  constexpr int kSeeds = Cases(3000);
  Vector3d mean = Vector3d::Zero(), square = Vector3d::Zero();
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    SeedStreams(scene, seed);
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    const Vector3d direction =
        (state.objects[1].pose.position - state.objects[0].pose.position).normalized();
    mean += direction / kSeeds;
    square += direction.cwiseAbs2() / kSeeds;
  }
  // A component is uniform on -1 .. 1: its variance is 1/3, that of its square 4/45. Five standard
  // deviations.
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(mean[axis], 0, 5 * std::sqrt(1.0 / 3 / kSeeds));
    EXPECT_NEAR(square[axis], 1.0 / 3, 5 * std::sqrt(4.0 / 45 / kSeeds));
  }
}

TEST(Layout, PileIsDroppedFromALooseLattice) {
  plan::Scene scene = LayoutScene(60, 30, Layout("pile"));
  MixObjects(scene);
  for (const bool is_wide : {false, true}) {
    if (is_wide) SetGroup(scene, "location", Layout("pile", {{"width", 12.0}}));
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    ExpectNothingTouches(scene, state);
    const std::vector<Vector3d> places =
        layouts::PlacesAbovePile(scene.groups[0], 30, state.objects);
    double radius = 0;
    for (const layouts::ObjectState& object : state.objects)
      radius = std::max(radius, object.solid.OuterRadius());
    const double cell = places[1].x() - places[0].x();
    EXPECT_GT(cell, 2 * radius);
    EXPECT_LT(cell, 2.2 * radius);
    const std::size_t edge = is_wide ? static_cast<std::size_t>(12 / cell) : 4;
    for (std::size_t i = 0; i < 60; ++i) {
      EXPECT_EQ(state.objects[i].pose.position, places[i]);
      const auto cells = [&](std::size_t k) { return cell * static_cast<double>(k); };
      const double first = -cells(edge - 1) / 2;
      const Vector3d expected(first + cells(i % edge), cell / 2 - 15 + cells(i / (edge * edge)),
                              first + cells(i / edge % edge));
      EXPECT_LE((places[i] - expected).norm(), kPlacementError * 100);
    }
  }
}

TEST(Layout, MixedObjectsTouchNothing) {
  for (const schema::Value& layout :
       {Layout("grid"), Layout("grid", {{"spacing", 2.5}}), Layout("pyramid"),
        Layout("ring", {{"radius", 80.0}}), Layout("pile", {{"width", 20.0}})}) {
    plan::Scene scene = LayoutScene(150, 200, layout);
    MixObjects(scene);
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    ExpectNothingTouches(scene, state);
    const layouts::InitialState again = layouts::MakeInitialState(scene);
    for (std::size_t i = 0; i < state.objects.size(); ++i)
      ASSERT_EQ(state.objects[i].pose.position, again.objects[i].pose.position);
  }
}

TEST(Layout, DrawnObjectsKeepClearOfAllOthers) {
  // The drawn group comes first in the plan, but is placed last.
  plan::Scene scene = LayoutScene(400, 12, Word("uniform"));
  MixObjects(scene);
  SetGroup(scene, "aspect", schema::Ratio{Vector3d::Ones()});
  AddGroup(scene, "dense", 100, Word("normal"));
  AddGroup(scene, "grid", 27, Layout("grid", {{"spacing", 1.9}}));
  const std::size_t ring = AddGroup(scene, "ring", 10, Layout("ring", {{"radius", 5.0}}));
  SetGroup(scene, "size", 1.0, ring);
  // A floor far larger than the cube, and a pillar through it.
  const std::size_t floor =
      AddGroup(scene, "floor", 1, Layout("at", {{"x", 0.0}, {"y", -6.0}, {"z", 0.0}}));
  const std::size_t pillar =
      AddGroup(scene, "pillar", 1, Layout("at", {{"x", 4.0}, {"y", 0.0}, {"z", 4.0}}));
  for (const std::size_t group : {floor, pillar}) {
    SetGroup(scene, "mass", Word("fixed"), group);
    SetGroup(scene, "type", Word("cuboid"), group);
    SetGroup(scene, "size", 1.0, group);
    SetGroup(scene, "orientation", Vector3d(Vector3d::Zero()), group);
  }
  SetGroup(scene, "aspect", schema::Ratio{Vector3d(1000, 1, 1000)}, floor);
  SetGroup(scene, "aspect", schema::Ratio{Vector3d(1, 1000, 1)}, pillar);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  ExpectNothingTouches(scene, state);
  EXPECT_EQ(state.objects.back().pose.position, Vector3d(4, 0, 4));
}

TEST(Layout, DrawnFillsWhatIsLeftOfACrowdedCube) {
  // A fixed slab occupies the lower half; the objects occupy a third of the rest.
  plan::Scene scene = LayoutScene(1, 10, Layout("at", {{"x", 0.0}, {"y", -5.0}, {"z", 0.0}}));
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "mass", Word("fixed"));
  SetGroup(scene, "aspect", schema::Ratio{Vector3d(10, 10, 10)});
  const std::size_t balls = AddGroup(scene, "balls", 300, Word("uniform"));
  SetGroup(scene, "type", Word("sphere"), balls);
  SetGroup(scene, "mass", 1.0, balls);
  SetGroup(scene, "aspect", schema::Ratio{Vector3d::Ones()}, balls);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  ExpectNothingTouches(scene, state);
  SetGroup(scene, "quantity", std::uint64_t{600}, balls);
  const std::string message = FailureOf(scene);
  EXPECT_NE(message.find("all objects together fill 81.4 % of the cube"), std::string::npos)
      << message;
}

}  // namespace
}  // namespace cdb::tests
