// Fixed triangle meshes as ground.
#include <BulletCollision/CollisionDispatch/btInternalEdgeUtility.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numeric>
#include <tuple>

#include "compiler/plan/input_file.h"
#include "compiler/schema/catalogue.h"
#include "runtime/engine/world/internal_edges.h"
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
    const std::string file = NewFile(".obj", obj);
    return GroundScene(Layout("surface", {{"file", schema::Text{file}},
                                          {"sha256", schema::Text{plan::Sha256Hex(obj)}}}),
                       points);
  }
  /// The same with a height field, whose cells are 1 wide in the unit of its heights.
  plan::Scene HeightScene(const std::string& text, const std::vector<Vector3d>& points,
                          const char* extension = ".csv") {
    const std::string file = NewFile(extension, text);
    return GroundScene(Layout("heights", {{"file", schema::Text{file}},
                                          {"sha256", schema::Text{plan::Sha256Hex(text)}}}),
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

 private:
  std::string NewFile(const char* extension, const std::string& text) {
    const auto file = folder_ / fmt::format("ground{}{}", ++files_, extension);
    WriteFile(file, text);
    return file.string();
  }
  int files_ = 0;
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
    // Not over the diagonal of the square, where Bullet finds false normals.
    plan::Scene scene = SurfaceScene(kSquare, {{1, 1.2, 4}, {-4, 1.2, 3}});
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
  ASSERT_EQ(collector.triangles.size(), ground.form().PieceCount());
  for (std::size_t i = 0; i < ground.form().PieceCount(); ++i) {
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

using Height = std::function<double(double x, double z)>;

/// 20 x 20 cells, each of two triangles.
std::string MeshOver(const Height& height, bool are_vertices_shared) {
  std::string vertices, faces;
  int count = 0;
  const auto add = [&](int x, int z) {
    vertices += fmt::format("v {} {} {}\n", x - 10, height(x - 10, z - 10), z - 10);
    return ++count;
  };
  for (int z = 0; z <= 20 && are_vertices_shared; ++z)
    for (int x = 0; x <= 20; ++x) add(x, z);
  const auto corner = [&](int x, int z) {
    return are_vertices_shared ? 21 * z + x + 1 : add(x, z);
  };
  for (int z = 0; z < 20; ++z)
    for (int x = 0; x < 20; ++x)
      for (const auto& [a, b, c] : {std::tuple{0, 2, 1}, std::tuple{1, 2, 3}}) {
        faces += "f";
        for (const int i : {a, b, c}) faces += fmt::format(" {}", corner(x + i % 2, z + i / 2));
        faces += "\n";
      }
  return vertices + faces;
}
/// The same as a height field.
std::string HeightsOver(const Height& height) {
  std::string csv;
  for (int z = 0; z <= 20; ++z)
    for (int x = 0; x <= 20; ++x)
      csv += fmt::format("{}{}", height(x - 10, z - 10), x < 20 ? "," : "\n");
  return csv;
}

struct Slider {
  const char* type;
  schema::Ratio aspect;
  Vector3d turn;  ///< axis times angle
  double height;  ///< m: of its centre when it lies
};
const std::vector<Slider> kSliders = {{"cylinder", {{1, 0.4, 1}}, {0, 0, 0}, 0.2},
                                      {"sphere", {{1, 1, 1}}, {0, 0, 0}, 0.5},
                                      {"cuboid", {{1, 0.4, 1}}, {0, 0, 0}, 0.2},
                                      {"capsule", {{1, 2, 1}}, {M_PI / 2, 0, 0}, 0.5},
                                      {"cone", {{1, 1, 1}}, {0, 0, 0}, 0.25}};

class Sliding : public Surfaces {
 protected:
  /// Every kind of ground of this shape, without friction, under one object at (x, y, .37).
  std::vector<plan::Scene> Scenes(const Height& height, double x, double y) {
    const std::vector<Vector3d> at = {{x, y, 0.37}};
    std::vector<plan::Scene> scenes = {HeightScene(HeightsOver(height), at)};
    for (const bool are_shared : {true, false})
      scenes.push_back(SurfaceScene(MeshOver(height, are_shared), at));
    for (plan::Scene& scene : scenes) {
      SetWorld(scene, "cycles", std::uint64_t{120});
      for (const std::size_t group : {0u, 1u}) SetGroup(scene, "friction", 0.0, group);
    }
    return scenes;
  }
  static void Put(plan::Scene& scene, const Slider& slider) {
    SetGroup(scene, "type", Word(slider.type));
    SetGroup(scene, "aspect", slider.aspect);
    SetGroup(scene, "orientation", slider.turn);
  }
  static int FalseNormals(const Recorded& run) {
    const auto counts = run.recording.Ints("false_normals");
    return std::accumulate(counts.begin(), counts.end(), 0);
  }
  static double FalseImpulse(const Recorded& run) {
    const auto impulses = run.recording.Reals("false_impulse");
    return std::accumulate(impulses.begin(), impulses.end(), 0.0);
  }
};

TEST_F(Sliding, OnLevelGroundWithSmoothEdgesKeepsTheSpeed) {
  for (const Slider& slider : kSliders) {
    SCOPED_TRACE(slider.type);
    for (plan::Scene& scene : Scenes([](double, double) { return 0; }, -8.3, slider.height)) {
      Put(scene, slider);
      SetGroup(scene, "linear_velocity", Vector3d(7, 0, 0));
      SetGroup(scene, "edges", Word("smooth"), 1);
      const Recorded run = RunHere(scene);
      ASSERT_TRUE(run.done()) << run.message();
      EXPECT_NEAR(Velocity(*run.engine).x(), 7, 1e-3);
      EXPECT_NEAR(Velocity(*run.engine).z(), 0, 1e-3);
      EXPECT_EQ(FalseNormals(run), 0);
      EXPECT_EQ(VerdictOf(scene, run), protocol::Verdict::kStable);
    }
  }
}

/// Bullet's limits for the edges are lengths in m, and meant for bodies of 1 m.
TEST_F(Sliding, OnLevelGroundWithSmoothEdgesKeepsTheSpeedAtEveryScale) {
  // In single precision, Bullet's contacts of bodies of a centimetre are too coarse.
  for (const double scale : {kIsSingle ? 1.0 : 0.01, 100.0})
    for (const char* type : {"cylinder", "torus"})
      for (plan::Scene& scene :
           Scenes([](double, double) { return 0; }, -8.3 * scale, 0.25 * scale)) {
        SCOPED_TRACE(fmt::format("{} {}", scale, type));
        Put(scene, kSliders[0]);
        SetGroup(scene, "type", Word(type));
        SetGroup(scene, "location", Points({{-8.3 * scale, 0.25 * scale, 0.37 * scale}}));
        SetWorld(scene, "acceleration", Vector3d(0, -9.8 * scale, 0));
        SetWorld(scene, "world.side", 60 * scale);
        SetWorld(scene, "sleeping", false);
        SetGroup(scene, "size", scale);
        SetGroup(scene, "size", 20 * scale, 1);
        SetGroup(scene, "linear_velocity", Vector3d(7 * scale, 0, 0));
        SetGroup(scene, "edges", Word("smooth"), 1);
        const Recorded run = RunHere(scene);
        ASSERT_TRUE(run.done()) << run.message();
        EXPECT_NEAR(Velocity(*run.engine).x() / scale, 7, 0.02);
        EXPECT_EQ(VerdictOf(scene, run), protocol::Verdict::kStable);
      }
}

/// Bullet's own contacts stop the same bodies, which the verdict has to say.
TEST_F(Sliding, OnLevelGroundIsStoppedByTheEdgesOfTheTriangles) {
  for (const Slider& slider : kSliders) {
    SCOPED_TRACE(slider.type);
    for (plan::Scene& scene : Scenes([](double, double) { return 0; }, -8.3, slider.height)) {
      Put(scene, slider);
      SetGroup(scene, "linear_velocity", Vector3d(7, 0, 0));
      const Recorded run = RunHere(scene);
      const double lost = 7 - Velocity(*run.engine).x();
      EXPECT_GT(lost, 0.35) << "Bullet has become better";
      EXPECT_GT(FalseImpulse(run), 0.9 * lost) << "1 kg";
      const auto judged = protocol::Judge(scene, run.recording, 120);
      EXPECT_EQ(judged.verdict, protocol::Verdict::kDrifting);
      EXPECT_EQ(run.recording.Ints("deflected").back(), 1);
      // The first one is the cycle in which a twentieth of the momentum is gone.
      const auto first = static_cast<std::size_t>(judged.first_bad_cycle);
      ASSERT_LT(first, 120u);
      EXPECT_EQ(run.recording.Ints("deflected")[first], 1);
      if (first > 0) {
        EXPECT_EQ(run.recording.Ints("deflected")[first - 1], 0);
      }
    }
  }
}

TEST_F(Sliding, DownASlopeWithSmoothEdgesGainsWhatGravityGives) {
  for (const Slider& slider : kSliders) {
    SCOPED_TRACE(slider.type);
    const double slope = std::atan(0.3);
    // Starts in the air, just above the slope.
    for (plan::Scene& scene : Scenes([](double x, double) { return -0.3 * x; }, -8.3, 3.5)) {
      Put(scene, slider);
      SetGroup(scene, "edges", Word("smooth"), 1);
      const Recorded run = RunHere(scene);
      EXPECT_EQ(FalseNormals(run), 0);
      EXPECT_EQ(VerdictOf(scene, run), protocol::Verdict::kStable);
      const Vector3d along(std::cos(slope), -std::sin(slope), 0);
      EXPECT_NEAR(Velocity(*run.engine).dot(along), 9.8 * std::sin(slope) * 2, 0.05);
    }
  }
}

/// Deep in a body, the shortest way out of a triangle at a corner points through the surface.
TEST_F(Sliding, OverHillsWithSmoothEdgesIsNotDeflected) {
  const auto hills = [](double x, double z) { return std::sin(0.6 * x) * std::cos(0.5 * z) / 2; };
  int drifting = 0;
  for (const Slider& slider : kSliders) {
    SCOPED_TRACE(slider.type);
    for (plan::Scene& scene : Scenes(hills, -1.3, 2.6)) {
      Put(scene, slider);
      SetGroup(scene, "linear_velocity", Vector3d(3, 0, 0));
      drifting += VerdictOf(scene, RunHere(scene)) == protocol::Verdict::kDrifting;
      SetGroup(scene, "edges", Word("smooth"), 1);
      EXPECT_EQ(VerdictOf(scene, RunHere(scene)), protocol::Verdict::kStable);
    }
  }
  EXPECT_GT(drifting, 7) << "of 15 with Bullet's own edges";
}

/// The sharp edge of a roof, and the bottom of a valley, each of two quadrilaterals.
TEST_F(Sliding, BouncesOffARidgeAndRestInAValleyAreLegal) {
  const auto roof = [](double rise) {
    return fmt::format(
        "v -1 {0} -1\nv 0 {1} -1\nv 1 {0} -1\nv -1 {0} 1\nv 0 {1} 1\nv 1 {0} 1\n"
        "f 1 4 5 2\nf 2 5 6 3\n",
        -rise, rise);
  };
  for (const Slider& slider : kSliders)
    for (const double rise : {0.2, -0.2}) {
      SCOPED_TRACE(slider.type + fmt::format(" {}", rise));
      // So near that the edge is hit, not a face, and 5 m away from the diagonals.
      plan::Scene scene = SurfaceScene(roof(rise), {{0.1, 10 * rise + 1.2, 0}});
      for (const std::size_t group : {0u, 1u}) SetGroup(scene, "restitution", 0.8, group);
      SetWorld(scene, "cycles", std::uint64_t{60});
      Put(scene, slider);
      const Recorded run = RunHere(scene);
      EXPECT_GT(std::ranges::count_if(run.recording.Ints("contacts"), [](int n) { return n > 0; }),
                0);
      if (rise > 0 && slider.type == std::string_view("sphere")) {
        EXPECT_GT(Velocity(*run.engine).x(), 0.1);
      }
      EXPECT_EQ(FalseNormals(run), 0);
      EXPECT_EQ(run.recording.Ints("deflected").back(), 0);
    }
}

TEST_F(Surfaces, ABallBesideAnEdgeIsDeflectedAndOneOnAFaceIsNot) {
  for (const auto& [x, is_deflected] : {std::pair{-4.0, false}, std::pair{0.05, true}}) {
    // Beside the diagonal x = z, or far from it.
    plan::Scene scene = SurfaceScene(kSquare, {{x, 2, 0}});
    const Recorded run = RunHere(scene);
    const Vector3d end = Position(*run.engine);
    EXPECT_EQ(std::hypot(end.x() - x, end.z()) > 0.2, is_deflected) << end.transpose();
    EXPECT_EQ(VerdictOf(scene, run) == protocol::Verdict::kDrifting, is_deflected);
    SetGroup(scene, "edges", Word("smooth"), 1);
    const Recorded smooth = RunHere(scene);
    EXPECT_NEAR(Position(*smooth.engine).x(), x, 1e-3);
    EXPECT_EQ(VerdictOf(scene, smooth), protocol::Verdict::kStable);
  }
}

/// A cube, at some of whose corners a face is one triangle, at others two.
constexpr const char* kCube =
    "v -1 -1 -1\nv 1 -1 -1\nv 1 -1 1\nv -1 -1 1\nv -1 1 -1\nv 1 1 -1\nv 1 1 1\nv -1 1 1\n"
    "f 5 8 7\nf 5 7 6\nf 1 2 3\nf 1 3 4\nf 1 5 6\nf 1 6 2\nf 2 6 7\nf 2 7 3\nf 3 7 8\n"
    "f 3 8 4\nf 4 8 5\nf 4 5 1\n";

TEST_F(Surfaces, ABallThatFallsOnAConvexCornerDoesNotSinkIn) {
  constexpr double kHalf = 10, kRadius = 0.5;
  std::vector<Vector3d> points;
  for (const int corner : {0, 1, 2, 3})
    for (int i = 0; i < 10; ++i)
      for (int k = 0; k < 10; ++k) {
        const double x = kHalf - 0.25 + 0.06 * i, z = kHalf - 0.25 + 0.06 * k;
        points.emplace_back((corner & 1) != 0 ? x : -x, kHalf + kRadius + 0.3,
                            (corner & 2) != 0 ? z : -z);
      }
  for (const char* edges : {"bullet", "smooth"}) {
    SCOPED_TRACE(edges);
    plan::Scene scene = SurfaceScene(kCube, points);
    SetWorld(scene, "timestep", 1.0 / 240);
    SetGroup(scene, "overlap", true);
    SetGroup(scene, "collides_with", schema::WordList{"ground"});
    SetGroup(scene, "edges", Word(edges), 1);
    world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
    std::vector<double> deepest(points.size());
    for (int cycle = 0; cycle < 150; ++cycle) {
      engine.Step();
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Vector3d at = Position(engine, i);
        const Vector3d nearest = at.cwiseMax(-kHalf).cwiseMin(kHalf);
        deepest[i] = std::max(deepest[i], kRadius - (at - nearest).norm());
      }
    }
    EXPECT_EQ(std::ranges::count_if(deepest, [](double x) { return x > 0.1 * kRadius; }), 0);
  }
}

TEST_F(Surfaces, ABoxAcrossEdgesRests) {
  for (const char* edges : {"bullet", "smooth"}) {
    plan::Scene scene = SurfaceScene(kSquare, {{0.1, 0.5, 0.2}});
    SetGroup(scene, "type", Word("cuboid"));
    SetGroup(scene, "edges", Word(edges), 1);
    const Recorded run = RunHere(scene);
    EXPECT_LT((Position(*run.engine) - Vector3d(0.1, 0.5, 0.2)).norm(), 0.02);
    EXPECT_EQ(VerdictOf(scene, run), protocol::Verdict::kStable);
  }
}

/// Bullet's own numbers of the triangles of a height field are the same for columns 1024 apart.
TEST_F(Surfaces, SmoothEdgesHoldInWideHeightFields) {
  std::string row;
  for (int x = 0; x < 2100; ++x) row += x == 0 ? "0" : ",0";
  plan::Scene scene = HeightScene(row + "\n" + row + "\n" + row + "\n", {{0, 1, 0}});
  SetGroup(scene, "size", 2099.0, 1);
  SetGroup(scene, "edges", Word("smooth"), 1);
  const world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  auto& shape = static_cast<btHeightfieldTerrainShape&>(*engine.objects()[1]->getCollisionShape());
  ASSERT_EQ(shape.getShapeType(), TERRAIN_SHAPE_PROXYTYPE);
  EXPECT_EQ(shape.getTriangleInfoMap()->size(), 2099 * 2 * 2);
}

/// Balls at rest at the corners of a map, whose first row is its north: level ground of the four
/// heights in the file, which are all different.
TEST_F(Surfaces, NorthOfAMapIsTowardsMinusZ) {
  std::string map = "ncols 9\nnrows 7\nxllcorner 0\nyllcorner 0\ncellsize 4\n";
  for (int row = 0; row < 7; ++row)
    for (int column = 0; column < 9; ++column) {
      const bool is_west = column<3, is_east = column> 5, is_north = row<3, is_south = row> 3;
      map += fmt::format("{}{}",
                         is_north && is_west   ? 1
                         : is_north && is_east ? 2
                         : is_south && is_west ? 4
                         : is_south && is_east ? 8
                                               : 0,
                         column < 8 ? " " : "\n");
    }
  // 32 by 24 m, drawn to a length of 20 m; from 0 to 8 m high, with the middle at y = 0.
  const double scale = 20.0 / 32;
  const auto top = [&](double height) { return scale * (height - 4) + 0.5; };
  const Vector3d rests[] = {
      {-9, top(1), -6.6}, {9, top(2), -6.6}, {-9, top(4), 6.6}, {9, top(8), 6.6}};
  std::vector<Vector3d> starts;
  for (const Vector3d& rest : rests) starts.emplace_back(rest + Vector3d(0, 0.3, 0));
  plan::Scene scene = HeightScene(map, starts, ".asc");
  SetGroup(scene, "edges", Word("smooth"), 1);
  const Recorded run = RunHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT((Position(*run.engine, i) - rests[i]).norm(), 0.01)
        << i << ": " << Position(*run.engine, i).transpose();
}

/// What is found for each triangle when it is touched is what Bullet finds for all at once.
TEST(NumberedHeights, FindTheEdgesOfATriangleWhenAsked) {
  constexpr int kColumns = 11, kRows = 7;
  std::vector<btScalar> heights;
  for (int i = 0; i < kColumns * kRows; ++i) heights.push_back(btScalar(i * i % 7));
  const auto make = [&] {
    auto shape = std::make_unique<world::NumberedHeights>(kColumns, kRows, heights.data(),
                                                          btScalar(0), btScalar(6), 1, false);
    shape->setLocalScaling(btVector3(2, 1, 3));
    return shape;
  };
  btTriangleInfoMap all, touched;
  const auto at_once = make(), when_asked = make();
  btGenerateInternalEdgeInfo(at_once.get(), &all);
  when_asked->setTriangleInfoMap(&touched);
  const int count = 2 * (kColumns - 1) * (kRows - 1);
  for (int i = 0; i < count; ++i) {
    const int triangle = i * 37 % count;
    when_asked->FindEdgesOf(triangle);
    EXPECT_EQ(touched.size(), i + 1);
    when_asked->FindEdgesOf(triangle);
  }
  ASSERT_EQ(all.size(), count);
  for (int triangle = 0; triangle < count; ++triangle) {
    const btTriangleInfo &a = *all.find(triangle), &b = *touched.find(triangle);
    EXPECT_EQ(a.m_flags, b.m_flags);
    EXPECT_EQ(a.m_edgeV0V1Angle, b.m_edgeV0V1Angle);
    EXPECT_EQ(a.m_edgeV1V2Angle, b.m_edgeV1V2Angle);
    EXPECT_EQ(a.m_edgeV2V0Angle, b.m_edgeV2V0Angle);
  }
}

TEST_F(Surfaces, AFlatHeightFieldIsAFloor) {
  const plan::Scene scene = HeightScene("7,7,7\n7,7,7\n", {{1, 1, 2}});
  const Recorded run = RunHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  EXPECT_NEAR(Position(*run.engine, 0).y(), 0.5, 0.01);
}

}  // namespace
}  // namespace cdb::tests
