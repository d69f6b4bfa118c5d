#include "runtime/engine/soft/crossings.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

analysis::SoftMesh Strip() {
  return analysis::MeshOf(
      schema::Call{"cloth", {schema::Number(std::uint64_t{12}), schema::Number(std::uint64_t{2})}});
}

std::vector<Vector3d> Flat(const analysis::SoftMesh& mesh) {
  std::vector<Vector3d> nodes;
  for (std::size_t i = 0; i < mesh.NodeCount(); ++i) {
    const Vector3d place = mesh.PlaceOf(i);
    nodes.emplace_back(12 * place.x(), 0, 2 * place.z());
  }
  return nodes;
}

TEST(Crossings, AFlatClothHasNone) {
  const analysis::SoftMesh mesh = Strip();
  EXPECT_EQ(soft::CountCrossings(mesh, Flat(mesh)), 0u);
}

TEST(Crossings, AFoldThatOnlyLiesOnItselfHasNone) {
  const analysis::SoftMesh mesh = Strip();
  std::vector<Vector3d> nodes = Flat(mesh);
  for (Vector3d& node : nodes)
    if (node.x() > 6) node = {12 - node.x(), 0.3, node.z()};
  EXPECT_EQ(soft::CountCrossings(mesh, nodes), 0u);
}

TEST(Crossings, ALoopThroughItselfHasSome) {
  const analysis::SoftMesh mesh = Strip();
  std::vector<Vector3d> nodes = Flat(mesh);
  // The end is folded back and dips through the start.
  for (Vector3d& node : nodes)
    if (node.x() > 6) node = {12.3 - node.x(), node.x() < 10.5 ? 0.5 : -0.5, node.z() * 0.9 + 0.13};
  EXPECT_GT(soft::CountCrossings(mesh, nodes), 0u);
}

// Against every pair, without the sweep.
TEST(Crossings, AreThoseOfEveryPair) {
  const analysis::SoftMesh mesh = Strip();
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 1);
  for (int round = 0; round < 50; ++round) {
    std::vector<Vector3d> nodes = Flat(mesh);
    for (Vector3d& node : nodes) node += Vector3d(noise(random), noise(random), noise(random));
    std::size_t count = 0;
    for (const auto& link : mesh.links) {
      bool pierces = false;
      for (const auto& [a, b, c] : mesh.triangles) {
        if (link[0] == a || link[0] == b || link[0] == c || link[1] == a || link[1] == b ||
            link[1] == c)
          continue;
        // Where the line meets the plane, in barycentric coordinates.
        Eigen::Matrix3d columns;
        columns << nodes[b] - nodes[a], nodes[c] - nodes[a], nodes[link[0]] - nodes[link[1]];
        const Vector3d at = columns.fullPivLu().solve(nodes[link[0]] - nodes[a]);
        pierces = pierces ||
                  (at.x() > 0 && at.y() > 0 && at.x() + at.y() < 1 && at.z() > 0 && at.z() < 1);
      }
      count += pierces;
    }
    EXPECT_EQ(soft::CountCrossings(mesh, nodes), count);
  }
}

}  // namespace
}  // namespace cdb::tests
