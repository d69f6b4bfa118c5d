#include "library/objects/compound.h"

#include <gtest/gtest.h>

#include <memory>
#include <numbers>

#include "compiler/plan/sha256.h"
#include "compiler/schema/parametrised_words.h"
#include "library/distributions/stream.h"
#include "library/meshes/models.h"
#include "library/meshes/primitives.h"
#include "library/objects/solid_factory.h"
#include "tests/library/meshes/test_meshes.h"
#include "tests/support/cache.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

using namespace testing;
using Eigen::Matrix3d;
using Eigen::Vector3d;

std::shared_ptr<const objects::ConvexDecomposition> FormOfHulls(const meshes::Mesh& mesh,
                                                                std::vector<meshes::Hull> hulls) {
  return std::make_shared<const objects::ConvexDecomposition>(objects::MakeDecomposition(
      "test", mesh, meshes::MassPropertiesOf(mesh), {std::move(hulls), 0, 1}));
}

/// AngleMesh as its two boxes.
std::shared_ptr<const objects::ConvexDecomposition> AngleForm() {
  return FormOfHulls(AngleMesh(), {meshes::ConvexHull(BoxMesh({0, 0, 0}, {2, 1, 1}), "a"),
                                   meshes::ConvexHull(BoxMesh({0, 1, 0}, {1, 2, 1}), "b")});
}

objects::Solid SolidOf(const std::shared_ptr<const objects::ConvexDecomposition>& form,
                       const Vector3d& sides) {
  objects::Solid solid{objects::Shape::kCompound, sides};
  solid.compound = std::make_shared<const objects::Compound>(form, sides);
  return solid;
}

TEST(Compound, OfABoxIsTheBox) {
  const meshes::Mesh mesh = BoxMesh({-3, 1, 5}, {7, 2, 6});
  const Vector3d sides(2, 3, 5);
  const objects::Solid solid = SolidOf(FormOfHulls(mesh, {meshes::ConvexHull(mesh, "box")}), sides);
  const objects::Solid box{objects::Shape::kCuboid, sides};
  EXPECT_NEAR(solid.Volume(), box.Volume(), 1e-12);
  EXPECT_LE((solid.InertiaPerMass() - box.InertiaPerMass()).norm(), 1e-12);
  EXPECT_EQ(solid.compound->from_mesh(), Matrix3d::Identity());
  EXPECT_NEAR(solid.InnerRadius(), 1, 1e-12);
  EXPECT_NEAR(solid.OuterRadius(), box.OuterRadius(), 1e-12);
  EXPECT_NEAR(solid.LeastHalfExtent(), 1, 1e-12);
  distributions::Stream stream(1);
  for (int i = 0; i < 100; ++i) {
    const Vector3d d(stream.Normal(), stream.Normal(), stream.Normal());
    EXPECT_LE((solid.Support(d) - box.Support(d)).norm(), 1e-12);
  }
}

TEST(Compound, ItsFrameIsThatOfTheStretchedMesh) {
  // Whatever the sides, the same as stretching the mesh first.
  distributions::Stream stream(2);
  for (int i = 0; i < 50; ++i) {
    const Vector3d sides(stream.Uniform(1, 9), stream.Uniform(1, 9), stream.Uniform(1, 9));
    const objects::Solid solid = SolidOf(AngleForm(), sides);
    const Vector3d factor = sides.cwiseQuotient(Vector3d(2, 2, 1));
    const meshes::Mesh stretched = Moved(AngleMesh(), factor.asDiagonal(), Vector3d::Zero());
    const meshes::MassProperties properties = meshes::MassPropertiesOf(stretched);
    EXPECT_NEAR(solid.Volume(), properties.volume, 1e-12 * properties.volume);
    const Matrix3d& turn = solid.compound->from_mesh();
    EXPECT_NEAR(turn.determinant(), 1, 1e-12);
    // In the body's frame the tensor is diagonal, and is the one that is given.
    const Matrix3d inertia = turn * properties.inertia * turn.transpose();
    EXPECT_LE((inertia - Matrix3d(solid.InertiaPerMass().asDiagonal())).norm(),
              1e-12 * inertia.norm());
    for (int k = 0; k < 20; ++k) {
      const Vector3d d(stream.Normal(), stream.Normal(), stream.Normal());
      double reach = -1e9, from_origin = 0;
      for (const Vector3d& vertex : stretched.vertices) {
        const Vector3d in_body = turn * (vertex - properties.centre);
        reach = std::max(reach, d.dot(in_body));
        from_origin = std::max(from_origin, in_body.norm());
      }
      EXPECT_NEAR(d.dot(solid.Support(d)), reach, 1e-12 * sides.norm());
      EXPECT_NEAR(solid.OuterRadius(), from_origin, 1e-12 * sides.norm());
    }
  }
}

TEST(Compound, PiecesTogetherHaveTheSides) {
  const objects::Solid solid = SolidOf(AngleForm(), {4, 5, 6});
  const Matrix3d& turn = solid.compound->from_mesh();
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d d = turn.col(axis);
    EXPECT_NEAR(d.dot(solid.Support(d) - solid.Support(-d)), solid.sides[axis], 1e-12);
  }
  EXPECT_EQ(solid.PieceCount(), 2u);
  // The far corner of the second box is no point of the first.
  const Vector3d up = turn.col(1);
  EXPECT_NEAR(up.dot(solid.PieceSupport(1, up) - solid.PieceSupport(0, up)), 2.5, 1e-12);
}

TEST(Compound, FarthestPointIsThatOfThePiecesOneByOne) {
  const meshes::Mesh mesh = meshes::TorusMesh(3, 1, 16, meshes::kTorusCorners);
  const auto form = FormOfHulls(mesh, meshes::TorusHulls(3, 1, 16).hulls);
  distributions::Stream stream(3);
  for (const Vector3d& sides : {Vector3d(8, 2, 8), Vector3d(1e-3, 5, 900)}) {
    const objects::Solid solid = SolidOf(form, sides);
    for (int i = 0; i < 1000; ++i) {
      // Along the axes too, where several are as far.
      Vector3d d(stream.Normal(), stream.Normal(), stream.Normal());
      if (i < 6) d = (i % 2 == 0 ? 1 : -1) * Vector3d::Unit(i / 2);
      Vector3d farthest = solid.PieceSupport(0, d);
      for (std::size_t piece = 1; piece < solid.PieceCount(); ++piece) {
        const Vector3d point = solid.PieceSupport(piece, d);
        if (d.dot(point) > d.dot(farthest)) farthest = point;
      }
      EXPECT_EQ(solid.Support(d), farthest) << "to the last bit";
    }
  }
}

TEST(Compound, InnerBallIsInAPieceOrNone) {
  // The centre of mass is in the first box, 1/6 below its top and as far from the second's side.
  const objects::Solid angle = SolidOf(AngleForm(), {2, 2, 1});
  EXPECT_NEAR(angle.InnerRadius(), 1.0 / 6, 1e-12);
  objects::SolidFactory maker;
  EXPECT_EQ(maker.Make(Word("torus"), Vector3d::Constant(8), Vector3d::Ones()).InnerRadius(), 0);
}

TEST(SolidFactory, TorusHasItsClosedForms) {
  objects::SolidFactory maker;
  const objects::Solid torus = maker.Make(Word("torus"), Vector3d::Constant(8), Vector3d::Ones());
  EXPECT_EQ(torus.sides, Vector3d(8, 2, 8));
  const double major = 3, minor = 1, pi = std::numbers::pi;
  EXPECT_NEAR(torus.Volume(), 2 * pi * pi * major * minor * minor, 1e-12);
  const double across = major * major / 2 + 5 * minor * minor / 8;
  const double along = major * major + 3 * minor * minor / 4;
  EXPECT_LE((torus.InertiaPerMass() - Vector3d(across, along, across)).norm(), 1e-12);
  // And those of a fine mesh, stretched.
  const objects::Solid stretched = maker.Make(Word("torus"), Vector3d::Ones(), {5, 3, 7});
  EXPECT_EQ(stretched.sides, Vector3d(5, 3, 7));
  const Vector3d factor = Vector3d(5, 3, 7).cwiseQuotient(Vector3d(8, 2, 8));
  const meshes::MassProperties fine = meshes::MassPropertiesOf(
      Moved(meshes::TorusMesh(3, 1, 512, 512), factor.asDiagonal(), Vector3d::Zero()));
  EXPECT_NEAR(stretched.Volume(), fine.volume, 1e-4 * fine.volume);
  EXPECT_LE((stretched.InertiaPerMass() - fine.inertia.diagonal()).norm(),
            1e-4 * fine.inertia.norm());
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

TEST(SolidFactory, AFormIsTheSameMadeOrFound) {
  const TemporaryCache cache;
  const std::string file = (cache.folder() / "angle.off").string();
  WriteFile(file, ToOff(AngleMesh()));
  const auto call = [&](const char* name) {
    return schema::Call{name, {schema::Text{file}, Word("any")}};
  };
  std::ptrdiff_t made = 0;
  for (const schema::Value& type : {Word("torus"), schema::Value(call("mesh")), {call("hull")}}) {
    const auto form = [&] {
      objects::SolidFactory maker;
      maker.Make(type, Vector3d::Ones(), Vector3d::Ones());
      return *maker.Forms().at(0);
    };
    EXPECT_EQ(form(), form());
    const std::filesystem::directory_iterator files(cache.folder());
    EXPECT_EQ(std::distance(begin(files), end(files)), 1 + ++made) << "and the mesh";
  }
}

/// A mesh in a folder that keeps its decomposition too.
class MeshFile : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    cache_ = std::make_unique<TemporaryCache>();
    WriteFile(file(), ToOff(AngleMesh()));
  }
  static void TearDownTestSuite() { cache_.reset(); }
  static std::string file() { return (cache_->folder() / "angle.off").string(); }
  static schema::Value Call(const char* name, schema::Value sha256 = Word("any")) {
    return schema::Call{name, {schema::Text{file()}, std::move(sha256)}};
  }

  static inline std::unique_ptr<TemporaryCache> cache_;
};

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
  EXPECT_NEAR(solid.Volume(), 3.5, 1e-12);  // the quarter's half as well
  EXPECT_NE(objects::ModelsText(maker.Forms()).find("1 hull, volume error 0 %, IoU 1.000"),
            std::string::npos);
}

TEST_F(MeshFile, AnotherFileThanPlannedIsRefused) {
  objects::SolidFactory maker;
  const auto make = [&](const std::string& sha256) {
    return maker.Make(Call("mesh", schema::Text{sha256}), Vector3d::Ones(), Vector3d::Ones());
  };
  EXPECT_EQ(make(plan::Sha256Hex(ToOff(AngleMesh()))).sides, Vector3d(1, 1, 0.5));
  EXPECT_EQ(Refusal([&] { make("0123"); }),
            file() + ": it is not the file that was planned with; plan again");
}

TEST(SolidFactory, ModelsAreTheirMeshes) {
  for (const meshes::Model& model : meshes::Models()) {
    meshes::Mesh mesh;
    try {
      mesh = meshes::LoadModel(model, meshes::ModelFolders());
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
