// Tetrahedra that fill meshes, against closed forms.
#include "library/tetrahedra/stuffing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "compiler/analysis/soft.h"
#include "library/meshes/mass_properties.h"
#include "library/meshes/overlap_volume.h"
#include "library/meshes/primitives.h"
#include "tests/library/meshes/test_meshes.h"

namespace cdb::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using tetrahedra::Tetrahedra;

/// The bounds of the paper are 10.7 and 164.8 degrees.
constexpr double kLeastAngle = 10.7, kMostAngle = 164.8;

meshes::Mesh CuboidMesh(const Vector3d& sides) { return BoxMesh(-sides / 2, sides / 2); }

/// An octahedron, each of whose triangles is divided into `n` x `n`, with its vertices put at
/// `radius(direction)` from the origin.
template <typename Radius>
meshes::Mesh StarMesh(int n, const Radius& radius) {
  meshes::Mesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> known;
  const auto vertex = [&](const Eigen::Vector3i& at) {
    const auto [place, is_new] =
        known.try_emplace({at.x(), at.y(), at.z()}, static_cast<std::uint32_t>(known.size()));
    const Vector3d direction = at.cast<double>().normalized();
    if (is_new) mesh.vertices.push_back(radius(direction) * direction);
    return place->second;
  };
  for (int octant = 0; octant < 8; ++octant) {
    const Eigen::Vector3i sign(octant & 1 ? -1 : 1, octant & 2 ? -1 : 1, octant & 4 ? -1 : 1);
    const auto at = [&](int x, int y) {
      return vertex(Eigen::Vector3i(x, y, n - x - y).cwiseProduct(sign));
    };
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      if (sign.prod() < 0) std::swap(b, c);
      mesh.triangles.push_back({a, b, c});
    };
    for (int x = 0; x < n; ++x)
      for (int y = 0; x + y < n; ++y) {
        add(at(x, y), at(x + 1, y), at(x, y + 1));
        if (x + y + 1 < n) add(at(x + 1, y), at(x + 1, y + 1), at(x, y + 1));
      }
  }
  return mesh;
}

/// Volume, centre and inertia by the tetrahedra, each with the closed form of its second moments.
meshes::MassProperties PropertiesOf(const Tetrahedra& made) {
  meshes::MassProperties all;
  Matrix3d moments = Matrix3d::Zero();
  for (const auto& t : made.corners) {
    Eigen::Matrix<double, 3, 4> at;
    for (int i = 0; i < 4; ++i) at.col(i) = made.nodes[t[static_cast<std::size_t>(i)]];
    const double volume =
        (at.col(1) - at.col(0)).cross(at.col(2) - at.col(0)).dot(at.col(3) - at.col(0)) / 6;
    const Vector3d sum = at.rowwise().sum();
    moments += volume / 20 * (at * at.transpose() + sum * sum.transpose());
    all.centre += volume / 4 * sum;
    all.volume += volume;
  }
  all.centre /= all.volume;
  moments = moments / all.volume - all.centre * all.centre.transpose();
  all.inertia = moments.trace() * Matrix3d::Identity() - moments;
  return all;
}

/// What must hold for the tetrahedra of any mesh.
void ExpectWellFormed(const Tetrahedra& made, const std::string& what) {
  std::map<std::array<std::uint32_t, 3>, int> faces;
  std::set<std::uint32_t> used;
  double sum = 0;
  for (const auto& t : made.corners) {
    const Vector3d &a = made.nodes[t[0]], &b = made.nodes[t[1]], &c = made.nodes[t[2]],
                   &d = made.nodes[t[3]];
    const double volume = (b - a).cross(c - a).dot(d - a) / 6;
    EXPECT_GT(volume, 0) << what;
    sum += volume;
    used.insert(t.begin(), t.end());
    for (std::size_t i = 0; i < 4; ++i) {
      std::array<std::uint32_t, 3> face;
      std::size_t k = 0;
      for (std::size_t j = 0; j < 4; ++j)
        if (j != i) face[k++] = t[j];
      std::ranges::sort(face);
      ++faces[face];
    }
  }
  EXPECT_EQ(used.size(), made.nodes.size()) << what << ": no node is idle";
  std::size_t outer = 0;
  for (const auto& [face, count] : faces) {
    EXPECT_LE(count, 2) << what;
    outer += count == 1;
  }
  analysis::SoftMesh mesh;
  mesh.tetrahedra = made.corners;
  analysis::AddLinksAndTriangles(mesh);
  meshes::Mesh surface;
  surface.vertices = made.nodes;
  surface.triangles = mesh.triangles;
  EXPECT_EQ(surface.triangles.size(), outer) << what;
  // The surface is a manifold: each edge once in each direction, and one fan at each node.
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>> fans;
  for (const auto& t : surface.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      ++edges[{t[i], t[(i + 1) % 3]}];
      fans[t[i]][t[(i + 1) % 3]] = t[(i + 2) % 3];
    }
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1) << what;
    EXPECT_EQ(edges.count({edge.second, edge.first}), 1u) << what;
  }
  for (const auto& [node, next] : fans) {
    std::size_t length = 0;
    for (std::uint32_t at = next.begin()->first; length == 0 || at != next.begin()->first;
         at = next.at(at))
      ++length;
    EXPECT_EQ(length, next.size()) << what << ": the triangles at node " << node;
  }
  // The tetrahedra do not overlap: their volumes add up to that within the surface, in which no
  // point is twice.
  EXPECT_NEAR(meshes::SignedVolume(surface), sum, 1e-9 * sum) << what;
  const meshes::OverlapVolume within = meshes::OverlapVolumeOf(surface, surface);
  EXPECT_NEAR(within.second, within.second_in_all, 1e-9 * within.second) << what;
  const tetrahedra::DihedralAngles angles = tetrahedra::DihedralAnglesOf(made);
  EXPECT_GT(angles.least, kLeastAngle) << what;
  EXPECT_LT(angles.most, kMostAngle) << what;
}

TEST(Stuffing, ABoxWithWholeCellsIsFilledExactly) {
  const Vector3d sides(2, 0.5, 1);
  const Tetrahedra made = tetrahedra::Stuff(CuboidMesh(sides), 8, "box");
  ExpectWellFormed(made, "box");
  const meshes::MassProperties properties = PropertiesOf(made);
  EXPECT_NEAR(properties.volume, 1, 1e-12);
  EXPECT_LT(properties.centre.norm(), 1e-12);
  const Vector3d square = sides.cwiseAbs2() / 12;
  EXPECT_LT((properties.inertia - Matrix3d((square.sum() * Vector3d::Ones() - square).asDiagonal()))
                .norm(),
            1e-12);
  // Those of the lattice, of which the surface cuts half.
  EXPECT_GE(tetrahedra::DihedralAnglesOf(made).least, 45 - 1e-9);
  EXPECT_LE(tetrahedra::DihedralAnglesOf(made).most, 90 + 1e-9);
}

TEST(Stuffing, VolumeAndInertiaConvergeWithTheSquareOfTheCell) {
  struct SolidForm {
    std::string name;
    meshes::Mesh mesh;
    double volume;
    Vector3d inertia;  ///< for a mass of 1
  };
  const double across = 9.0 / 2 + 5.0 / 8, along = 9 + 3.0 / 4;
  const SolidForm cases[] = {
      {"sphere", SphereMesh(1, 7), 4 * std::numbers::pi / 3, Vector3d::Constant(0.4)},
      {"torus",
       meshes::TorusMesh(3, 1, 256, 128),
       6 * std::numbers::pi * std::numbers::pi,
       {across, along, across}}};
  for (const SolidForm& one : cases) {
    std::vector<double> volume, inertia;
    for (const std::size_t cells : {10, 20, 40}) {
      const Tetrahedra made = tetrahedra::Stuff(one.mesh, cells, one.name);
      if (cells < 40) ExpectWellFormed(made, one.name);
      const meshes::MassProperties properties = PropertiesOf(made);
      volume.push_back(1 - properties.volume / one.volume);
      inertia.push_back((properties.inertia - Matrix3d(one.inertia.asDiagonal())).norm() /
                        one.inertia.norm());
    }
    for (const std::vector<double>& error : {volume, inertia}) {
      EXPECT_GT(std::log2(error[0] / error[1]), 1.6) << one.name;
      EXPECT_GT(std::log2(error[1] / error[2]), 1.6) << one.name;
      EXPECT_LT(error[2], 0.006) << one.name;
    }
  }
}

TEST(Stuffing, RandomMeshesAreFilledWell) {
  std::mt19937 random(7);
  std::uniform_real_distribution<> uniform(-1, 1);
  for (int i = 0; i < 12; ++i) {
    std::array<Vector3d, 4> waves;
    for (Vector3d& wave : waves) wave = 4 * Vector3d::NullaryExpr([&] { return uniform(random); });
    const meshes::Mesh mesh = StarMesh(24, [&](const Vector3d& direction) {
      double radius = 1;
      for (const Vector3d& wave : waves) radius += 0.12 * std::sin(wave.dot(direction) + wave.x());
      return radius;
    });
    const std::size_t cells = 6 + static_cast<std::size_t>(i);
    ExpectWellFormed(tetrahedra::Stuff(mesh, cells, "star"), "star " + std::to_string(i));
  }
}

TEST(Stuffing, TurnedBoxesAreFilledWell) {
  for (int i = 1; i < 6; ++i) {
    meshes::Mesh mesh = CuboidMesh({1, 0.6, 0.4});
    const Eigen::AngleAxisd turn(0.5 * i, Vector3d(1, i, 2).normalized());
    for (Vector3d& vertex : mesh.vertices) vertex = turn * vertex;
    ExpectWellFormed(tetrahedra::Stuff(mesh, 9 + static_cast<std::size_t>(i), "turned box"),
                     "turned box");
  }
}

// A cavity stays one, and where two bodies overlap there is one.
TEST(Stuffing, CavitiesAndOverlapsAreThoseOfTheWindingNumber) {
  const meshes::Mesh box = CuboidMesh({1, 1, 1});
  const auto moved = [&](const Vector3d& by) { return Moved(box, Matrix3d::Identity(), by); };
  const Tetrahedra hollow =
      tetrahedra::Stuff(Joined(box, InsideOut(CuboidMesh({0.5, 0.5, 0.5}))), 8, "hollow");
  ExpectWellFormed(hollow, "hollow");
  EXPECT_NEAR(PropertiesOf(hollow).volume, 1 - 0.125, 1e-12);
  const Tetrahedra united = tetrahedra::Stuff(Joined(box, moved({0.5, 0, 0})), 12, "united");
  ExpectWellFormed(united, "united");
  EXPECT_NEAR(PropertiesOf(united).volume, 1.5, 1e-12);
}

TEST(Stuffing, RefusesPieces) {
  const meshes::Mesh box = CuboidMesh({1, 1, 1});
  EXPECT_THAT(
      Refusal([&] {
        tetrahedra::Stuff(Joined(box, Moved(box, Matrix3d::Identity(), {3, 0, 0})), 8, "two.obj");
      }),
      testing::HasSubstr("two.obj: at 8 cells, its tetrahedra are 2 pieces"));
}

TEST(Stuffing, IsTheSameEachTime) {
  const meshes::Mesh mesh = SphereMesh(1, 4);
  const Tetrahedra first = tetrahedra::Stuff(mesh, 9, "a"),
                   second = tetrahedra::Stuff(mesh, 9, "b");
  EXPECT_EQ(first.corners, second.corners);
  EXPECT_EQ(first.nodes, second.nodes);
}

}  // namespace
}  // namespace cdb::tests
