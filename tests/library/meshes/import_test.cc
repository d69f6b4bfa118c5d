#include "library/meshes/import.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>

#include "compiler/plan/foreign_model.h"
#include "library/meshes/mass_properties.h"
#include "library/meshes/topology.h"
#include "library/sanitizers.h"
#include "tests/library/meshes/test_meshes.h"
#include "tests/support/files.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

const fs::path kCorpus = SourceFolder() / "tests/fuzz/corpus_import";

/// An L without symmetry; each file of the corpus has it in its own unit, axes and nodes.
meshes::Mesh Target() {
  return Moved(AngleMesh(), Vector3d(1.5, 1, 2).asDiagonal(), {0.25, -1, 0.5});
}

class Imports : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!plan::ImporterOf(".dae").empty()) return;
    std::cout << "skipped: needs libassimp-dev (./setup --import)\n";
    GTEST_SKIP();
  }
};

bool Has(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

Eigen::AlignedBox3d BoxOf(const meshes::Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return box;
}

TEST_F(Imports, EveryFormatGivesTheSameSolid) {
  const meshes::MassProperties wanted = meshes::MassPropertiesOf(Target());
  int formats = 0;
  for (const std::string& name : FilesIn(kCorpus)) {
    if (!name.starts_with("angle.")) continue;
    ++formats;
    const meshes::Mesh mesh = meshes::ReadMesh(kCorpus / name);
    EXPECT_EQ(mesh.vertices.size(), 12u) << name;
    EXPECT_EQ(mesh.triangles.size(), 20u) << name;
    const meshes::Mesh solid = meshes::Watertight(mesh, name);
    EXPECT_EQ(solid.vertices, mesh.vertices) << name << ": closed as it is";
    EXPECT_EQ(solid.triangles, mesh.triangles) << name << ": outwards as it is";
    const meshes::MassProperties mass = meshes::MassPropertiesOf(solid);
    EXPECT_NEAR(mass.volume, wanted.volume, 1e-5) << name;
    EXPECT_LE((mass.centre - wanted.centre).norm(), 1e-6) << name;
    EXPECT_LE((mass.inertia - wanted.inertia).norm(), 1e-4) << name;
    EXPECT_TRUE(BoxOf(mesh).isApprox(BoxOf(Target()), 1e-6)) << name;
  }
  EXPECT_GE(formats, 10);
}

/// A glTF file of one triangle in the plane z = 0, with the members that a test adds.
std::string Gltf(const std::string& primitive, const std::string& nodes = R"([{"mesh":0}])",
                 const std::string& more = "", const std::string& version = "2.0") {
  // Three vertices of three floats: (0, 0, 0), (1, 0, 0), (0, 1, 0).
  return R"({"asset":{"version":")" + version +
         R"("},"scene":0,"scenes":[{"nodes":[0]}],"nodes":)" + nodes +
         R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0})" + primitive +
         R"(}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",)"
         R"("min":[0,0,0],"max":[1,1,0]}],"bufferViews":[{"buffer":0,"byteLength":36}],)" +
         more +
         R"("buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)"
         R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
}

std::string RefusedGltf(std::string text, std::string_view from = "", std::string_view to = "") {
  if (!from.empty()) text.replace(text.find(from), from.size(), to);
  return Refusal([&] { meshes::ParseMesh(text, "a.gltf"); });
}

TEST_F(Imports, InstancesAreTakenWithTheirNodesAndMirroredOnesStayOutwards) {
  const meshes::Mesh mesh =
      meshes::ParseMesh(Gltf("", R"([{"children":[1,2]},{"mesh":0,"translation":[5,0,0]},)"
                                 R"({"mesh":0,"scale":[-1,1,1]}])"),
                        "a.gltf");
  ASSERT_EQ(mesh.triangles.size(), 2u);
  for (const meshes::Triangle& triangle : mesh.triangles) {
    const auto [a, b, c] = meshes::CornersOf(mesh, triangle);
    const Vector3d normal = (b - a).cross(c - a);
    EXPECT_EQ(normal.z(), 1) << "a mirrored face is turned round";
  }
  EXPECT_EQ(BoxOf(mesh).min(), Vector3d(-1, 0, 0));
  EXPECT_EQ(BoxOf(mesh).max(), Vector3d(6, 1, 0));
}

TEST_F(Imports, NamesWhatIsLeftOut) {
  EXPECT_EQ(meshes::ReadMesh(kCorpus / "angle.dae").left_out, "1 line");
  EXPECT_EQ(meshes::ReadMesh(kCorpus / "angle.glb").left_out, "");
  EXPECT_EQ(meshes::ParseMesh(Gltf(R"(,"targets":[{"POSITION":0}])"), "a.gltf").left_out,
            "1 morph target");
  EXPECT_TRUE(Has(RefusedGltf(Gltf(R"(,"mode":0)")), "a.gltf: has no faces, only 3 points"));
}

TEST_F(Imports, RefusesGltfThatAssimpWouldReadWrongly) {
  EXPECT_EQ(RefusedGltf(Gltf(""), "data:application/octet-stream;base64,", "a.bin?"),
            "a.gltf: its data are in another file, "
            "'a.bin?AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA'; pack it into one file: "
            "`assimp export FILE.gltf FILE.glb`");
  EXPECT_TRUE(Has(RefusedGltf(Gltf("", R"([{"mesh":0}])", "", "1.0")),
                  "a.gltf: is of glTF version 1.0, not 2"));
  EXPECT_TRUE(Has(RefusedGltf(Gltf("", R"([{"mesh":0}])",
                                   R"("extensionsRequired":["KHR_mesh_quantization"],)")),
                  "needs the glTF extension KHR_mesh_quantization"));
  EXPECT_TRUE(
      Has(RefusedGltf(Gltf(""), "5126", "5122"), "its positions are not of the type float"));
  EXPECT_EQ(
      meshes::ParseMesh(
          Gltf("", R"([{"mesh":0}])", R"("extensionsRequired":["KHR_materials_unlit"],)"), "a.gltf")
          .triangles.size(),
      1u);
}

TEST_F(Imports, ReadsTheFilesOfDataThatGltfNames) {
  const TemporaryFolder folder;
  const std::string whole = Gltf(""), uri = "data:application/octet-stream;base64,";
  const std::size_t at = whole.find(uri), end = whole.find('"', at);
  const auto name = [&](const std::string& other) {
    std::string text = whole;
    WriteFile(folder / "a.gltf", text.replace(at, end - at, other) + "\n");
    return text;
  };
  // Of (0, 0, 0), (1, 0, 0) and (0, 1, 0), and two bytes more.
  std::string data(38, '\0');
  for (const std::size_t one : {12u, 28u}) data.replace(one, 4, std::string("\0\0\x80\x3f", 4));
  std::filesystem::create_directory(folder / "data");
  WriteFile(folder / "data/my a.bin", data);
  const std::string text = name("data/my%20a.bin");
  const meshes::Mesh mesh = meshes::ReadMesh(folder / "a.gltf");
  EXPECT_EQ(mesh.vertices, meshes::ParseMesh(whole, "a.gltf").vertices);
  EXPECT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(meshes::ReadMeshFile(folder / "a.gltf"), text + "\n" + data.substr(0, 36))
      << "as cat joins them";
  const auto refusal = [&] { return Refusal([&] { meshes::ReadMesh(folder / "a.gltf"); }); };
  WriteFile(folder / "data/my a.bin", "short");
  EXPECT_TRUE(Has(refusal(), "in 'data/my%20a.bin', which has 5 bytes instead of 36"));
  name("none.bin");
  EXPECT_TRUE(Has(refusal(), "its data are in 'none.bin': ")) << refusal();
  for (const std::string outside : {"../a.bin", "/etc/hosts", "data/../../a.bin", "%2e%2e/a.bin",
                                    "file:a.bin", "http://a.org/a.bin"}) {
    name(outside);
    EXPECT_TRUE(Has(refusal(), "is not in its folder")) << outside << ": " << refusal();
  }
}

TEST_F(Imports, RefusesOtherFilesByName) {
  const auto refused = [](const std::string& bytes, const std::string& name) {
    return Refusal([&] { meshes::ParseMesh(bytes, name); });
  };
  EXPECT_TRUE(Has(refused("", "a.dae"), "a.dae: is empty"));
  EXPECT_TRUE(Has(refused("rubbish", "a.dae"), "a.dae: assimp cannot read it: "));
  EXPECT_TRUE(Has(refused(ToStl(Target()), "a.fbx"), "a.fbx: is an STL file; let its name end in"));
  EXPECT_EQ(refused(ReadFile(kCorpus / "angle.dae"), "a.stl"),
            "a.stl: is a scene (COLLADA); let its name end in .dae");
  EXPECT_TRUE(Has(Refusal([] { meshes::ReadMesh(kCorpus / "production.3mf"); }),
                  "needs the 3MF extension http://schemas.microsoft.com/3dmanufacturing/"
                  "production/2015/06, which assimp does not apply"));
  std::string package = ReadFile(kCorpus / "production.3mf");
  for (std::size_t at; (at = package.find("3dmodel.model")) != package.npos;)
    package.replace(at, 13, "3dmodel.other");
  EXPECT_TRUE(Has(refused(package, "a.3mf"), "a.3mf: has no part 3D/3dmodel.model"));
  std::string amf = ReadFile(kCorpus / "angle.amf");
  amf.replace(amf.find("millimeter"), 10, "furlong");
  EXPECT_TRUE(Has(refused(amf, "a.amf"), "its unit is `furlong`"));
}

// Programs in place of cdb-import, which do the worst that an importer can do.
class Importers : public ::testing::Test {
 protected:
  std::string Import(const std::string& line, const meshes::ImportLimits& limits = {}) {
    const fs::path program = folder_ / "importer";
    WriteFile(program, "#!/bin/sh\n" + line + "\n");
    fs::permissions(program, fs::perms::owner_all);
    return Refusal([&] { meshes::ImportMesh("bytes", "a.dae", program, limits); });
  }

  TemporaryFolder folder_;
};

TEST_F(Importers, GetTheBytesAndTheExtensionAndNothingElse) {
  EXPECT_EQ(Import("cat; echo \" $1 $(env | grep -v -e ^PWD -e ^_ -e ^SHLVL -e ^OLDPWD)\"; exit 1"),
            "a.dae: bytes .dae ; export it again, or as OBJ, PLY or STL");
  EXPECT_EQ(Import("echo why; echo mend it; exit 1"), "a.dae: why; mend it");
  constexpr int kOpen = 57;
  ASSERT_EQ(dup2(STDERR_FILENO, kOpen), kOpen);
  EXPECT_TRUE(Has(Import("[ -e /proc/$$/fd/57 ] || echo closed; exit 1"), "a.dae: closed"));
  close(kOpen);
}

TEST_F(Importers, CrashesAreErrors) {
  EXPECT_EQ(Import("kill -SEGV $$"),
            "a.dae: assimp crashes on it (Segmentation fault); export it again, or as OBJ, PLY or "
            "STL");
  EXPECT_TRUE(Has(Import("kill -KILL $$"), "was ended by the system"));
  EXPECT_TRUE(Has(Import("exit 3"), "the importer failed without a reason"));
  EXPECT_TRUE(Has(Import("echo ply"), "a.dae:1: the header has no `end_header`"));
  EXPECT_EQ(Refusal([&] { meshes::ImportMesh("bytes", "a.dae", folder_ / "none"); }),
            "a.dae: cannot start the importer of this format: No such file or directory; install "
            "cdb again, with cdb-import");
}

TEST_F(Importers, HaveLimits) {
  const std::string slow =
      "a.dae: reading it takes longer than the 1 s that such a file needs at most";
  EXPECT_TRUE(Has(Import("while :; do :; done", {.cpu_s = 1}), slow));
  EXPECT_TRUE(Has(Import("exec sleep 1000", {.cpu_s = 1, .wall_s = 0}), slow));
  EXPECT_TRUE(Has(Import("exec sleep 1000 >&-", {.cpu_s = 1, .wall_s = 1}), slow));
  EXPECT_EQ(Import("while :; do echo 12345678; done", {.mesh_bytes = 1 << 16}),
            "a.dae: its mesh is too large; simplify the model first");
}

TEST_F(Importers, HaveLittleMemory) {
  if (library::kReservesAddresses) GTEST_SKIP();
  const std::string refusal =
      Import("x=0123456789; while :; do x=$x$x; done", {.cpu_s = 60, .memory_bytes = 16 << 20});
  EXPECT_TRUE(Has(refusal, "a.dae: the importer failed without a reason") ||
              Has(refusal, "assimp crashes on it"))
      << refusal;
}

TEST(ForeignModels, AreImportedOnlyIfTheBuildCan) {
  EXPECT_EQ(plan::ImporterOf(".DAE"), plan::ImporterOf(".glb"));
  for (const char* other : {".urdf", ".usd", ".blend", ".step", ".wrl", ".obj", ""})
    EXPECT_EQ(plan::ImporterOf(other), "") << other;
  if (plan::ImporterOf(".dae").empty()) {
    EXPECT_EQ(Refusal([] { meshes::ParseMesh("<COLLADA>", "a.dae"); }),
              "a.dae: is a scene (COLLADA); install libassimp-dev and build cdb again, or convert "
              "it: `assimp export a.dae a.obj`");
  }
}

}  // namespace
}  // namespace cdb::tests
