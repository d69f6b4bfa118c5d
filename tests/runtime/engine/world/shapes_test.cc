#include "runtime/engine/world/shapes.h"

#include <gtest/gtest.h>

#include "library/distributions/stream.h"
#include "library/scene_error.h"
#include "runtime/engine/world/engine.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using objects::Shape;
using objects::Solid;

constexpr auto& kShapes = objects::kClosedShapes;

btTransform Turned(const Eigen::Quaterniond& q) {
  return btTransform(btQuaternion(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()),
                                  static_cast<btScalar>(q.z()), static_cast<btScalar>(q.w())));
}

TEST(Shapes, ExtentsAreTheSidesWithTheMarginInside) {
  for (const Shape shape : kShapes) {
    for (const Vector3d& sides : {Vector3d(50, 50, 50), Vector3d(50, 20, 80)}) {
      for (const double margin : {0.0, 0.04, 2.0}) {
        const Solid solid{shape, sides};
        world::ShapePool pool;
        btVector3 lower, upper;
        pool.Get(solid, margin)->getAabb(btTransform::getIdentity(), lower, upper);
        EXPECT_LE((ToEigen(upper - lower) - sides).cwiseAbs().maxCoeff(), 400 * kEpsilon)
            << static_cast<int>(shape) << " margin " << margin;
        EXPECT_NEAR(ToEigen(upper + lower).y() / 2, solid.BoxCentre(), 200 * kEpsilon);
      }
    }
  }
}

TEST(Shapes, BoxIsThatOfTheSupportPointsToTheBit) {
  distributions::Stream stream(4);
  for (std::size_t i = 0; i < 3000; ++i) {
    const Vector3d sides = {stream.Uniform(1, 9), stream.Uniform(1, 9), stream.Uniform(1, 9)};
    const auto margin = static_cast<btScalar>(i % 3 == 0 ? 0 : 0.04);
    const world::SolidShape shape({kShapes[i % std::size(kShapes)], sides}, margin);
    // A few stand upright, where support points are not unique.
    btTransform pose = i % 7 == 0 ? btTransform::getIdentity() : Turned(stream.Turn());
    pose.setOrigin(ToBullet(Vector3d(stream.Uniform(-50, 50), stream.Uniform(-5, 5), 0)));
    btVector3 lower, upper;
    shape.getAabb(pose, lower, upper);
    for (int axis = 0; axis < 3; ++axis) {
      const btVector3& direction = pose.getBasis()[axis];
      const auto end = [&](const btVector3& along) {
        return direction.dot(shape.localGetSupportingVertexWithoutMargin(along));
      };
      const btScalar origin = pose.getOrigin()[axis];
      EXPECT_EQ(upper[axis], origin + end(direction) + margin) << i;
      EXPECT_EQ(lower[axis], origin + end(-direction) - margin) << i;
    }
  }
}

TEST(Shapes, BoxHoldsTheTurnedSolid) {
  distributions::Stream stream(1);
  for (std::size_t i = 0; i < 500; ++i) {
    const Solid solid{kShapes[i % std::size(kShapes)],
                      {stream.Uniform(10, 90), stream.Uniform(10, 90), stream.Uniform(10, 90)}};
    const Eigen::Quaterniond turn = stream.Turn();
    const objects::Box exact = objects::Bounds(solid, turn);
    world::ShapePool pool;
    const double margin = 0.5;
    btVector3 lower, upper;
    pool.Get(solid, margin)->getAabb(Turned(turn), lower, upper);
    // The margin rounds edges: a corner of the solid can protrude by (sqrt 3 - 1) margins.
    const double rounded = 0.74 * margin + 1000 * kEpsilon;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(upper[axis], exact.upper[axis] - rounded);
      EXPECT_LE(lower[axis], exact.lower[axis] + rounded);
    }
  }
}

TEST(Shapes, CoreAndMarginStayCloseToTheSolid) {
  // Bullet's support with margin, compared with the exact one: never further out than the margin.
  distributions::Stream stream(2);
  for (std::size_t i = 0; i < 2000; ++i) {
    const Solid solid{kShapes[i % std::size(kShapes)],
                      {stream.Uniform(10, 90), 30, stream.Uniform(10, 90)}};
    world::ShapePool pool;
    const btCollisionShape* shape = pool.Get(solid, 0.5);
    const Vector3d d = Vector3d(stream.Normal(), stream.Normal(), stream.Normal()).normalized();
    const btVector3 direction(static_cast<btScalar>(d.x()), static_cast<btScalar>(d.y()),
                              static_cast<btScalar>(d.z()));
    const double reach = d.dot(ToEigen(world::FarthestPoint(*shape, direction)));
    EXPECT_NEAR(reach, d.dot(solid.Support(d)), 0.5 * 1.74 + 200 * kEpsilon)
        << static_cast<int>(solid.shape);
  }
}

TEST(Shapes, EqualOnesAreShared) {
  world::ShapePool pool;
  const Solid a{Shape::kCone, {1, 2, 3}}, b{Shape::kCone, {1, 2, 3.5}};
  EXPECT_EQ(pool.Get(a, 0.01), pool.Get(a, 0.01));
  EXPECT_NE(pool.Get(a, 0.01), pool.Get(a, 0.02));
  EXPECT_NE(pool.Get(a, 0.01), pool.Get(b, 0.01));
  EXPECT_EQ(pool.size(), 3u);
}

TEST(Shapes, BulletsOwnWhereItHasOne) {
  world::ShapePool pool;
  const auto type = [&](Shape shape, const Vector3d& sides) {
    return pool.Get({shape, sides}, 0.04)->getShapeType();
  };
  EXPECT_EQ(type(Shape::kEllipsoid, {5, 5, 5}), SPHERE_SHAPE_PROXYTYPE);
  EXPECT_EQ(type(Shape::kCuboid, {5, 6, 7}), BOX_SHAPE_PROXYTYPE);
  EXPECT_EQ(type(Shape::kCylinder, {5, 9, 5}), CYLINDER_SHAPE_PROXYTYPE);
  EXPECT_EQ(type(Shape::kEllipsoid, {5, 5, 6}), CUSTOM_CONVEX_SHAPE_TYPE);
  EXPECT_EQ(type(Shape::kCylinder, {5, 9, 6}), CUSTOM_CONVEX_SHAPE_TYPE);
  EXPECT_EQ(type(Shape::kCone, {5, 5, 5}), CUSTOM_CONVEX_SHAPE_TYPE);
  EXPECT_EQ(type(Shape::kCapsule, {5, 9, 5}), CAPSULE_SHAPE_PROXYTYPE);
  EXPECT_EQ(type(Shape::kCapsule, {5, 9, 6}), CUSTOM_CONVEX_SHAPE_TYPE);
  EXPECT_EQ(type(Shape::kTetrahedron, {5, 5, 5}), CUSTOM_CONVEX_SHAPE_TYPE);
}

TEST(Shapes, MarginsThatLeaveNothingAreRefused) {
  world::ShapePool pool;
  const Solid small{Shape::kCuboid, {0.1, 1, 1}};
  plan::Scene scene = EngineScene(1, 10);
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", 0.1);
  SetGroup(scene, "margin", 0.05);
  EXPECT_THROW(layouts::DrawObjects(scene), library::SceneError);
  // With 0.04, Bullet's rule applies: a tenth of the smallest half extent.
  EXPECT_NEAR(pool.Get(small, 0.04)->getMargin(), 0.005, 0.005 * kEpsilon);
  EXPECT_NEAR(pool.Get(small, 0.041)->getMargin(), 0.041, 0.041 * kEpsilon);
}

TEST(Shapes, InertiaIsTheSolids) {
  plan::Scene scene = EngineScene(4, 2000);
  SetGroup(scene, "aspect", schema::Ratio{{1, 2, 3}});
  SetGroup(scene, "mass", 7.0);
  SetGroup(scene, "type", AnyType());
  const world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3d inertia = 7 * engine.initial_state().objects[i].solid.InertiaPerMass();
    const btVector3& inverse = engine.objects()[i]->getInvInertiaDiagLocal();
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(inverse[axis] * inertia[axis], 1, 4 * kEpsilon);
    EXPECT_NEAR(engine.objects()[i]->getInvMass() * 7, 1, 2 * kEpsilon);
  }
}

TEST(Precision, LibraryAgrees) {
  EXPECT_EQ(world::PrecisionMismatch(), "");
  EXPECT_STREQ(world::EnginePrecision(), sizeof(btScalar) == 8 ? "double" : "single");
}

}  // namespace
}  // namespace cdb::tests
