#include "library/meshes/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "library/meshes/mass_properties.h"
#include "library/meshes/topology.h"
#include "tests/library/meshes/test_meshes.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using namespace testing;
using Eigen::Vector3d;

meshes::Mesh Sample() { return BoxMesh({-1, 0.25, -3}, {1.5, 2, 1e-3}); }

std::string RefusedFile(std::string_view bytes, std::string_view name) {
  return Refusal([&] { meshes::ParseMesh(bytes, name); });
}
bool Has(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

TEST(Mesh, EveryFormatWithSharedVerticesGivesTheSame) {
  EXPECT_EQ(meshes::ParseMesh(ToOff(Sample()), "a.off"), Sample());
  EXPECT_EQ(meshes::ParseMesh(ToObj(Sample()), "a.obj"), Sample());
  EXPECT_EQ(meshes::ParseMesh(ToPly(Sample()), "a.ply"), Sample());
  EXPECT_EQ(meshes::ParseMesh(ToBinaryPly(Sample(), false), "a.PLY"), Sample());
  EXPECT_EQ(meshes::ParseMesh(ToBinaryPly(Sample(), true), "a.ply"), Sample());
}

TEST(Mesh, StlSharesVerticesAgain) {
  const meshes::Mesh text = meshes::ParseMesh(ToStl(Sample()), "a.stl");
  EXPECT_EQ(text.vertices.size(), 8u);
  EXPECT_EQ(text.triangles.size(), 12u);
  EXPECT_DOUBLE_EQ(meshes::SignedVolume(meshes::Watertight(text, "a.stl")),
                   meshes::SignedVolume(Sample()));
  const meshes::Mesh binary = meshes::ParseMesh(ToBinaryStl(Sample()), "a.stl");
  EXPECT_EQ(binary.vertices.size(), 8u);
  EXPECT_EQ(binary.triangles, text.triangles);
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_EQ(binary.vertices[i], text.vertices[i].cast<float>().cast<double>());
}

TEST(Mesh, ReadsAFile) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "sample.off";
  WriteFile(file, ToOff(Sample()));
  EXPECT_EQ(meshes::ReadMesh(file), Sample());
  std::filesystem::remove(file);
  EXPECT_EQ(Refusal([&] { meshes::ReadMesh(file); }), file.string() + ": there is no such file");
  EXPECT_TRUE(Has(Refusal([&] { meshes::ReadMesh(file.parent_path()); }), "is not a file"));
}

TEST(Mesh, ObjCountsBackAndForwardAndJoinsLines) {
  const meshes::Mesh mesh = meshes::ParseMesh(
      "f 1 2 3 \\\n 4\nv 0 0 0 1 1 1\rv +1 0 0\r\nv 1 1 0\nv 0 1 0\nf -1 -2 -3\n", "a.obj");
  EXPECT_EQ(mesh.triangles, (std::vector<meshes::Triangle>{{0, 1, 2}, {0, 2, 3}, {3, 2, 1}}));
}

TEST(Mesh, ObjMayHaveAMarkAndVerticesAlone) {
  const meshes::Mesh mesh =
      meshes::ParseMesh("\xef\xbb\xbfv 0 0 0\r\nv 1e-320 0 0\r\nv 0 1 0\r\nv 0 0 1", "a.obj");
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_TRUE(mesh.triangles.empty());
}

TEST(Mesh, OffMayBeWrittenInManyWays) {
  const std::string_view body = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
  const meshes::Mesh mesh = meshes::ParseMesh("OFF\n4 4 6\n" + std::string(body), "a.off");
  for (const std::string_view head : {"OFF 4 4 6\n", "OFF4 4 6 # or so\n", "OFF\n\n4 4\n"})
    EXPECT_EQ(meshes::ParseMesh(std::string(head) + std::string(body), "a.off"), mesh) << head;
  std::string line(body);
  std::ranges::replace(line, '\n', ' ');
  EXPECT_EQ(meshes::ParseMesh("OFF 4 4 6 " + line, "a.off"), mesh);
  EXPECT_EQ(meshes::ParseMesh("\xef\xbb\xbfOFF\r4\r4\r6\r" + line, "a.off"), mesh);
  // Lines that are wrapped; points, edges and the colours of faces are not read.
  EXPECT_EQ(meshes::ParseMesh("OFF\n4 6 6\n0 0\n0\n1 0 0\n0 1 0\n0 0 1\n1 0\n2 0 1\n3 0\n2 1\n"
                              "3 0 1 3 255 0 0\n3 1 2 3\n3 2 0 3\n",
                              "a.off")
                .triangles.size(),
            4u);
  // Colours and normals, with and without line ends.
  const std::string coloured =
      "0 0 0 9 9 9 9\n1 0 0 9 9 9 9\n0 1 0 9 9 9 9\n0 0 1 9 9 9 9\n3 0 2 1\n3 0 1 3\n3 1 2 3\n"
      "3 2 0 3\n";
  EXPECT_EQ(meshes::ParseMesh("COFF\n4 4 6\n" + coloured, "a.off"), mesh);
  line = coloured;
  std::ranges::replace(line, '\n', ' ');
  EXPECT_EQ(meshes::ParseMesh("COFF 4 4 6 " + line, "a.off"), mesh);
}

TEST(Mesh, StlMayHaveMoreThanItsTriangles) {
  const meshes::Mesh binary = meshes::ParseMesh(ToBinaryStl(Sample()), "a.stl");
  for (const std::string_view more : {"\n", "solid"})
    EXPECT_EQ(meshes::ParseMesh(ToBinaryStl(Sample()) + std::string(more), "a.stl"), binary);
  const meshes::Mesh text = meshes::ParseMesh(ToStl(Sample()), "a.stl");
  EXPECT_EQ(meshes::ParseMesh("\n" + ToStl(Sample()) + std::string(3, '\0'), "a.stl"), text);
}

TEST(Mesh, PlyMayHaveMoreThanItsFacesAndPropertiesThatAreNoNumbers) {
  const std::string head =
      "ply \nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nproperty float quality\n";
  const std::string vertices = "0 0 0 nan\n1 0 0 -inf\n0 1 0 1.#QNAN\n0 0 1 0\n";
  const meshes::Mesh faces = meshes::ParseMesh(
      head + "element face 2\nproperty list uchar int vertex_index\nend_header\n" + vertices +
          "3 0 1 2\n3 2 1 3\nmore\n",
      "a.ply");
  EXPECT_EQ(faces.triangles, (std::vector<meshes::Triangle>{{0, 1, 2}, {2, 1, 3}}));
  // A strip, which -1 interrupts.
  EXPECT_EQ(meshes::ParseMesh(
                head + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" +
                    vertices + "8 0 1 2 3 -1 0 2 1\n",
                "a.ply")
                .triangles,
            (std::vector<meshes::Triangle>{{0, 1, 2}, {2, 1, 3}, {0, 2, 1}}));
  for (const bool big : {false, true})
    EXPECT_EQ(meshes::ParseMesh(ToBinaryPly(Sample(), big) + "more", "a.ply"), Sample());
}

TEST(Mesh, FilesOfOtherKindsAreNamed) {
  EXPECT_EQ(
      RefusedFile("<?xml version='1.0'?>\n<!-- by x --><robot name='r'>", "a.obj"),
      "a.obj: is a robot description (URDF); write `robot NAME { file \"a.obj\" }`, outside of "
      "objects");
  EXPECT_EQ(RefusedFile("$MeshFormat", "some/a.msh"),
            "some/a.msh: is a mesh of Gmsh; convert it: `meshio convert a.msh a.ply`");
  EXPECT_EQ(RefusedFile("version https://git-lfs.github.com/spec/v1\n", "a.stl"),
            "a.stl: is a pointer of Git LFS; run `git lfs pull` where it is");
  EXPECT_EQ(RefusedFile(ToPly(Sample()), "a.obj"),
            "a.obj: is a PLY file; let its name end in .ply");
  EXPECT_TRUE(Has(RefusedFile("\xff\xfev", "a.obj"), "is text in UTF-16; save it as UTF-8"));
}

TEST(Mesh, PolygonsBecomeFans) {
  const meshes::Mesh mesh = meshes::ParseMesh(
      "NOFF 5 1\n0 0 0 0 0 1\n1 0 0 0 0 1\n2 1 0 0 0 1\n1 2 0 0 0 1\n"
      "0 1 0 0 0 1\n5 0 1 2 3 4\n",
      "a.off");
  EXPECT_EQ(mesh.triangles, (std::vector<meshes::Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

struct Broken {
  const char *name, *text, *says;
};
class EveryBrokenText : public ::testing::TestWithParam<Broken> {};
INSTANTIATE_TEST_SUITE_P(
    Mesh, EveryBrokenText,
    ::testing::Values(
        Broken{"a.doc", "", "a.doc: unknown format"},
        Broken{"a.obj", "o thing\n", "a.obj: has no faces and no vertices"},
        Broken{"a.obj", "v 0 0\n", "a.obj:1: a vertex needs 3"},
        Broken{"a.obj", "v 0 0 nan\n", "a.obj:1: `nan` should be a number"},
        Broken{"a.obj", "\nv 0 0 1e999\n", "a.obj:2: `1e999` should be a number"},
        Broken{"a.obj", "v 0 0 1e16\n", "a.obj:1: the coordinate 1e+16 is not"},
        Broken{"a.obj", "v 0 0 0x\n", "a.obj:1: `0x` should be a number"},
        Broken{"a.obj", "v 0 0 0\nf 1 1 2\n", "a.obj:2: a face has vertex 2, counted from 1"},
        Broken{"a.obj", "v 0 0 0\nf 0 1 1\n", "a.obj:2: a face has vertex 0; they count from 1"},
        Broken{"a.obj", "v 0 0 0\nf -2 1 1\n", "a.obj:2: a face has vertex -2"},
        Broken{"a.obj", "v 0 0 0\nf 1 -9223372036854775808 1\n", "a.obj:2: a face has vertex -9"},
        Broken{"a.obj", "v 0 0 0\nf 1 1 9223372036854775807\n", "a.obj:2: a face has vertex 9"},
        Broken{"a.obj", "v 0 0 0\nf 1 1\n", "a.obj:2: a face needs 3 corners"},
        Broken{"a.obj", "v 0 0 0\nf 1 1 1/1/1/1\n", "a.obj:2: `1/1/1/1` has too many parts"},
        Broken{"a.obj", "v 0 0 0\nf 1 1 1/x\n", "a.obj:2: `x` should be a whole number"},
        Broken{"a.obj", "cstype bezier\n", "a.obj:1: cannot read `cstype`"},
        Broken{"a.off", "", "the file ends before its first word"},
        Broken{"a.off", "4OFF\n", "a.off:1: starts with `4OFF`"},
        Broken{"a.off", "OFF BINARY\n", "a.off:1: binary OFF is not supported"},
        Broken{"a.off", "OFF\n-1 3 0\n", "a.off:2: declares -1 vertices"},
        Broken{"a.off", "OFF\n4000000000 3 0\n",
               "a.off:2: declares 4000000000 vertices, which do not fit"},
        Broken{"a.off", "OFF\n1 8 0\n0 0 0\n",
               "a.off:3: the file ends before the end of face 1 of 8"},
        Broken{"a.off", "OFF\n1 1 0\n0 0\n", "a.off:3: the file ends before vertex 1 of 1"},
        Broken{"a.off", "OFF\n1 1 0\n0 0 0\n3 0 0\n",
               "a.off:4: the file ends before the end of face 1 of 1"},
        Broken{"a.off", "OFF\n1 1 0\n0 0 0\n0\n", "a.off:4: a face cannot have 0 corners"},
        Broken{"a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 1\n", "a.off:4: a face has vertex 1"},
        Broken{"a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 0\n3 0 0 0\n", "a.off:5: continues after"},
        Broken{"a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n",
               "a.stl:4: the file ends before a coordinate"},
        Broken{"a.stl", "solid x\nfacet normal 0 0 1\nouter vertex\n",
               "a.stl:3: `vertex` instead of `loop`"},
        Broken{"a.stl", "solid x\n", "a.stl:1: the file ends before `endsolid`"},
        Broken{"a.stl", "x", "a.stl: byte 1: the file ends before the number of triangles"},
        Broken{"a.ply", "PLY\n", "a.ply:1: should start with a line `ply`"},
        Broken{"a.ply", "ply\nformat ascii 1.0\n", "the header has no `end_header`"},
        Broken{"a.ply", "ply\nformat mixed 1.0\nend_header\n", "the format `mixed` is not one"},
        Broken{"a.ply", "ply\nformat ascii 1.0\nend_header\n", "has no `element vertex`"},
        Broken{"a.ply", "ply\nproperty int x\n", "a.ply:2: cannot read `property int x`"},
        Broken{"a.ply", "ply\nelement vertex 1\nproperty long x\n", "`long` is not a type"},
        Broken{"a.ply", "ply\nelement face 1\nproperty list float int vertex_index\n",
               "a.ply:3: a list's length must be a whole number"},
        Broken{"a.ply",
               "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int x\n"
               "property int x\nproperty int x\nproperty int x\nproperty int z\nend_header\n"
               "1 1 1 1 1 1\n",
               "a.ply:3: a vertex needs each of the properties x, y and z once"},
        Broken{"a.ply", "ply\nformat ascii 1.0\nelement vertex 99\nend_header\n",
               "a.ply:3: `vertex` has no properties"},
        Broken{"a.ply",
               "ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\n",
               "a.ply:3: `18446744073709551615` should be a whole number"},
        Broken{"a.ply",
               "ply\nformat ascii 1.0\nelement vertex 9223372036854775807\nproperty int x\n"
               "property int y\nproperty int z\nend_header\n0 0 0\n",
               "a.ply:3: declares 9223372036854775807 of `vertex`, which do not fit"},
        Broken{"a.ply",
               "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\n"
               "property int z\nelement face 1\nproperty list int int vertex_index\nend_header\n"
               "0 0 0\n1000000 0 0 0\n",
               "a.ply:11: a list of 1000000 values does not fit"},
        Broken{"a.ply",
               "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\n"
               "property int z\nelement face 1\nproperty list int int vertex_index\nend_header\n"
               "0 0 0\n3 0 0 0.5\n",
               "a.ply:11: a face has vertex 0.5"}));
TEST_P(EveryBrokenText, IsRefusedByLine) {
  const std::string message = RefusedFile(GetParam().text, GetParam().name);
  EXPECT_TRUE(Has(message, GetParam().says)) << message;
}

TEST(Mesh, CutOffFilesAreRefused) {
  for (const bool big : {false, true}) {
    const std::string ply = ToBinaryPly(Sample(), big);
    for (std::size_t cut = 1; cut < ply.size(); ++cut)
      EXPECT_TRUE(RefusedFile(ply.substr(0, ply.size() - cut), "a.ply").starts_with("a.ply:"));
  }
  const std::string stl = ToBinaryStl(Sample());
  EXPECT_TRUE(Has(RefusedFile(stl.substr(0, stl.size() - 1), "a.stl"), "truncated"));
  std::string lies = stl;
  lies[0] = 'S' + 1;
  lies[83] = '\x7f';
  EXPECT_TRUE(Has(RefusedFile(lies, "a.stl"), "byte 80: declares 21307"))
      << RefusedFile(lies, "a.stl");
}

TEST(Mesh, BinaryNumbersAreFinite) {
  std::string stl = ToBinaryStl(Sample());
  for (std::size_t i = 84 + 12 + 4; i < 84 + 12 + 8; ++i) stl[i] = '\xff';
  EXPECT_TRUE(Has(RefusedFile(stl, "a.stl"), "a.stl: byte 96: the coordinate"));
}

TEST(Mesh, MergingDropsWhatCollapses) {
  meshes::Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0, 0, 0}, {1, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 2}, {0, 3, 1}};
  const meshes::Mesh merged = meshes::MergeEqualVertices(mesh);
  EXPECT_EQ(merged.vertices.size(), 3u);
  EXPECT_EQ(merged.triangles, (std::vector<meshes::Triangle>{{0, 1, 2}, {0, 1, 2}}));
}

}  // namespace
}  // namespace cdb::tests
