// Fixed triangle meshes as ground.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <tuple>

#include "compiler/plan/input_file.h"
#include "compiler/schema/catalogue.h"
#include "runtime/protocol/verdict.h"
#include "tests/library/layouts/layout_scene.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/runtime/engine/paired_run.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

class Surfaces : public testing::Test {
 protected:
  /// Objects of 1 m at these points, and the fixed surface about the origin, whose longest side is
  /// 20 m.
  plan::Scene SurfaceScene(const std::string& obj, const std::vector<Vector3d>& points) {
    WriteFile(folder_ / "ground.obj", obj);
    return GroundScene(schema::Call{"surface",
                                    {schema::Text{(folder_ / "ground.obj").string()},
                                     schema::Text{plan::Sha256Hex(obj)}}},
                       points);
  }
  /// The same with a height field, whose cells are 1 wide in the unit of its heights.
  plan::Scene HeightScene(const std::string& csv, const std::vector<Vector3d>& points) {
    WriteFile(folder_ / "ground.csv", csv);
    return GroundScene(schema::Call{"heights",
                                    {schema::Text{(folder_ / "ground.csv").string()},
                                     schema::Text{plan::Sha256Hex(csv)}, Word("unit")}},
                       points);
  }
  plan::Scene GroundScene(schema::Value type, const std::vector<Vector3d>& points) {
    plan::Scene scene = LayoutScene(points.size(), 40, Points(points));
    SetWorld(scene, "precision", Word(world::EnginePrecision()));
    SetWorld(scene, "world.walls", Word("none"));
    SetWorld(scene, "cycles", std::uint64_t{180});
    const std::size_t ground = AddGroup(scene, "ground", 1, Points({{0, 0, 0}}));
    SetGroup(scene, "type", std::move(type), ground);
    SetGroup(scene, "size", 20.0, ground);
    SetGroup(scene, "mass", Word("fixed"), ground);
    return scene;
  }

  static protocol::Verdict VerdictOf(const plan::Scene& scene, const Recorded& run) {
    return protocol::Judge(scene, run.recording, run.header().cycles_done.load()).verdict;
  }

  TemporaryFolder folder_;
};

/// A square in the plane y = 0.
constexpr const char* kSquare = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 4 3 2\n";
/// A valley along z: two slopes of 45 degrees.
constexpr const char* kValley =
    "v -1 1 -1\nv 0 0 -1\nv 1 1 -1\nv -1 1 1\nv 0 0 1\nv 1 1 1\nf 1 4 5 2\nf 2 5 6 3\n";

TEST_F(Surfaces, BearBodiesOfEveryType) {
  for (const char* type :
       {"sphere", "cuboid", "cylinder", "cone", "capsule", "tetrahedron", "torus"}) {
    SCOPED_TRACE(type);
    plan::Scene scene = SurfaceScene(kSquare, {{1, 1.2, 2}, {-4, 1.2, 3}});
    SetGroup(scene, "type", Word(type));
    const Recorded run = RunHere(scene);
    ASSERT_TRUE(run.done()) << run.message();
    EXPECT_EQ(VerdictOf(scene, run), protocol::Verdict::kStable)
        << protocol::VerdictName(VerdictOf(scene, run));
    for (const std::size_t i : {0u, 1u}) {
      EXPECT_GT(Position(*run.engine, i).y(), 0.05);
      EXPECT_LT(Position(*run.engine, i).y(), 0.6);
    }
  }
}

TEST_F(Surfaces, AreWhereTheyAreDrawn) {
  plan::Scene scene = SurfaceScene(kSquare, {{1, 0.6, 2}});
  const Recorded run = RunHere(scene);
  EXPECT_NEAR(Position(*run.engine, 0).y(), 0.5, 0.01) << "no margin about the triangles";
  SetGroup(scene, "type", Word("cuboid"));
  EXPECT_NEAR(Position(*RunHere(scene).engine, 0).y(), 0.5, 0.02);
}

TEST_F(Surfaces, HoldWhatConvexHullsWouldFill) {
  // The convex hull of the valley is solid up to y = 5.
  const plan::Scene scene = SurfaceScene(kValley, {{3, 1, 0}});
  const Recorded run = RunHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  EXPECT_LT(Position(*run.engine, 0).y(), -2.5) << "it rolled down";
  EXPECT_EQ(VerdictOf(scene, run), protocol::Verdict::kStable);
}

TEST_F(Surfaces, WhoCrossesThemHasTunnelled) {
  plan::Scene scene = SurfaceScene(kSquare, {{1, 8, 2}});
  SetGroup(scene, "linear_velocity", Vector3d(0, -300, 0));
  const Recorded fast = RunHere(scene);
  EXPECT_LT(Position(*fast.engine, 0).y(), -1);
  EXPECT_EQ(VerdictOf(scene, fast), protocol::Verdict::kTunnelled);
  // Beside it, nothing is crossed.
  SetGroup(scene, "location", Points({{14, 8, 2}}));
  EXPECT_EQ(VerdictOf(scene, RunHere(scene)), protocol::Verdict::kStable);
  // Nor is it crossed by an object that may not collide with it.
  SetGroup(scene, "location", Points({{1, 8, 2}}));
  SetGroup(scene, "collides_with", schema::WordList{"none"});
  EXPECT_EQ(VerdictOf(scene, RunHere(scene)), protocol::Verdict::kStable);
}

TEST_F(Surfaces, NothingIsLeftOutThatTheyNeed) {
  plan::Scene scene = SurfaceScene(kValley, {{3, 1, 0}, {-6, 4, 2}, {1, 4, -7}, {15, 8, 15}});
  SetWorld(scene, "world.walls", Word("all"));
  for (const char* detector : {"dbvt", "sap32", "grid", "auto"}) {
    SCOPED_TRACE(detector);
    SetWorld(scene, "detector", Word(detector));
    SetWorld(scene, "omit", schema::WordList{"auto"});
    RunPaired(scene);
  }
}

TEST_F(Surfaces, EveryDetectorMovesBodiesAlike) {
  plan::Scene scene =
      SurfaceScene(kValley, {{3, 1, 0}, {-6, 4, 2}, {1, 4, -7}, {2.5, 3, 0.2}, {-2, 2, 5}});
  SetGroup(scene, "type", Word("cuboid"));
  SetWorld(scene, "pair_order", Word("sorted"));
  SetWorld(scene, "sleeping", false);
  ExpectAlike(scene, {"sap32", "sweep", "grid", "octree", "skin", "auto"});
}

/// Bullet's triangles of a height field are the same as cdb's, which placement, verdicts and views
/// use.
TEST_F(Surfaces, HeightFieldsAreTheTrianglesOfTheirGrid) {
  const plan::Scene scene = HeightScene("0,1,0,2\n3,1,2,0\n1,4,1,1\n", {{0, 15, 0}});
  const world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  const objects::Compound& ground = *engine.initial_state().objects[1].solid.compound;
  EXPECT_EQ(ground.sides(), Vector3d(15, 20, 10));
  struct Collector : btTriangleCallback {
    void processTriangle(btVector3* corners, int, int) override {
      std::array<Vector3d, 3> found = {ToEigen(corners[0]), ToEigen(corners[1]),
                                       ToEigen(corners[2])};
      std::ranges::sort(found, [](const Vector3d& a, const Vector3d& b) {
        return std::tuple(a.x(), a.z()) < std::tuple(b.x(), b.z());
      });
      triangles.push_back(found);
    }
    std::vector<std::array<Vector3d, 3>> triangles;
  } collector;
  const btCollisionShape& shape = *engine.objects()[1]->getCollisionShape();
  ASSERT_EQ(shape.getShapeType(), TERRAIN_SHAPE_PROXYTYPE);
  static_cast<const btConcaveShape&>(shape).processAllTriangles(
      &collector, btVector3(-50, -50, -50), btVector3(50, 50, 50));
  ASSERT_EQ(collector.triangles.size(), ground.form().pieces.size());
  for (std::size_t i = 0; i < ground.form().pieces.size(); ++i) {
    std::array<Vector3d, 3> ours = {ground.Corner(i, 0), ground.Corner(i, 1), ground.Corner(i, 2)};
    std::ranges::sort(ours, [](const Vector3d& a, const Vector3d& b) {
      return std::tuple(std::round(a.x()), std::round(a.z())) <
             std::tuple(std::round(b.x()), std::round(b.z()));
    });
    const auto is_ours = [&](const std::array<Vector3d, 3>& theirs) {
      double most = 0;
      for (std::size_t corner = 0; corner < 3; ++corner)
        most = std::max(most, (theirs[corner] - ours[corner]).norm());
      return most < 100 * kEpsilon * 20;
    };
    EXPECT_EQ(std::ranges::count_if(collector.triangles, is_ours), 1) << i;
  }
}

TEST_F(Surfaces, HeightFieldsBearBodiesAndShowWhoCrossesThem) {
  const std::string valley = "2,1,0,1,2\n2,1,0,1,2\n2,1,0,1,2\n2,1,0,1,2\n2,1,0,1,2\n";
  plan::Scene scene = HeightScene(valley, {{5, 3, 0}, {-6, 4, 2}});
  const Recorded run = RunHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  EXPECT_EQ(VerdictOf(scene, run), protocol::Verdict::kStable)
      << protocol::VerdictName(VerdictOf(scene, run));
  for (const std::size_t i : {0u, 1u})
    EXPECT_LT(Position(*run.engine, i).y(), 0) << "down it rolled";
  for (const std::size_t i : {0u, 1u})
    EXPECT_GT(Position(*run.engine, i).y(), -5) << "and no lower";
  SetGroup(scene, "linear_velocity", Vector3d(0, -400, 0));
  EXPECT_EQ(VerdictOf(scene, RunHere(scene)), protocol::Verdict::kTunnelled);
}

TEST_F(Surfaces, AFlatHeightFieldIsAFloor) {
  const plan::Scene scene = HeightScene("7,7,7\n7,7,7\n", {{1, 1, 2}});
  const Recorded run = RunHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  EXPECT_NEAR(Position(*run.engine, 0).y(), 0.5, 0.01);
}

}  // namespace
}  // namespace cdb::tests
