#include "library/objects/compound.h"

#include <gtest/gtest.h>

#include <memory>

#include "library/distributions/stream.h"
#include "library/meshes/primitives.h"
#include "library/objects/solid_factory.h"
#include "tests/library/meshes/test_meshes.h"
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

/// AngleMesh decomposed into its two boxes.
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
  // For any sides, the result is the same as stretching the mesh first.
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
    // In the body's frame, the inertia tensor is diagonal and equal to the given one.
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
  // The far corner of the second box is not a point of the first.
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
      // Also along the axes, where several corners are equally far.
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
  // The centre of mass is in the first box, 1/6 below its top, and equally far from the second's
  // side.
  const objects::Solid angle = SolidOf(AngleForm(), {2, 2, 1});
  EXPECT_NEAR(angle.InnerRadius(), 1.0 / 6, 1e-12);
  objects::SolidFactory maker;
  EXPECT_EQ(maker.Make(Word("torus"), Vector3d::Constant(8), Vector3d::Ones()).InnerRadius(), 0);
}

}  // namespace
}  // namespace cdb::tests
