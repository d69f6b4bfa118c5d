// Sequences of meshes, and their primitives as bodies of a broad phase.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "library/deforming/mesh_sequence.h"
#include "library/deforming/primitives.h"
#include "library/detectors/exact_pairs.h"
#include "library/scene_error.h"
#include "tests/library/deforming/folding_cloth.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using deforming::Corners;
using deforming::kNoCorner;
using deforming::MeshSequence;
using deforming::Primitives;

/// The message of the SceneError that `act` throws.
std::string RefusalOf(const std::function<void()>& act) {
  try {
    act();
  } catch (const library::SceneError& error) {
    return error.what();
  }
  return "";
}

std::filesystem::path WriteObj(const TemporaryFolder& folder, const std::string& name,
                               const std::string& text) {
  std::ofstream(folder / name) << text;
  return folder / name;
}

constexpr const char* kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(MeshSequence, ReadsFramesOfSeveralFormats) {
  const TemporaryFolder folder;
  const MeshSequence sequence = deforming::ReadSequence(std::vector{
      WriteObj(folder, "a.obj", std::string(kSquare) + "f 1 2 3\nf 1 3 4\n"),
      WriteObj(folder, "b.ply",
               "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
               "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
               "end_header\n0 0 1\n1 0 1\n1 1 1\n0 1 1.5\n3 0 1 2\n3 0 2 3\n")});
  EXPECT_EQ(sequence.triangles, (std::vector<deforming::Triangle>{{0, 1, 2}, {0, 2, 3}}));
  ASSERT_EQ(sequence.frames.size(), 2u);
  EXPECT_EQ(sequence.frames[1][3], Eigen::Vector3d(0, 1, 1.5));
  EXPECT_TRUE(sequence.IsSingle());
}

TEST(MeshSequence, RefusesFramesOfOtherMeshes) {
  const TemporaryFolder folder;
  const auto first = WriteObj(folder, "a.obj", std::string(kSquare) + "f 1 2 3\nf 1 3 4\n");
  const auto refusal = [&](const std::string& name, const std::string& text) {
    return RefusalOf([&] {
      deforming::ReadSequence(std::vector{first, WriteObj(folder, name, text)});
    });
  };
  const auto has = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  const std::string vertices = refusal("b.obj", std::string(kSquare) + "v 9 9 9\nf 1 2 3\n");
  EXPECT_TRUE(has(vertices, "b.obj: it has 5 vertices") && has(vertices, "a.obj has 4;"))
      << vertices;
  const std::string triangles = refusal("c.obj", std::string(kSquare) + "f 1 2 3\n");
  EXPECT_TRUE(has(triangles, "c.obj: it has 1 triangles")) << triangles;
  const std::string order = refusal("d.obj", std::string(kSquare) + "f 1 2 3\nf 2 3 4\n");
  EXPECT_TRUE(has(order, "d.obj: its triangle 1 is 1 2 3, and that of")) << order;
  const std::string format = refusal("e.stl", "solid\nendsolid\n");
  EXPECT_TRUE(has(format, "convert the frames to PLY, OBJ or OFF")) << format;
  const std::string missing = RefusalOf([&] {
    deforming::ReadSequence(std::vector{first, folder / "none.obj"});
  });
  EXPECT_TRUE(has(missing, "none.obj")) << missing;
}

TEST(MeshSequence, RefusesTrianglesAndCoordinatesThatAreNone) {
  const auto refusal = [](const std::function<void(MeshSequence&)>& spoil) {
    MeshSequence cloth = FoldingCloth(3, 2);
    deforming::CheckSequence(cloth, "cloth");
    spoil(cloth);
    return RefusalOf([&] { deforming::CheckSequence(cloth, "cloth"); });
  };
  EXPECT_EQ(refusal([](MeshSequence& cloth) { cloth.triangles[3][1] = 9; }),
            "cloth: triangle 3 has vertex 9, counted from 0, but there are 9");
  EXPECT_EQ(refusal([](MeshSequence& cloth) {
              cloth.triangles[2] = {1, 4, 1};
            }),
            "cloth: triangle 2 has a vertex twice (1 4 1); remove it from every frame");
  EXPECT_EQ(refusal([](MeshSequence& cloth) {
              cloth.frames[1][4].y() = std::numeric_limits<double>::quiet_NaN();
            }).find("cloth: vertex 4 of frame 1 is ("),
            0u);
  EXPECT_EQ(refusal([](MeshSequence& cloth) { cloth.triangles.clear(); }),
            "cloth: there are no triangles; a point cloud does not collide");
  EXPECT_EQ(refusal([](MeshSequence& cloth) { cloth.frames[1].pop_back(); }),
            "cloth: frame 1 has 8 vertices, and frame 0 has 9");
}

TEST(Primitives, AreTheVerticesEdgesAndTrianglesOfTheMesh) {
  const MeshSequence cloth = FoldingCloth(21, 3);  // 20 x 20 squares
  const auto count = [&](Primitives primitives) {
    return deforming::BodiesOf(primitives, cloth).size();
  };
  EXPECT_EQ(count(Primitives::kTriangles), 800u);
  EXPECT_EQ(count(Primitives::kVertexFace), 441u + 800u);
  EXPECT_EQ(count(Primitives::kEdgeEdge), 441u + 800u - 1);  // Euler's formula of a disc
  const auto edges = deforming::BodiesOf(Primitives::kEdgeEdge, cloth);
  EXPECT_TRUE(std::ranges::is_sorted(edges));
  EXPECT_EQ(edges[0], (Corners{0, 1, kNoCorner}));
  EXPECT_EQ(deforming::CyclesOf(Primitives::kTriangles, cloth), 3u);
  EXPECT_EQ(deforming::CyclesOf(Primitives::kEdgeEdge, cloth), 2u);
  EXPECT_EQ(deforming::CyclesOf(Primitives::kTriangles, FoldingCloth(3, 1)), 1u);
  EXPECT_NE(RefusalOf([] {
              deforming::CyclesOf(Primitives::kVertexFace, FoldingCloth(3, 1));
            }).find("there is one frame; name at least two"),
            std::string::npos);
}

TEST(Primitives, AreNeighboursIfTheyShareAVertex) {
  EXPECT_TRUE(deforming::AreNeighbours({1, 2, 3}, {3, 4, 5}));
  EXPECT_TRUE(deforming::AreNeighbours({4, kNoCorner, kNoCorner}, {3, 4, 5}));
  EXPECT_FALSE(deforming::AreNeighbours({1, 2, kNoCorner}, {3, 4, kNoCorner}));
  EXPECT_FALSE(deforming::AreNeighbours({1, kNoCorner, kNoCorner}, {2, kNoCorner, kNoCorner}));
}

/// The pairs of a cycle that a broad phase is asked for.
std::vector<Pair> PairsOf(Primitives primitives, const MeshSequence& sequence, std::size_t cycle) {
  const auto bodies = deforming::BodiesOf(primitives, sequence);
  std::vector<double> sides;
  deforming::FillBoxes(primitives, sequence, bodies, cycle, sides);
  std::vector<Box> boxes;
  std::vector<Filter> filters;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double* side = &sides[6 * i];
    boxes.push_back({{side[0], side[1], side[2]}, {side[3], side[4], side[5]}});
    filters.push_back(deforming::FilterOf(primitives, bodies[i]));
  }
  Scene scene;
  scene.size = boxes.size();
  scene.boxes = boxes;
  scene.filters = filters;
  return detectors::ExactPairs(scene, [&](const Pair& pair) {
    return !deforming::AreNeighbours(bodies[pair.a], bodies[pair.b]);
  });
}

TEST(Primitives, MeetWhereTheClothLiesOnItself) {
  constexpr std::uint32_t kSide = 21, kHalf = kSide / 2;
  const MeshSequence cloth = FoldingCloth(kSide, 5);
  // In the last frame, each vertex of the upper half lies on its mirror image. Over the last step,
  // it has to be paired with each triangle about that, and the same with the halves exchanged.
  const auto bodies = deforming::BodiesOf(Primitives::kVertexFace, cloth);
  const auto found = PairsOf(Primitives::kVertexFace, cloth, 3);
  const std::set<std::pair<Id, Id>> all = [&] {
    std::set<std::pair<Id, Id>> pairs;
    for (const Pair& pair : found) pairs.emplace(pair.a, pair.b);
    return pairs;
  }();
  std::size_t expected = 0;
  for (Id vertex = 0; vertex < kSide * kSide; ++vertex) {
    const std::uint32_t i = vertex % kSide;
    if (i == kHalf) continue;  // on the line of the fold
    const std::uint32_t mirror = vertex - i + (kSide - 1 - i);
    for (Id face = kSide * kSide; face < bodies.size(); ++face) {
      if (std::ranges::find(bodies[face], mirror) == bodies[face].end() ||
          deforming::AreNeighbours(bodies[vertex], bodies[face]))
        continue;
      ++expected;
      EXPECT_TRUE(all.contains({vertex, face})) << vertex << " " << face;
    }
  }
  EXPECT_GT(expected, 2000u);
  // A vertex meets faces only, and never its own.
  for (const Pair& pair : found) {
    EXPECT_LT(pair.a, kSide * kSide);
    EXPECT_GE(pair.b, kSide * kSide);
    EXPECT_FALSE(deforming::AreNeighbours(bodies[pair.a], bodies[pair.b]));
  }
}

TEST(Primitives, MeetIfAnyOfTheirPointsDo) {
  // A vertex goes through a face; an edge crosses another one; triangles do so in the first frame.
  MeshSequence sequence;
  sequence.triangles = {{0, 1, 2}, {3, 4, 5}};
  sequence.frames = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, 1}, {9, 9, 9}, {9, 9, 1}},
                     {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, -1}, {9, 9, 9}, {9, 9, -9}}};
  const auto meet = [&](Primitives primitives, const Corners& a, const Corners& b) {
    const auto &from = sequence.frames[0], &to = sequence.frames[1];
    const bool is_met = deforming::Meet(primitives, a, b, from, to);
    EXPECT_EQ(deforming::Meet(primitives, b, a, from, to), is_met);
    return is_met;
  };
  const Corners vertex = {3, kNoCorner, kNoCorner}, other = {4, kNoCorner, kNoCorner};
  EXPECT_TRUE(meet(Primitives::kVertexFace, vertex, {0, 1, 2}));
  EXPECT_FALSE(meet(Primitives::kVertexFace, other, {0, 1, 2}));
  EXPECT_TRUE(meet(Primitives::kEdgeEdge, {1, 2, kNoCorner}, {3, 5, kNoCorner}));
  EXPECT_FALSE(meet(Primitives::kEdgeEdge, {0, 1, kNoCorner}, {3, 4, kNoCorner}));
  EXPECT_FALSE(meet(Primitives::kTriangles, {0, 1, 2}, {3, 4, 5}));
  sequence.frames[0][3] = {1, 1, -1};
  EXPECT_TRUE(meet(Primitives::kTriangles, {0, 1, 2}, {3, 4, 5}));
}

TEST(Primitives, OfAStepContainTheMotionBetweenItsFrames) {
  const MeshSequence cloth = FoldingCloth(7, 4);
  for (const Primitives primitives : {Primitives::kVertexFace, Primitives::kEdgeEdge}) {
    const auto bodies = deforming::BodiesOf(primitives, cloth);
    std::vector<double> sides;
    deforming::FillBoxes(primitives, cloth, bodies, 1, sides);
    for (std::size_t i = 0; i < bodies.size(); ++i)
      for (std::size_t corner = 0; corner < deforming::CountOf(bodies[i]); ++corner)
        for (const std::size_t frame : {1, 2})
          for (int k = 0; k < 3; ++k) {
            const double at = cloth.frames[frame][bodies[i][corner]][k];
            EXPECT_LE(sides[6 * i + static_cast<std::size_t>(k)], at);
            EXPECT_GE(sides[6 * i + static_cast<std::size_t>(k) + 3], at);
          }
  }
}

TEST(Primitives, OfAFlatClothOverlapOnlyWhereItsSquaresTouch) {
  // Before it folds, the boxes of two triangles of a lattice overlap if their squares touch.
  constexpr int kSquares = 6;
  const MeshSequence cloth = FoldingCloth(kSquares + 1, 1);
  std::vector<Pair> expected;
  for (Id a = 0; a < cloth.triangles.size(); ++a)
    for (Id b = a + 1; b < cloth.triangles.size(); ++b) {
      const int first = static_cast<int>(a / 2), second = static_cast<int>(b / 2);
      if (std::abs(first % kSquares - second % kSquares) <= 1 &&
          std::abs(first / kSquares - second / kSquares) <= 1 &&
          !deforming::AreNeighbours(cloth.triangles[a], cloth.triangles[b]))
        expected.push_back({a, b});
    }
  EXPECT_EQ(PairsOf(Primitives::kTriangles, cloth, 0), expected);
}

}  // namespace
}  // namespace cdb::tests
