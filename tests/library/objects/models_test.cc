#include "library/objects/models.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

#include "library/meshes/decompose.h"
#include "library/meshes/mass_properties.h"
#include "tests/library/meshes/test_meshes.h"
#include "tests/support/files.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

using namespace testing;
namespace fs = std::filesystem;

class ModelFolder : public ::testing::Test {
 protected:
  const TemporaryFolder folder_;
};

TEST_F(ModelFolder, IsTheVariablesOrBesideTheProgram) {
  const char* kept = std::getenv("CDB_MODELS");
  const std::string before = kept == nullptr ? "" : kept;
  setenv("CDB_MODELS", "/somewhere", 1);
  EXPECT_EQ(objects::ModelFolders(), std::vector<fs::path>{"/somewhere"});
  unsetenv("CDB_MODELS");
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  EXPECT_EQ(objects::ModelFolders(),
            (std::vector<fs::path>{program / "models",
                                   program.parent_path() / "share" / "cdb" / "models"}));
  if (!before.empty()) setenv("CDB_MODELS", before.c_str(), 1);
}

TEST_F(ModelFolder, TheFirstThatHasItCounts) {
  const objects::Model& bunny = *objects::FindModel("bunny");
  const std::vector<fs::path> both = {folder_ / "a", folder_ / "b"};
  EXPECT_EQ(Refusal([&] { objects::PathOf(bunny, both); }),
            "the model `bunny` is not on this machine (looked for bunny.off in " +
                both[0].string() + " and " + both[1].string() +
                "); in cdb's source folder run: library/meshes/fetch-models '" + both[0].string() +
                "' bunny");
  // An installed copy.
  fs::create_directories(folder_ / "share");
  WriteFile(folder_ / "share/fetch-models", "");
  const std::vector<fs::path> installed = {both[0], folder_ / "share/models"};
  EXPECT_TRUE(Refusal([&] { objects::PathOf(bunny, installed); })
                  .ends_with("); run: '" + (folder_ / "share/fetch-models").string() + "' '" +
                             installed[1].string() + "' bunny"));
  fs::create_directories(both[1]);
  WriteFile(both[1] / "bunny.off", ToOff(InsideOut(AngleMesh())));
  EXPECT_EQ(objects::PathOf(bunny, both), both[1] / "bunny.off");
  EXPECT_EQ(objects::LoadModel(bunny, both), AngleMesh());
  fs::create_directories(both[0]);
  WriteFile(both[0] / "bunny.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  EXPECT_TRUE(Refusal([&] {
                objects::LoadModel(bunny, both);
              }).starts_with((both[0] / "bunny.off").string() + ": is not watertight: 3 edges"));
}

TEST_F(ModelFolder, OnlyTheTeapotsHolesAreClosed) {
  meshes::Mesh open = BoxMesh({0, 0, 0}, {1, 1, 1});
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 2);
  WriteFile(folder_ / "teapot.obj", ToObj(open));
  EXPECT_DOUBLE_EQ(meshes::SignedVolume(objects::LoadModel(*objects::FindModel("teapot"),
                                                           std::vector{folder_.path()})),
                   1);
  EXPECT_EQ(objects::FindModel("kettle"), nullptr);
}

TEST_F(ModelFolder, FetchingIsRefusedWhereItIsWrong) {
  const std::string script = SourceFolder() / "library/meshes/fetch-models";
  const auto run = [&](const std::string& arguments) {
    const int status = std::system((script + " " + arguments + " >/dev/null 2>&1").c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  EXPECT_EQ(run(""), 2);
  EXPECT_EQ(run("--help"), 2);
  EXPECT_EQ(run("'" + folder_.path().string() + "' kettle"), 2);
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

/// The models themselves, if they are present.
class EveryModel : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    try {
      objects::PathOf(*objects::FindModel(GetParam()), objects::ModelFolders());
    } catch (const library::SceneError& error) {
      GTEST_SKIP() << error.what();
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Models, EveryModel, ::testing::Values("bunny", "armadillo", "teapot"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(EveryModel, IsASolid) {
  const meshes::Mesh mesh =
      objects::LoadModel(*objects::FindModel(GetParam()), objects::ModelFolders());
  const meshes::MassProperties mass = meshes::MassPropertiesOf(mesh);
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : mesh.vertices) box.extend(vertex);
  EXPECT_TRUE(box.contains(mass.centre));
  // The integrals count twice a volume inside two parts, the rays once: only the teapot's parts
  // overlap.
  const double once = meshes::OverlapVolumeOf(mesh, mesh).first;
  const bool overlaps = std::string_view(GetParam()) == "teapot";
  EXPECT_NEAR(mass.volume / once, 1, overlaps ? 0.01 : 1e-3);
}

}  // namespace
}  // namespace cdb::tests
