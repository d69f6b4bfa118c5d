// Voxels as ground of bodies: contacts are where the union of the cells says, and the faces have no
// edges that bodies notice.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "compiler/plan/input_file.h"
#include "library/distributions/stream.h"
#include "runtime/engine/world/manifolds.h"
#include "runtime/protocol/verdict.h"
#include "tests/library/layouts/layout_scene.h"
#include "tests/library/objects/solid_cells.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

class VoxelGround : public testing::Test {
 protected:
  /// Cells of 1 m with the corner of the first at the origin, under objects of a group.
  plan::Scene GroundScene(const SolidCells& cells, const std::vector<Vector3d>& points) {
    const std::string file = (folder_ / "cells.raw").string();
    WriteFile(file, cells.bytes);
    plan::Scene scene = LayoutScene(points.size(), 100, Points(points));
    SetWorld(scene, "precision", Word(world::EnginePrecision()));
    SetWorld(scene, "world.walls", Word("none"));
    const std::size_t ground = AddGroup(scene, "ground", 1, Points({{0, 0, 0}}));
    SetGroup(scene, "type",
             Layout("voxels", {{"file", schema::Text{file}},
                               {"sha256", schema::Text{plan::Sha256Hex(cells.bytes)}},
                               {"up", Word("y")},
                               {"cell", 1.0},
                               {"columns", static_cast<std::uint64_t>(cells.counts[0])},
                               {"rows", static_cast<std::uint64_t>(cells.counts[1])},
                               {"layers", static_cast<std::uint64_t>(cells.counts[2])},
                               {"origin", Word("file")}}),
             ground);
    SetGroup(scene, "size", Word("native"), ground);
    SetGroup(scene, "mass", Word("fixed"), ground);
    return scene;
  }
  static protocol::Verdict VerdictOf(const plan::Scene& scene, const Recorded& run) {
    return protocol::Judge(scene, run.recording, run.header().cycles_done.load()).verdict;
  }

 private:
  TemporaryFolder folder_;
};

/// Whether all corners of the box are in solid cells.
bool HasItsCornersInside(const SolidCells& cells, const objects::Pose& pose, const Vector3d& half) {
  for (int i = 0; i < 8; ++i) {
    const Vector3d corner((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    if (cells.DistanceTo(pose.position + pose.orientation * half.cwiseProduct(corner)) > 0)
      return false;
  }
  return true;
}

struct Misses {
  int overlaps = 0, missed = 0, inside = 0;
};

/// Balls, or boxes, at random places of one scene, with each detector.
Misses MissesOf(plan::Scene scene, const SolidCells& cells, bool are_boxes, std::uint64_t seed) {
  SetGroup(scene, "type", Word(are_boxes ? "cuboid" : "sphere"));
  SetGroup(scene, "aspect", schema::Ratio{Vector3d(1, are_boxes ? 0.6 : 1, are_boxes ? 1.4 : 1)});
  SetGroup(scene, "size", 0.6);
  SetGroup(scene, "margin", 0.01);
  SetGroup(scene, "overlap", true);
  SetGroup(scene, "overlap", true, 1);
  SetGroup(scene, "collides_with", schema::WordList{"ground"});
  layouts::InitialState state = layouts::MakeInitialState(scene);
  distributions::Stream stream(seed);
  for (std::size_t i = 0; i + 1 < state.objects.size(); ++i)
    state.objects[i].pose = {{stream.Uniform(-1, 10), stream.Uniform(-1, 8), stream.Uniform(-1, 9)},
                             stream.Turn()};
  world::Engine engine = WholeEngine(scene, state);
  std::vector<objects::Pose> poses;
  for (std::size_t i = 0; i + 1 < state.objects.size(); ++i)
    poses.push_back({Position(engine, i), Orientation(engine, i)});
  engine.Step();
  std::vector<bool> has_contact(state.objects.size());
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine.world())) {
    has_contact[static_cast<std::size_t>(manifold.getBody0()->getUserIndex())] = true;
    has_contact[static_cast<std::size_t>(manifold.getBody1()->getUserIndex())] = true;
  }
  Misses misses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Vector3d half = state.objects[i].solid.sides / 2;
    const double distance = cells.DistanceTo(poses[i].position);
    const double depth = are_boxes ? cells.DepthOfBox(poses[i].position,
                                                      poses[i].orientation.toRotationMatrix(), half)
                                   : half.x() - distance;
    if (depth < 1e-4) continue;
    ++misses.overlaps;
    if (has_contact[i]) continue;
    if (are_boxes ? HasItsCornersInside(cells, poses[i], half) : distance == 0)
      ++misses.inside;
    else
      ++misses.missed;
  }
  return misses;
}

TEST_F(VoxelGround, MissesNoContactOfRandomPoses) {
  constexpr std::size_t kBodies = 1000;
  for (const char* detector : {"dbvt", "auto", "grid"})
    for (const char* narrow : {"bullet", "batch"})
      for (const bool are_boxes : {false, true}) {
        SCOPED_TRACE(fmt::format("{} {} {}", detector, narrow, are_boxes));
        Misses sum;
        for (unsigned seed = 0; seed < 9; ++seed) {
          const SolidCells cells = MixedCells(seed);
          plan::Scene scene =
              GroundScene(cells, std::vector<Vector3d>(kBodies, Vector3d(0, 20, 0)));
          SetWorld(scene, "detector", Word(detector));
          SetWorld(scene, "narrow_phase", Word(narrow));
          const Misses misses = MissesOf(scene, cells, are_boxes, seed);
          sum.overlaps += misses.overlaps;
          sum.missed += misses.missed;
          sum.inside += misses.inside;
        }
        EXPECT_GT(sum.overlaps, 3500);
        EXPECT_EQ(sum.missed, 0);
        EXPECT_GT(sum.inside, 0) << "where no face is, Bullet finds nothing";
        EXPECT_LT(sum.inside, sum.overlaps / 3);
      }
}

TEST_F(VoxelGround, CountsABodyInsideAsAMissedContact) {
  const SolidCells cells{{5, 5, 5}, std::string(125, '\1')};
  plan::Scene scene = GroundScene(cells, {{2.5, 2.5, 2.5}});
  SetGroup(scene, "size", 0.5);
  EXPECT_THROW(layouts::MakeInitialState(scene), library::SceneError) << "it may not begin there";
  for (const std::size_t group : {0u, 1u}) SetGroup(scene, "overlap", true, group);
  SetWorld(scene, "cycles", std::uint64_t{1});
  SetWorld(scene, "record", schema::WordList{"pairs"});
  const Recorded run = RunHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  EXPECT_EQ(run.recording.Ints("exact_contacts")[0], 1);
  EXPECT_EQ(run.recording.Ints("missed_contacts")[0], 1);
  // The faces, which Bullet takes for thin, hold it inside.
  SetWorld(scene, "cycles", std::uint64_t{90});
  SetWorld(scene, "record", schema::WordList{"stability"});
  EXPECT_EQ(VerdictOf(scene, RunHere(scene)), protocol::Verdict::kTunnelled);
}

TEST_F(VoxelGround, IsFoundByEveryDetectorWhileBodiesFall) {
  const SolidCells cells = MixedCells(3);
  std::vector<Vector3d> points;
  for (int i = 0; i < 24; ++i) points.push_back({0.7 + i % 6 * 1.4, 9, 0.9 + i / 6 * 1.9});
  plan::Scene scene = GroundScene(cells, points);
  SetWorld(scene, "cycles", std::uint64_t{150});
  SetWorld(scene, "record", schema::WordList{"pairs"});
  SetGroup(scene, "size", 0.6);
  for (const char* detector : {"dbvt", "auto"})
    for (const char* narrow : {"bullet", "batch"})
      for (const char* type : {"sphere", "cuboid"}) {
        SCOPED_TRACE(fmt::format("{} {} {}", detector, narrow, type));
        SetWorld(scene, "detector", Word(detector));
        SetWorld(scene, "narrow_phase", Word(narrow));
        SetGroup(scene, "type", Word(type));
        const Recorded run = RunHere(scene);
        ASSERT_TRUE(run.done()) << run.message();
        const auto sum = [&](schema::IntSeries series) {
          const auto counts = run.recording.Ints(series);
          return std::accumulate(counts.begin(), counts.end(), 0);
        };
        EXPECT_GT(sum("exact_contacts"), 300);
        EXPECT_EQ(sum("missed_pairs"), 0);
        // Bullet misses some contacts of edges of boxes, by up to 4 mm, in the cycle in which they
        // begin.
        EXPECT_LE(sum("missed_contacts"),
                  type == std::string_view("sphere") ? 0 : sum("exact_contacts") / 100);
      }
}

/// A floor of 30 x 6 cells, with its top at y = 1.
SolidCells Floor() { return {{30, 1, 6}, std::string(180, '\1')}; }

struct Ride {
  Vector3d velocity;
  double highest = 0, lowest = 0;
  int false_normals = 0;
};

class Riding : public VoxelGround {
 protected:
  /// 20 m at 7 m/s without friction over cells, or over one box.
  Ride RideOver(const char* type, bool is_box, const char* edges) {
    plan::Scene scene = GroundScene(Floor(), {{3.2, 1.5, 3.37}});
    SetWorld(scene, "cycles", std::uint64_t{170});
    SetWorld(scene, "record", schema::WordList{"stability"});
    SetGroup(scene, "type", Word(type));
    SetGroup(scene, "size", 1.0);
    SetGroup(scene, "linear_velocity", Vector3d(7, 0, 0));
    for (const std::size_t group : {0u, 1u}) SetGroup(scene, "friction", 0.0, group);
    if (is_box) {
      SetGroup(scene, "type", Word("cuboid"), 1);
      SetGroup(scene, "size", 30.0, 1);
      SetGroup(scene, "aspect", schema::Ratio{Vector3d(1, 1.0 / 30, 0.2)}, 1);
      SetGroup(scene, "location", Points({{15, 0.5, 3}}), 1);
    } else {
      SetGroup(scene, "edges", Word(edges), 1);
    }
    const Recorded run = RunHere(scene);
    EXPECT_TRUE(run.done()) << run.message();
    Ride ride{Velocity(*run.engine), 0, 0,
              std::accumulate(run.recording.Ints("false_normals").begin(),
                              run.recording.Ints("false_normals").end(), 0)};
    world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
    ride.highest = ride.lowest = Position(engine).y();
    for (int i = 0; i < 170; ++i) {
      engine.Step();
      ride.highest = std::max(ride.highest, Position(engine).y());
      ride.lowest = std::min(ride.lowest, Position(engine).y());
    }
    return ride;
  }
};

TEST_F(Riding, OverCellsIsAsOverABoxIfEdgesAreSmooth) {
  for (const char* type : {"sphere", "cuboid", "cylinder"}) {
    SCOPED_TRACE(type);
    const Ride cells = RideOver(type, false, "smooth"), box = RideOver(type, true, "");
    EXPECT_NEAR(cells.velocity.x(), 7, 1e-3);
    EXPECT_NEAR(cells.velocity.x(), box.velocity.x(), kIsSingle ? 5e-3 : 1e-3);
    EXPECT_NEAR(cells.velocity.z(), 0, 1e-3);
    EXPECT_NEAR(cells.velocity.y(), 0, 0.2) << "it sinks by millimetres and comes up again";
    EXPECT_LT(cells.highest, box.highest + 1e-3);
    EXPECT_GT(cells.lowest, 1.5 - 1e-2);
    EXPECT_EQ(cells.false_normals, 0);
  }
}

TEST_F(Riding, OverCellsHasFalseNormalsAtBulletsEdges) {
  const Ride ride = RideOver("cuboid", false, "bullet");
  EXPECT_GT(ride.false_normals, 0) << "Bullet has become better";
}

/// Two rows of cells touch along the x axis at (y, z) = (1, 3) only: a body lies on the lower row
/// and slides along the upper one, past edges of four faces.
TEST_F(Riding, PastCellsThatTouchAlongAnEdge) {
  SolidCells cells{{30, 2, 6}, std::string(360, '\0')};
  for (int x = 0; x < 30; ++x)
    for (int z = 0; z < 6; ++z)
      cells.bytes[static_cast<std::size_t>((z * 2 + (z < 3 ? 0 : 1)) * 30 + x)] = 1;
  for (const char* type : {"sphere", "cuboid"}) {
    SCOPED_TRACE(type);
    plan::Scene scene = GroundScene(cells, {{3.2, 1.25, 2.7}});
    SetWorld(scene, "cycles", std::uint64_t{150});
    SetWorld(scene, "record", schema::WordList{"stability"});
    SetGroup(scene, "type", Word(type));
    SetGroup(scene, "size", 0.5);
    // Pressed into the corner between both.
    SetWorld(scene, "acceleration", Vector3d(0, -9.8, 3));
    SetGroup(scene, "linear_velocity", Vector3d(7, 0, 0));
    for (const std::size_t group : {0u, 1u}) SetGroup(scene, "friction", 0.0, group);
    SetGroup(scene, "edges", Word("smooth"), 1);
    const Recorded run = RunHere(scene);
    ASSERT_TRUE(run.done()) << run.message();
    EXPECT_NEAR(Velocity(*run.engine).x(), 7, 1e-2);
    EXPECT_NEAR(Position(*run.engine).y(), 1.25, 0.02);
    EXPECT_NEAR(Position(*run.engine).z(), 2.75, 0.02);
  }
}

}  // namespace
}  // namespace cdb::tests
