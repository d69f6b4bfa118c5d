#include "runtime/engine/detection/detector_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "library/layouts/initial_state.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using objects::Solid;

Vector3d VectorOf(const Vec3& v) { return {v.x, v.y, v.z}; }

TEST(DetectorShapes, NameEachSolid) {
  detection::DetectorShapes shapes;
  const Vector3d sides(1, 4, 2);
  const auto kind = [&](objects::Shape shape, const Vector3d& of) {
    return shapes.Of(Solid{shape, of, nullptr}).kind;
  };
  EXPECT_EQ(kind(objects::Shape::kEllipsoid, sides), ShapeKind::kEllipsoid);
  EXPECT_EQ(kind(objects::Shape::kCuboid, sides), ShapeKind::kBox);
  EXPECT_EQ(kind(objects::Shape::kCylinder, sides), ShapeKind::kCylinder);
  EXPECT_EQ(kind(objects::Shape::kCapsule, sides), ShapeKind::kCapsule);
  EXPECT_EQ(kind(objects::Shape::kCapsule, {3, 2, 3}), ShapeKind::kEllipsoid);
  const cdb::Shape super =
      shapes.Of(Solid{objects::Shape::kSuperellipsoid, sides, nullptr, {0.5, 1.5}});
  EXPECT_EQ(super.kind, ShapeKind::kSuperellipsoid);
  EXPECT_EQ(super.e1, 0.5);
  EXPECT_EQ(super.e2, 1.5);
  EXPECT_EQ(kind(objects::Shape::kTetrahedron, sides), ShapeKind::kHull);
  const cdb::Shape cone = shapes.Of(Solid{objects::Shape::kCone, sides, nullptr});
  EXPECT_EQ(cone.kind, ShapeKind::kCone);
  EXPECT_EQ(VectorOf(cone.half), sides / 2);
  EXPECT_EQ(cone.centre.y, 1);
}

/// Checks that hulls extend exactly as far as the solid, and that their faces point outwards.
void ExpectHulls(const cdb::Shape& shape, const Solid& solid) {
  ASSERT_EQ(shape.hulls.size(), solid.PieceCount());
  for (std::size_t i = 0; i < shape.hulls.size(); ++i) {
    const Hull& hull = shape.hulls[i];
    Vector3d middle = Vector3d::Zero();
    for (const Vec3& vertex : hull.vertices)
      middle += VectorOf(vertex) / static_cast<double>(hull.vertices.size());
    for (const Vector3d& direction :
         {Vector3d(1, 0.2, 0.3), Vector3d(-0.4, 1, 0), Vector3d(0, -1, -2)}) {
      double farthest = -1e300;
      for (const Vec3& vertex : hull.vertices)
        farthest = std::max(farthest, direction.dot(VectorOf(vertex)));
      EXPECT_NEAR(farthest, direction.dot(solid.PieceSupport(i, direction)), 1e-12);
    }
    EXPECT_GE(hull.faces.size(), 4u);
    for (const Face& face : hull.faces) {
      const Vector3d a = VectorOf(hull.vertices[face.a]), b = VectorOf(hull.vertices[face.b]),
                     c = VectorOf(hull.vertices[face.c]);
      EXPECT_GT((b - a).cross(c - a).dot(a - middle), 0);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double upper = solid.Support(Vector3d::Unit(axis))[axis];
    EXPECT_NEAR(VectorOf(shape.centre)[axis] + VectorOf(shape.half)[axis], upper, 1e-12);
  }
}

TEST(DetectorShapes, HullsAreTheSolidsOwn) {
  detection::DetectorShapes shapes;
  for (const objects::Shape form : objects::kClosedShapes) {
    const Solid solid{form, {1, 2, 3}, nullptr};
    if (const cdb::Shape shape = shapes.Of(solid); shape.kind == ShapeKind::kHull)
      ExpectHulls(shape, solid);
  }

  plan::Scene scene = DefaultScene(1, 100);
  SetGroup(scene, "type", Word("torus"));
  const layouts::InitialState state = layouts::DrawObjects(scene);
  const Solid& torus = state.objects[0].solid;
  const cdb::Shape shape = shapes.Of(torus);
  EXPECT_EQ(shape.kind, ShapeKind::kCompound);
  ExpectHulls(shape, torus);
  EXPECT_EQ(shapes.Of(torus).hulls.data(), shape.hulls.data()) << "made once";
}

}  // namespace
}  // namespace cdb::tests
