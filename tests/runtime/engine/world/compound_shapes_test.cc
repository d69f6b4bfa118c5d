// Compounds in Bullet compared with the library's solids and with closed forms.
#include <gtest/gtest.h>

#include <stdlib.h>

#include <filesystem>
#include <fstream>

#include "library/distributions/stream.h"
#include "library/objects/solid_factory.h"
#include "library/scene_error.h"
#include "tests/library/meshes/test_meshes.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using objects::Shape;
using objects::Solid;

/// An L-shape of two boxes, which is inclined in its principal axes.
Solid Angle(const Vector3d& sides) {
  using meshes::ConvexHull;

  const meshes::Mesh mesh = AngleMesh();
  const auto form = std::make_shared<const objects::ConvexDecomposition>(
      objects::MakeDecomposition("angle", mesh, meshes::MassPropertiesOf(mesh),
                                 {{ConvexHull(BoxMesh({0, 0, 0}, {2, 1, 1}), "a"),
                                   ConvexHull(BoxMesh({0, 1, 0}, {1, 2, 1}), "b")},
                                  0,
                                  1}));
  Solid solid{Shape::kCompound, sides};
  solid.compound = std::make_shared<const objects::Compound>(form, sides);
  return solid;
}

Eigen::Quaterniond Upright(const Solid& solid) {
  return Eigen::Quaterniond(Eigen::Matrix3d(solid.compound->from_mesh().transpose()));
}

TEST(Compounds, BulletsShapeIsTheSolidWhateverItsSides) {
  // Oblique faces and unequal sides, with the support function that planes use.
  distributions::Stream stream(3);
  world::ShapePool pool;
  objects::SolidFactory maker;
  const Solid solid = maker.Make(Word("torus"), {30, 7, 50}, {1, 2, 3});
  const btCollisionShape& shape = *pool.Get(solid, 0);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d d = Vector3d(stream.Normal(), stream.Normal(), stream.Normal()).normalized();
    const double reach = d.dot(ToEigen(world::FarthestPoint(shape, ToBullet(d))));
    EXPECT_NEAR(reach, d.dot(solid.Support(d)), 1000 * kEpsilon);
  }
}

TEST(Compounds, MarginIsInsideOfTheFaces) {
  distributions::Stream stream(1);
  world::ShapePool pool;
  for (const double margin : {0.0, 0.04, 0.3}) {
    const Solid solid = Angle({4, 5, 3});
    const btCollisionShape& shape = *pool.Get(solid, margin);
    EXPECT_EQ(shape.getShapeType(), COMPOUND_SHAPE_PROXYTYPE);
    for (int i = 0; i < 1000; ++i) {
      const Vector3d d = Vector3d(stream.Normal(), stream.Normal(), stream.Normal()).normalized();
      const double reach = d.dot(ToEigen(world::FarthestPoint(shape, ToBullet(d))));
      // Corners are rounded by the margin.
      EXPECT_LE(reach, d.dot(solid.Support(d)) + 50 * kEpsilon);
      EXPECT_GE(reach, d.dot(solid.Support(d)) - 0.74 * margin - 50 * kEpsilon);
    }
    // Faces keep their positions, including the margin.
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d d = solid.compound->from_mesh().col(axis);
      const auto reach = [&](const Vector3d& along) {
        return along.dot(ToEigen(world::FarthestPoint(shape, ToBullet(along))));
      };
      EXPECT_NEAR(reach(d) + reach(-d), solid.sides[axis], 50 * kEpsilon);
    }
  }
}

TEST(Compounds, EqualOnesAreSharedAndOfOneFormShareVertices) {
  world::ShapePool pool;
  const Solid small = Angle({1, 1, 1});
  Solid large = small;
  large.sides = Vector3d(2, 3, 4);
  large.compound =
      std::make_shared<const objects::Compound>(small.compound->shared_form(), large.sides);
  EXPECT_EQ(pool.Get(small, 0.04), pool.Get(small, 0.04));
  const auto points = [&](const Solid& solid) {
    const auto& shape = static_cast<const btCompoundShape&>(*pool.Get(solid, 0.04));
    return static_cast<const btConvexPointCloudShape*>(shape.getChildShape(0))->getUnscaledPoints();
  };
  EXPECT_EQ(points(small), points(large));
  EXPECT_EQ(pool.size(), 2u);
}

TEST(Compounds, OnePieceIsConvex) {
  const meshes::Mesh box = BoxMesh({0, 0, 0}, {1, 2, 3});
  Solid solid{Shape::kCompound, {3, 2, 1}};
  solid.compound = std::make_shared<const objects::Compound>(
      std::make_shared<const objects::ConvexDecomposition>(objects::MakeDecomposition(
          "box", box, meshes::MassPropertiesOf(box), {{meshes::ConvexHull(box, "box")}, 0, 1})),
      solid.sides);
  world::ShapePool pool;
  const btCollisionShape& shape = *pool.Get(solid, 0.04);
  EXPECT_TRUE(shape.isConvex());
  btVector3 lower, upper;
  shape.getAabb(btTransform::getIdentity(), lower, upper);
  EXPECT_LE((ToEigen(upper) - Vector3d(1.5, 1, 0.5)).norm(), 20 * kEpsilon);
  EXPECT_LE((ToEigen(lower) + Vector3d(1.5, 1, 0.5)).norm(), 20 * kEpsilon);
}

/// One L-shape above the floor, with its mesh upright.
struct OneAngle {
  explicit OneAngle(double gap) : scene(EngineScene(1, 20)), solid(Angle({2, 2, 1})) {
    SetWorld(scene, "world.walls", Word("floor"));
    state = OneObjectAt(scene, Vector3d::Zero());
    state.objects[0].solid = solid;
    state.objects[0].pose.orientation = Upright(solid);
    // The centre of mass of three cubes in an L-shape is 5/6 above its base.
    state.objects[0].pose.position = {0, -10 + 5.0 / 6 + gap, 0};
  }
  plan::Scene scene;
  Solid solid;
  layouts::InitialState state;
};

TEST(Compounds, AnAngleRestsOnItsLongSide) {
  const OneAngle one(0);
  world::Engine engine = WholeEngine(one.scene, one.state);
  Steps(engine, 300);
  // It rocks a little as its four corners touch in turn, and comes to rest within Bullet's slop.
  EXPECT_NEAR(Position(engine).y(), one.state.objects[0].pose.position.y(), 0.01);
  EXPECT_NEAR(Position(engine).x(), 0, 0.01);
  EXPECT_EQ(engine.objects()[0]->getActivationState(), ISLAND_SLEEPING);
}

TEST(Compounds, TwoInEachOthersCornerDoNotTouch) {
  // The second's outer corner is in the missing quarter of the first: boxes and hulls overlap, but
  // the bodies do not.
  OneAngle one(0);
  SetGroup(one.scene, "quantity", std::uint64_t{2});
  SetWorld(one.scene, "acceleration", Vector3d(0, 0, 0));
  one.state.objects.push_back(one.state.objects[0]);
  layouts::ObjectState& second = one.state.objects[1];
  const auto contacts_at = [&](double gap) {
    // The mesh's outer corner is at (0, 0), its inner one at (1, 1).
    second.pose.position = one.state.objects[0].pose.position + Vector3d(1 + gap, 1 + gap, 0);
    world::Engine engine = WholeEngine(one.scene, one.state);
    engine.Step();
    int contacts = 0;
    btDispatcher& dispatcher = *engine.world().getDispatcher();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
      const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
      for (int k = 0; k < manifold.getNumContacts(); ++k)
        contacts += manifold.getContactPoint(k).getDistance() <= 0 &&
                    manifold.getBody0()->getUserIndex() < 2 &&
                    manifold.getBody1()->getUserIndex() < 2;
    }
    return contacts;
  };
  EXPECT_EQ(contacts_at(0.01), 0);
  EXPECT_GT(contacts_at(-0.1), 0);
}

TEST(Compounds, SpinKeepsItsAngularMomentum) {
  OneAngle one(10);
  SetWorld(one.scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(one.scene, "world.walls", Word("none"));
  SetWorld(one.scene, "timestep", 1.0 / 1000);
  one.state.objects[0].angular_velocity = {0.3, 2, -1};
  world::Engine engine = WholeEngine(one.scene, one.state);
  const btRigidBody& body = *engine.objects()[0];
  const auto momentum = [&] {
    const Vector3d inertia = one.solid.InertiaPerMass();
    const btMatrix3x3& basis = body.getWorldTransform().getBasis();
    const btVector3 local = body.getAngularVelocity() * basis;
    return ToEigen(basis * (local * ToBullet(inertia)));
  };
  const Vector3d before = momentum();
  Steps(engine, 2000);
  // Bullet's gyroscopic term is of first order: 2 s at 1 ms.
  EXPECT_LE((momentum() - before).norm(), 5e-3 * before.norm());
}

TEST(Compounds, SweptContactsAreRefused) {
  OneAngle one(0);
  one.state.objects[0].numbers["ccd"] = 1;
  try {
    WholeEngine(one.scene, one.state);
    FAIL();
  } catch (const library::SceneError& error) {
    EXPECT_STREQ(error.what(),
                 "object 1: ccd is for convex types, and it is a compound; set ccd off for its "
                 "group");
  }
}

TEST(Compounds, ARunOfThemIsRepeatable) {
  plan::Scene scene = EngineScene(60, 120);
  SetWorld(scene, "cycles", std::uint64_t{120});
  SetGroup(scene, "type", Word("torus"));
  SetGroup(scene, "size", 20.0);
  SetGroup(scene, "orientation", Word("random"));
  SetGroup(scene, "linear_velocity", Uniform(-30.0, 30.0));
  SeedStreams(scene);
  const Recorded first = RunHere(scene), second = RunHere(scene);
  ASSERT_TRUE(first.done()) << first.message();
  EXPECT_EQ(first.hash(), second.hash());
  SetWorld(scene, "omit", schema::WordList{"none"});
  const Recorded whole = RunHere(scene);
  EXPECT_EQ(whole.hash(), first.hash());
}

}  // namespace
}  // namespace cdb::tests
