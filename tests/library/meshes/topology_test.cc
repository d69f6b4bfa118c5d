#include "library/meshes/topology.h"

#include <gtest/gtest.h>

#include "library/meshes/mass_properties.h"
#include "library/meshes/primitives.h"
#include "tests/library/meshes/test_meshes.h"

namespace cdb::tests {
namespace {

using namespace testing;
using Eigen::Vector3d;

meshes::Mesh Cube(double half = 1, const Vector3d& at = Vector3d::Zero()) {
  return BoxMesh(at - Vector3d::Constant(half), at + Vector3d::Constant(half));
}
std::string RefusedMesh(const meshes::Mesh& mesh) {
  return Refusal([&] { meshes::Watertight(mesh, "m"); });
}

TEST(Topology, ClosedMeshesStayAsTheyAre) {
  for (const meshes::Mesh& mesh :
       {Cube(), AngleMesh(), SphereMesh(2, 2), meshes::TetrahedronMesh(1),
        meshes::TorusMesh(3, 1, 12, 8), Joined(Cube(), Cube(1, {5, 0, 0}))})
    EXPECT_EQ(meshes::Watertight(mesh, "m"), mesh);
}

TEST(Topology, OpenEdgesAreCountedAndPlaced) {
  meshes::Mesh open = Cube();
  open.triangles.pop_back();
  EXPECT_EQ(RefusedMesh(open),
            "m: is not watertight: 3 edges of one face only, the first from (1, -1, -1) to "
            "(1, -1, 1); close the holes in a modelling program");
}

TEST(Topology, FacesMustAgree) {
  meshes::Mesh mesh = Cube();
  std::swap(mesh.triangles[0][1], mesh.triangles[0][2]);
  EXPECT_EQ(RefusedMesh(mesh).substr(0, 47), "m: 3 edges where the two faces are oriented inc");
  // Two cubes that share an edge with the same vertices.
  const meshes::Mesh crowded = meshes::MergeEqualVertices(Joined(Cube(), Cube(1, {2, 2, 0})));
  EXPECT_EQ(RefusedMesh(crowded).substr(0, 36), "m: 1 edge of more than two faces, th");
  meshes::Mesh twice = Cube();
  twice.triangles.push_back({0, 1, 1});
  EXPECT_EQ(RefusedMesh(twice).substr(0, 42), "m: 1 of 13 triangles have a vertex twice, ");
}

TEST(Topology, InsideOutIsTurnedRound) {
  const meshes::Mesh turned = meshes::Watertight(InsideOut(Cube()), "m");
  EXPECT_DOUBLE_EQ(meshes::SignedVolume(turned), 8);
  EXPECT_EQ(turned, Cube());
}

TEST(Topology, APartInsideOutIsACavityOrAnError) {
  const meshes::Mesh hollow = Joined(Cube(2), InsideOut(Cube(1)));
  EXPECT_DOUBLE_EQ(meshes::SignedVolume(meshes::Watertight(hollow, "m")), 64 - 8);
  EXPECT_EQ(RefusedMesh(Joined(Cube(2), InsideOut(Cube(1, {5, 0, 0})))),
            "m: the part from (4, -1, -1) to (6, 1, 1) is inside out, but not a cavity of another "
            "part; flip its faces");
}

TEST(Topology, NoVolumeIsRefused) {
  meshes::Mesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_EQ(RefusedMesh(flat), "m: has no volume; a flat or folded surface is not a solid");
  EXPECT_EQ(RefusedMesh({}), "m: has no faces; a model needs a closed surface");
}

TEST(Topology, UnusedVerticesAreDropped) {
  meshes::Mesh mesh = Cube();
  mesh.vertices.insert(mesh.vertices.begin(), {9, 9, 9});
  for (meshes::Triangle& t : mesh.triangles)
    for (std::uint32_t& vertex : t) ++vertex;
  EXPECT_EQ(meshes::Watertight(mesh, "m"), Cube());
}

TEST(Topology, SeamsAreClosedAndTouchingPartsStayApart) {
  // Each face has separate vertices.
  meshes::Mesh split;
  const meshes::Mesh cube = Cube();
  for (const meshes::Triangle& t : cube.triangles)
    for (const Vector3d& corner : meshes::CornersOf(cube, t)) split.vertices.push_back(corner);
  for (std::uint32_t i = 0; i < 36; i += 3) split.triangles.push_back({i, i + 1, i + 2});
  EXPECT_EQ(meshes::Watertight(split, "m").vertices.size(), 8u);
  EXPECT_EQ(meshes::Watertight(Joined(Cube(), Cube(1, {2, 2, 0})), "m").vertices.size(), 16u);
}

TEST(Topology, PartsAreCounted) {
  EXPECT_EQ(meshes::PartsOf(Joined(Cube(), Cube(1, {5, 0, 0}))).back(), 1u);
  EXPECT_EQ(meshes::PartsOf(AngleMesh()), std::vector<std::uint32_t>(20, 0));
}

TEST(Topology, HolesAreCapped) {
  meshes::Mesh open = Cube();
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 4);  // two sides
  const meshes::Mesh closed = meshes::Watertight(meshes::CloseHoles(open, "m"), "m");
  EXPECT_EQ(closed.vertices.size(), 10u);
  EXPECT_DOUBLE_EQ(meshes::SignedVolume(closed), 8);
  meshes::Mesh corner = Cube();
  corner.triangles.pop_back();
  EXPECT_EQ(meshes::Watertight(meshes::CloseHoles(corner, "m"), "m").triangles.size(), 12u);
  EXPECT_EQ(meshes::CloseHoles(Cube(), "m"), Cube());
  // Removing two triangles that share only a corner leaves holes that touch there.
  meshes::Mesh touching = Cube();
  touching.triangles.erase(touching.triangles.begin());      // 0 2 3
  touching.triangles.erase(touching.triangles.begin() + 4);  // 0 5 4
  EXPECT_EQ(Refusal([&] { meshes::CloseHoles(touching, "m"); }),
            "m: holes touch at (-1, -1, -1); close them in a modelling program");
}

}  // namespace
}  // namespace cdb::tests
