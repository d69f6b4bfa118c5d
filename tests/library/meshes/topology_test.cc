#include "library/meshes/topology.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

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
  EXPECT_EQ(
      RefusedMesh(open),
      "m: is not watertight: 3 edges of one face only, the first from (1, -1, -1) to "
      "(1, -1, 1); close the holes in a modelling program; hull and surface take it as it is");
}

TEST(Topology, EdgesOfThreeFacesAreRefused) {
  meshes::Mesh fin = Cube();
  fin.vertices.emplace_back(0, 0, 3);
  fin.triangles.insert(fin.triangles.end(), {{4, 5, 8}, {5, 7, 8}, {7, 4, 8}});
  EXPECT_EQ(RefusedMesh(fin),
            "m: 3 edges of an odd number of faces, the first from (-1, -1, 1) to (1, -1, 1); a "
            "solid's surface has an even number at each; hull and surface take it as it is");
}

TEST(Topology, DegenerateAndDoubledFacesAreDropped) {
  meshes::Mesh mesh = Cube();
  mesh.triangles.push_back({0, 1, 1});
  mesh.triangles.push_back({3, 0, 2});
  EXPECT_EQ(meshes::Watertight(mesh, "m"), Cube());
  // A file with both sides of each face.
  EXPECT_EQ(meshes::Watertight(Joined(Cube(), {}), "m"), Cube());
  meshes::Mesh sides = Cube();
  for (const meshes::Triangle& t : InsideOut(Cube()).triangles) sides.triangles.push_back(t);
  EXPECT_EQ(meshes::Watertight(sides, "m"), Cube());
}

TEST(Topology, FlapsOfEqualTrianglesBoundNothing) {
  meshes::Mesh flap = Cube();
  flap.vertices.emplace_back(3, 3, 3);
  flap.triangles.insert(flap.triangles.end(), {{0, 1, 8}, {0, 1, 8}});
  EXPECT_EQ(meshes::Watertight(flap, "m"), Cube());
  // Three copies of a face are one.
  meshes::Mesh thick = Cube();
  thick.triangles.insert(thick.triangles.end(), {thick.triangles[3], thick.triangles[3]});
  EXPECT_EQ(meshes::Watertight(thick, "m"), Cube());
}

TEST(Topology, EdgesOfFourFacesAreTakenIfTheyBalance) {
  // Two cubes that share an edge with the same vertices.
  const meshes::Mesh touching = meshes::MergeEqualVertices(Joined(Cube(), Cube(1, {2, 2, 0})));
  EXPECT_EQ(meshes::Watertight(touching, "m"), touching);
  // One of them inside out: neighbours by angle show which faces bound the solid.
  meshes::Mesh turned = touching;
  for (std::size_t i = 0; i < 12; ++i) std::swap(turned.triangles[i][1], turned.triangles[i][2]);
  EXPECT_DOUBLE_EQ(meshes::SignedVolume(meshes::Watertight(turned, "m")), 16);
}

TEST(Topology, InsideOutIsTurnedRound) {
  const meshes::Mesh turned = meshes::Watertight(InsideOut(Cube()), "m");
  EXPECT_DOUBLE_EQ(meshes::SignedVolume(turned), 8);
  EXPECT_EQ(turned, Cube());
}

TEST(Topology, APartInsideOutIsACavityOnlyWithinAnother) {
  const meshes::Mesh hollow = Joined(Cube(2), InsideOut(Cube(1)));
  EXPECT_EQ(meshes::Watertight(hollow, "m"), hollow);
  EXPECT_EQ(meshes::Watertight(InsideOut(hollow), "m"), hollow);
  EXPECT_EQ(meshes::Watertight(Joined(Cube(2), InsideOut(Cube(1, {5, 0, 0}))), "m"),
            Joined(Cube(2), Cube(1, {5, 0, 0})));
  // In the box of the other part, but not in the part.
  const meshes::Mesh beside =
      Joined(Moved(AngleMesh(), 4 * Eigen::Matrix3d::Identity(), {0, 0, 0}), Cube(0.5, {6, 6, 2}));
  EXPECT_EQ(
      meshes::Watertight(Joined(Moved(AngleMesh(), 4 * Eigen::Matrix3d::Identity(), {0, 0, 0}),
                                InsideOut(Cube(0.5, {6, 6, 2}))),
                         "m"),
      beside);
  // A hollow part inside out, beside a larger one that is not.
  EXPECT_EQ(meshes::Watertight(Joined(Cube(4, {9, 0, 0}), InsideOut(hollow)), "m"),
            Joined(Cube(4, {9, 0, 0}), hollow));
  // Overlapping parts stay: points in both are inside.
  const meshes::Mesh overlapping = Joined(Cube(2), Cube(1));
  EXPECT_EQ(meshes::Watertight(overlapping, "m"), overlapping);
}

/// Whether two meshes have the same faces, in the same directions.
bool SameFaces(meshes::Mesh a, meshes::Mesh b) {
  for (meshes::Mesh* mesh : {&a, &b})
    for (meshes::Triangle& t : mesh->triangles) std::ranges::rotate(t, std::ranges::min_element(t));
  return a == b;
}

TEST(Topology, FacesTurnedAtRandomGiveTheSameSolid) {
  std::mt19937 random(1);
  const meshes::Mesh island =
      Joined(Joined(SphereMesh(9, 2), InsideOut(Cube(4))), meshes::TorusMesh(2, 1, 12, 8));
  for (const meshes::Mesh& mesh :
       {Cube(), AngleMesh(), SphereMesh(2, 3), meshes::TorusMesh(3, 1, 12, 8), island,
        Joined(island, Cube(1, {12, 0, 0})),
        meshes::MergeEqualVertices(Joined(Cube(), Cube(1, {2, 2, 0})))})
    for (const unsigned part : {2u, 3u, 50u}) {
      meshes::Mesh turned = mesh;
      for (meshes::Triangle& t : turned.triangles)
        if (random() % part == 0) std::swap(t[1], t[2]);
      EXPECT_TRUE(SameFaces(meshes::Watertight(turned, "m"), mesh)) << part;
    }
}

TEST(Topology, OneSidedSurfacesAreRefused) {
  // The projective plane with six vertices: closed, but without an inside.
  meshes::Mesh mesh;
  for (int i = 0; i < 6; ++i) mesh.vertices.emplace_back(i, i * i, i * i * i);
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 1},
                    {1, 2, 4}, {2, 3, 5}, {3, 4, 1}, {4, 5, 2}, {5, 1, 3}};
  EXPECT_EQ(
      RefusedMesh(mesh).substr(0, 88),
      "m: has no inside: its faces cannot be made to agree, as on a Moebius strip, at the edge ");
}

TEST(Topology, NoVolumeIsRefused) {
  meshes::Mesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_EQ(RefusedMesh(flat),
            "m: has no volume; a flat or folded surface is not a solid; surface takes it as it is");
  EXPECT_EQ(RefusedMesh({}),
            "m: has no faces; a solid needs a closed surface; no type takes it as it is");
  EXPECT_EQ(RefusedMesh({Cube().vertices, {}}),
            "m: has no faces; a solid needs a closed surface; hull takes it as it is");
}

TEST(Topology, UnusedVerticesAreDropped) {
  meshes::Mesh mesh = Cube();
  mesh.vertices.insert(mesh.vertices.begin(), {9, 9, 9});
  for (meshes::Triangle& t : mesh.triangles)
    for (std::uint32_t& vertex : t) ++vertex;
  EXPECT_EQ(meshes::Watertight(mesh, "m"), Cube());
}

/// With separate vertices for each face, each moved by up to `distance` along each axis.
meshes::Mesh Split(const meshes::Mesh& mesh, double distance) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> by(-distance, distance);
  meshes::Mesh split;
  for (const meshes::Triangle& t : mesh.triangles) {
    const auto next = static_cast<std::uint32_t>(split.vertices.size());
    for (const Vector3d& corner : meshes::CornersOf(mesh, t))
      split.vertices.push_back(corner + Vector3d(by(random), by(random), by(random)));
    split.triangles.push_back({next, next + 1, next + 2});
  }
  return split;
}

TEST(Topology, SeamsAreClosedAndTouchingPartsStayApart) {
  EXPECT_EQ(meshes::Watertight(Split(Cube(), 0), "m").vertices.size(), 8u);
  EXPECT_EQ(meshes::Watertight(Joined(Cube(), Cube(1, {2, 2, 0})), "m").vertices.size(), 16u);
}

TEST(Topology, CloseVerticesOfSeamsAreWelded) {
  for (const meshes::Mesh& mesh :
       {Cube(), AngleMesh(), SphereMesh(1000, 3), meshes::TorusMesh(3, 1, 12, 8)}) {
    double size = 0;
    for (const Vector3d& vertex : mesh.vertices) size = std::max(size, vertex.maxCoeff());
    // Two vertices are up to twice as far apart as each has moved.
    const meshes::Mesh welded = meshes::Watertight(Split(mesh, 0.4e-8 * size), "m");
    EXPECT_EQ(welded.vertices.size(), mesh.vertices.size());
    EXPECT_EQ(welded.triangles.size(), mesh.triangles.size());
    EXPECT_NEAR(meshes::SignedVolume(welded), meshes::SignedVolume(mesh),
                1e-6 * meshes::SignedVolume(mesh));
    EXPECT_TRUE(RefusedMesh(Split(mesh, 1e-4 * size)).starts_with("m: is not watertight"));
  }
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
