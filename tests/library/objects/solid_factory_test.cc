#include "library/objects/solid_factory.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <numbers>
#include <vector>

#include "compiler/plan/input_file.h"
#include "compiler/plan/kept_files.h"
#include "library/meshes/primitives.h"
#include "library/objects/models.h"
#include "tests/library/meshes/test_meshes.h"
#include "tests/support/cache.h"
#include "tests/support/files.h"
#include "tests/support/sanitizers.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

using namespace testing;
using Eigen::Vector3d;

TEST(SolidFactory, TorusHasItsClosedForms) {
  objects::SolidFactory maker;
  const objects::Solid torus = maker.Make(Word("torus"), Vector3d::Constant(8), Vector3d::Ones());
  EXPECT_EQ(torus.sides, Vector3d(8, 2, 8));
  const double major = 3, minor = 1, pi = std::numbers::pi;
  EXPECT_NEAR(torus.Volume(), 2 * pi * pi * major * minor * minor, 1e-12);
  const double across = major * major / 2 + 5 * minor * minor / 8;
  const double along = major * major + 3 * minor * minor / 4;
  EXPECT_LE((torus.InertiaPerMass() - Vector3d(across, along, across)).norm(), 1e-12);
  // Stretched, it has the properties of a fine mesh.
  const objects::Solid stretched = maker.Make(Word("torus"), Vector3d::Ones(), {5, 3, 7});
  EXPECT_EQ(stretched.sides, Vector3d(5, 3, 7));
  const Vector3d factor = Vector3d(5, 3, 7).cwiseQuotient(Vector3d(8, 2, 8));
  const meshes::MassProperties fine = meshes::MassPropertiesOf(
      Moved(meshes::TorusMesh(3, 1, 512, 512), factor.asDiagonal(), Vector3d::Zero()));
  EXPECT_NEAR(stretched.Volume(), fine.volume, 1e-4 * fine.volume);
  EXPECT_LE((stretched.InertiaPerMass() - fine.inertia.diagonal()).norm(),
            1e-4 * fine.inertia.norm());
}

TEST(SolidFactory, EveryTypeOfTheTableIsAClosedFormAModelOrTheTorus) {
  for (const schema::ObjectType& type : schema::kObjectTypeTable) {
    const bool is_closed =
        std::ranges::count(objects::kClosedShapes, type.name, objects::TypeOf) == 1;
    const bool is_mesh = objects::FindModel(type.name) != nullptr || type.name == "torus";
    EXPECT_NE(is_closed, is_mesh) << type.name;
  }
}

TEST(SolidFactory, EqualOnesAreSharedAndFormsAlways) {
  objects::SolidFactory maker;
  const Vector3d ones = Vector3d::Ones();
  const objects::Solid a = maker.Make(Word("torus"), Vector3d::Constant(8), ones);
  const objects::Solid b = maker.Make(Word("torus"), Vector3d::Constant(8), ones);
  const objects::Solid c = maker.Make(Word("torus"), Vector3d::Constant(9), ones);
  EXPECT_EQ(a, b);
  EXPECT_EQ(a.compound, b.compound);
  EXPECT_NE(a.compound, c.compound);
  EXPECT_EQ(&a.compound->form(), &c.compound->form());
  EXPECT_EQ(maker.Forms().size(), 1u);
  EXPECT_EQ(maker.Make(Word("cone"), {1, 2, 3}, {3, 2, 1}),
            (objects::Solid{objects::Shape::kCone, {3, 4, 3}}));
  EXPECT_EQ(maker.Forms().size(), 1u) << "closed forms have none";
}

/// A mesh in a folder that also holds its cached decomposition.
class MeshFile : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    cache_ = std::make_unique<TemporaryCache>();
    WriteFile(file(), ToOff(AngleMesh()));
  }
  static void TearDownTestSuite() { cache_.reset(); }
  static std::string file() { return (cache_->folder() / "angle.off").string(); }
  static schema::Value Call(const char* name, schema::Value sha256 = Word("any")) {
    return Layout(name, {{"file", schema::Text{file()}}, {"sha256", std::move(sha256)}});
  }

  static inline std::unique_ptr<TemporaryCache> cache_;
};

// The first test of the suite, so that it computes the decompositions.
TEST_F(MeshFile, AFormIsTheSameMadeOrFound) {
  std::size_t made = 0;
  std::vector<schema::Value> types = {Call("mesh"), Call("hull")};
  if (!kAnySanitizer) types.push_back(Word("torus"));  // takes most of the time
  for (const schema::Value& type : types) {
    const auto form = [&] {
      objects::SolidFactory maker;
      maker.Make(type, Vector3d::Ones(), Vector3d::Ones());
      return *maker.Forms().at(0);
    };
    EXPECT_EQ(form(), form());
    EXPECT_EQ(cache_->Entries().size(), 1 + ++made) << "and the mesh";
  }
}

TEST_F(MeshFile, MeshIsACompoundOfItsPieces) {
  objects::SolidFactory maker;
  const objects::Solid solid = maker.Make(Call("mesh"), Vector3d::Constant(4), Vector3d::Ones());
  EXPECT_EQ(solid.sides, Vector3d(4, 4, 2)) << "its own proportions";
  EXPECT_NEAR(solid.Volume(), 24, 1e-9);
  EXPECT_GE(solid.PieceCount(), 2u);
  EXPECT_EQ(maker.Make(Call("mesh"), Vector3d::Constant(4), {1, 1, 2}).sides, Vector3d(4, 4, 8));
  EXPECT_TRUE(objects::ModelsText(maker.Forms()).starts_with("mesh(\"" + file() + "\"): "));
}

TEST_F(MeshFile, HullIsOnePiece) {
  objects::SolidFactory maker;
  const objects::Solid solid = maker.Make(Call("hull"), Vector3d::Constant(2), Vector3d::Ones());
  EXPECT_EQ(solid.PieceCount(), 1u);
  EXPECT_NEAR(solid.Volume(), 3.5, 1e-12);  // includes half of the quarter
  EXPECT_NE(objects::ModelsText(maker.Forms()).find("1 hull, volume error 0 %, IoU 1.000"),
            std::string::npos);
}

TEST_F(MeshFile, SaysIfItsPartsOverlap) {
  const std::string shells = (cache_->folder() / "shells.off").string();
  WriteFile(shells, ToOff(Joined(BoxMesh({0, 0, 0}, {2, 1, 1}), BoxMesh({1, 0, 0}, {3, 1, 1}))));
  objects::SolidFactory maker;
  maker.Make(Layout("mesh", {{"file", schema::Text{shells}}}), Vector3d::Ones(), Vector3d::Ones());
  EXPECT_NE(objects::ModelsText(maker.Forms())
                .find("parts overlap: mass and inertia count 33.3 % of the volume twice"),
            std::string::npos);
}

TEST_F(MeshFile, HullsThatDoNotFitAreRefusedUnlessAccepted) {
  objects::SolidFactory maker;
  const auto make = [&](const char* iou) {
    return maker.Make(Layout("mesh", {{"file", schema::Text{file()}},
                                      {"hulls", schema::Number::Whole(1)},
                                      {"iou", *schema::Number::FromLiteral(iou)}}),
                      Vector3d::Ones(), Vector3d::Ones());
  };
  // Its hull has an IoU of 3 / 3.5.
  EXPECT_EQ(make("0.85").PieceCount(), 1u);
  const std::string refusal = Refusal([&] { make("0.9"); });
  EXPECT_NE(
      refusal.find("1 convex hull with an IoU of 0.86 does not fit the mesh; 0.9 is the least"),
      std::string::npos)
      << refusal;
  EXPECT_NE(refusal.find("iou: 0.85"), std::string::npos) << refusal;
}

TEST_F(MeshFile, FactsNeedNoDecomposition) {
  const std::string other = (cache_->folder() / "other.off").string();
  WriteFile(other, ToOff(Moved(AngleMesh(), Eigen::Matrix3d::Identity(), {3, 0, 0})));
  const schema::Value type = Layout(
      "mesh", {{"file", schema::Text{other}}, {"unit", Word("cm")}, {"origin", Word("file")}});
  analysis::ModelFault why;
  const auto read = objects::ReadModel(type, {.decomposes = false}, why);
  ASSERT_TRUE(read);
  EXPECT_LE((read->sides - Vector3d(0.02, 0.02, 0.01)).norm(), 1e-15);
  EXPECT_LE((read->placed - Vector3d(-2, -0.5, -0.5)).norm(), 1e-12);
  EXPECT_FALSE(read->iou);
  std::size_t calls = 0;
  const auto made = objects::ReadModel(
      type, {.progress = [&](const std::string&, std::size_t) { ++calls; }}, why);
  ASSERT_TRUE(made);
  EXPECT_GT(made->iou.value(), 0.99);
  EXPECT_EQ(made->sides, read->sides);
  EXPECT_EQ(made->placed, read->placed);
  EXPECT_GT(calls, 0u);
  // From the cache.
  EXPECT_EQ(objects::ReadModel(type, {.decomposes = false}, why)->iou, made->iou);
  WriteFile(other, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  EXPECT_FALSE(objects::ReadModel(type, {.decomposes = false}, why));
  EXPECT_NE(why.cause.find("is not watertight"), std::string::npos) << why.cause;
}

// As the language server and the editor do, which compile a text again at each change.
TEST_F(MeshFile, IsReadOnceWhileItIsUnchanged) {
  const auto path = [&](const std::string& name) { return (cache_->folder() / name).string(); };
  const auto write = [&](const std::string& name, double x) {
    WriteFile(path(name), ToOff(Moved(AngleMesh(), Eigen::Matrix3d::Identity(), {x, 0, 0})));
    return std::filesystem::file_size(path(name));
  };
  /// Readings by `times` compilations, each of which asks for the facts and makes the solid.
  const auto readings = [&](const std::string& name, int times) {
    const schema::Value type = Layout("mesh", {{"file", schema::Text{path(name)}}});
    const std::size_t before = objects::ModelReadings();
    for (int i = 0; i < times; ++i) {
      analysis::ModelFault why;
      EXPECT_TRUE(objects::ReadModel(type, {}, why)) << why.cause;
      objects::SolidFactory().Make(type, Vector3d::Ones(), Vector3d::Ones());
    }
    return objects::ModelReadings() - before;
  };
  const std::uint64_t bytes = write("kept.off", 1);
  EXPECT_EQ(readings("kept.off", 3), 6u);  // nothing is kept
  plan::KeepFiles(2 * bytes + 50);
  EXPECT_EQ(readings("kept.off", 3), 1u);
  write("kept.off", 20);  // of another size, whatever the clock of the file system
  EXPECT_EQ(readings("kept.off", 3), 1u);
  // Beyond the bound, the one that was not used for longest is forgotten.
  write("second.off", 1);
  EXPECT_EQ(readings("second.off", 2), 1u);
  EXPECT_EQ(readings("kept.off", 1), 0u);
  write("third.off", 1);
  EXPECT_EQ(readings("third.off", 1), 1u);
  EXPECT_EQ(readings("kept.off", 1), 0u);
  EXPECT_EQ(readings("second.off", 1), 1u);
  plan::KeepFiles(bytes - 1);
  EXPECT_EQ(readings("third.off", 2), 4u);
  plan::KeepFiles(0);
}

TEST_F(MeshFile, AMissingFileIsNoFaultOfTheType) {
  const char* models = std::getenv("CDB_MODELS");
  const std::string before = models != nullptr ? models : "";
  setenv("CDB_MODELS", cache_->folder().c_str(), 1);
  analysis::ModelFault bunny, file;
  EXPECT_FALSE(objects::ReadModel(Word("bunny"), {}, bunny));
  EXPECT_FALSE(objects::ReadModel(
      Layout("hull", {{"file", schema::Text{(cache_->folder() / "none.obj").string()}}}), {},
      file));
  models != nullptr ? setenv("CDB_MODELS", before.c_str(), 1) : unsetenv("CDB_MODELS");
  EXPECT_TRUE(bunny.is_missing);
  EXPECT_NE(bunny.cause.find("the model `bunny` is not on this machine"), std::string::npos);
  EXPECT_TRUE(file.is_missing);
  EXPECT_NE(file.cause.find("none.obj"), std::string::npos) << file.cause;
}

TEST_F(MeshFile, AnotherFileThanPlannedIsRefused) {
  objects::SolidFactory maker;
  const auto make = [&](const std::string& sha256) {
    return maker.Make(Call("mesh", schema::Text{sha256}), Vector3d::Ones(), Vector3d::Ones());
  };
  EXPECT_EQ(make(plan::Sha256Hex(ToOff(AngleMesh()))).sides, Vector3d(1, 1, 0.5));
  EXPECT_EQ(Refusal([&] { make("0123"); }),
            file() + ": it differs from the file that the plan was made with; plan again");
}

/// `word("file")` with these further arguments.
schema::Value FromFile(const char* word, const std::string& file, const char* unit,
                       const char* origin) {
  return Layout(word,
                {{"file", schema::Text{file}}, {"unit", Word(unit)}, {"origin", Word(origin)}});
}

TEST(SolidFactory, NativeSizeIsThatOfTheFile) {
  const TemporaryFolder folder;
  const std::string file = (folder / "box.off").string();
  WriteFile(file, ToOff(BoxMesh({10, 0, 0}, {14, 2, 1})));
  objects::SolidFactory maker;
  const auto native = [&](const schema::Value& type, const Vector3d& aspect = Vector3d::Ones()) {
    return maker.Make(type, Vector3d::Zero(), aspect);
  };
  EXPECT_EQ(native(FromFile("hull", file, "m", "mass")).sides, Vector3d(4, 2, 1));
  for (const char* word : {"mesh", "hull"}) {
    const objects::Solid solid = native(FromFile(word, file, "mm", "mass"));
    EXPECT_LE((solid.sides - Vector3d(4e-3, 2e-3, 1e-3)).norm(), 1e-18);
    EXPECT_NEAR(solid.Volume(), 8e-9, 1e-21);
  }
  EXPECT_LE(
      (native(FromFile("surface", file, "in", "box")).sides - 0.0254 * Vector3d(4, 2, 1)).norm(),
      1e-15);
  EXPECT_EQ(Refusal([&] { native(Word("cuboid")); }),
            "a cuboid has no file that gives it a size, but the size is native; write a size in m");
  EXPECT_EQ(Refusal([&] {
              native(FromFile("hull", file, "m", "mass"), {1, 2, 1});
            }),
            "the size is native, but the aspect is not 1 : 1 : 1; remove the aspect");
}

TEST(SolidFactory, HeightFieldsHaveTheSizeOfTheirFileOrTheArguments) {
  const TemporaryFolder folder;
  const std::filesystem::path map = folder / "map.asc";
  WriteFile(map, "ncols 3\nnrows 2\ncellsize 30\n0 5 10\n20 -9999 0\n");
  const auto sides = [&](std::map<std::string_view, schema::Value> given, double size,
                         const Vector3d& aspect) {
    given["file"] = schema::Text{map.string()};
    objects::SolidFactory maker;
    return maker.Make(Layout("heights", given), Vector3d::Constant(size), aspect).sides;
  };
  const schema::Value none = Word("lowest");
  const Vector3d ones = Vector3d::Ones();
  EXPECT_EQ(sides({{"no_data", none}}, 0, ones), Vector3d(60, 20, 30));
  EXPECT_EQ(sides({{"no_data", -10.0}}, 0, ones), Vector3d(60, 30, 30));
  EXPECT_EQ(sides({{"no_data", none}, {"cell", 10.0}}, 0, ones), Vector3d(20, 20, 10));
  EXPECT_EQ(sides({{"no_data", none}, {"scale", Vector3d(5, 2, 7)}}, 0, ones), Vector3d(10, 40, 7));
  EXPECT_EQ(sides({{"no_data", none}}, 6, ones), Vector3d(6, 2, 3));
  EXPECT_EQ(sides({{"no_data", none}}, 6, {1, 0.5, 2}), Vector3d(6, 3, 12));
  EXPECT_EQ(Refusal([&] {
              sides({{"cell", 1.0}, {"scale", ones}}, 0, ones);
            }),
            "heights has a cell as well as a scale; remove the cell; `scale` has the sides of a "
            "cell, too");
  EXPECT_EQ(Refusal([&] {
              sides({{"scale", Vector3d(1, 0, 1)}}, 0, ones);
            }),
            "the scale of heights must be more than 0 along each axis; for example `scale: (30, 1, "
            "30)`");
  // In degrees, unless the sides are given.
  WriteFile(map, "ncols 3\nnrows 2\ncellsize 0.01\n0 5 10\n20 3 0\n");
  EXPECT_TRUE(Refusal([&] { sides({}, 6, ones); }).find("degrees, not metres") !=
              std::string::npos);
  EXPECT_EQ(sides({}, 6, {1, 0.5, 2}), Vector3d(6, 3, 12));
}

TEST(SolidFactory, PosesReferToTheOriginAndTheAxesOfTheFile) {
  const TemporaryFolder folder;
  const std::string file = (folder / "angle.off").string();
  const meshes::Mesh mesh = Moved(AngleMesh(), Eigen::Matrix3d::Identity(), {7, 0, 0});
  WriteFile(file, ToOff(mesh));
  const Vector3d centre = meshes::MassPropertiesOf(mesh).centre;
  objects::SolidFactory maker;
  const objects::Pose at{{1, 2, 3}, Eigen::Quaterniond(0.1, 0.7, -0.5, 0.5).normalized()};
  const std::pair<const char*, Vector3d> origins[] = {
      {"mass", centre}, {"file", Vector3d::Zero()}, {"box", {8, 1, 0.5}}};
  for (const auto& [origin, point] : origins) {
    const objects::Solid solid =
        maker.Make(FromFile("mesh", file, "m", origin), Vector3d::Zero(), Vector3d::Ones());
    const objects::Pose body = objects::BodyOf(solid, at);
    EXPECT_LE((body.position - (at.position + at.orientation * (centre - point))).norm(), 1e-12);
    // The axes of the body are the principal ones: the supports of both are the same.
    const Vector3d along(0.2, 0.4, -0.1);
    const Vector3d farthest =
        body.position +
        body.orientation * solid.compound->Support(body.orientation.conjugate() * along);
    double most = -1e9;
    for (const Vector3d& vertex : mesh.vertices)
      most = std::max(most, along.dot(at.position + at.orientation * (vertex - point)));
    EXPECT_NEAR(along.dot(farthest), most, 1e-9);
    const objects::Pose back = objects::OriginOf(solid, body);
    EXPECT_LE((back.position - at.position).norm(), 1e-12);
    EXPECT_LE(back.orientation.angularDistance(at.orientation), 1e-7);
  }
}

TEST(SolidFactory, ModelsAreTheirMeshes) {
  for (const objects::Model& model : objects::Models()) {
    meshes::Mesh mesh;
    try {
      mesh = objects::LoadModel(model, objects::ModelFolders());
    } catch (const library::SceneError&) {
      GTEST_SKIP() << "no models here: library/meshes/fetch-models gets them";
    }
    objects::SolidFactory maker;
    const objects::Solid solid =
        maker.Make(Word(model.name), Vector3d::Constant(50), Vector3d::Ones());
    const meshes::MassProperties properties = meshes::MassPropertiesOf(mesh);
    Eigen::AlignedBox3d box;
    for (const Vector3d& vertex : mesh.vertices) box.extend(vertex);
    const double scale = 50 / box.sizes().maxCoeff();
    EXPECT_NEAR(solid.Volume(), properties.volume * std::pow(scale, 3), 1e-9 * solid.Volume());
    const meshes::PrincipalAxes axes = meshes::PrincipalAxesOf(properties.inertia * scale * scale);
    EXPECT_LE((solid.InertiaPerMass() - axes.moments).norm(), 1e-9 * axes.moments.norm());
    EXPECT_GT(solid.InnerRadius(), 0);
    const objects::ConvexDecomposition& form = *maker.Forms()[0];
    EXPECT_LE(form.volume_error, 0.1);
    EXPECT_GE(form.iou, 0.88);
    EXPECT_GE(form.pieces.size(), 5u);
    EXPECT_LE(form.pieces.size(), 60u);
  }
}

}  // namespace
}  // namespace cdb::tests
