// Contacts of pairs that do not move are kept; a pair that moves gets new ones.
#include "runtime/engine/worker/come_to_rest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/library/layouts/layout_scene.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

constexpr double kTolerance = 0.002;

TEST(Displacement, IsThatOfThePointFarthestFromTheAxis) {
  const btTransform from(btQuaternion(btVector3(0, 1, 0), btScalar(0.3)), btVector3(1, 2, 3));
  btTransform to = from;
  EXPECT_EQ(worker::Displacement(from, to, 2), 0);
  to.setOrigin(btVector3(1, 5, 7));
  EXPECT_NEAR(worker::Displacement(from, to, 2), 5, 5 * kEpsilon);
  for (const double angle : {0.01, 0.5, std::numbers::pi}) {
    to = from * btTransform(btQuaternion(btVector3(0, 0, 1), static_cast<btScalar>(angle)));
    EXPECT_NEAR(worker::Displacement(from, to, 2), 4 * std::sin(angle / 2), 16 * kEpsilon) << angle;
  }
}

/// The number of contacts that the narrow phase has found.
int g_found = 0;

bool CountContact(btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
                  const btCollisionObjectWrapper*, int, int) {
  ++g_found;
  return true;
}

/// Two stacked cuboids on the floor.
class ContactReuse : public testing::Test {
 protected:
  ContactReuse()
      : engine_(WholeEngine(scene_, layouts::MakeInitialState(scene_))),
        reuse_(engine_, {{1, kTolerance}, {1, kTolerance}}) {
    gContactAddedCallback = CountContact;
    for (const auto& body : engine_.objects())
      body->setCollisionFlags(body->getCollisionFlags() |
                              btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
  }
  ~ContactReuse() override { gContactAddedCallback = nullptr; }

  static plan::Scene Scene() {
    plan::Scene scene = EngineScene(2, 20);
    SetWorld(scene, "sleeping", false);
    SetGroup(scene, "type", Word("cuboid"));
    SetGroup(scene, "size", 1.0);
    SetGroup(scene, "location", Points({{0, -9.5, 0}, {0, -8.5, 0}}));
    SetGroup(scene, "overlap", true);
    return scene;
  }
  /// The number of contacts found in this number of steps.
  int Step(int steps) {
    g_found = 0;
    for (int i = 0; i < steps; ++i) {
      reuse_.BeforeStep();
      engine_.Step();
    }
    return g_found;
  }

  const plan::Scene scene_ = Scene();
  world::Engine engine_;
  worker::ContactReuse reuse_;
};

TEST_F(ContactReuse, FindsHardlyAContactAnewWhereNothingMoves) {
  EXPECT_GT(Step(60), 0);
  const Eigen::Vector3d top = Position(engine_, 1);
  // Two manifolds would have at least 600 new contacts each if they were found in each step.
  EXPECT_LT(Step(600), 60);
  EXPECT_LT((Position(engine_, 1) - top).norm(), 0.05);
}

TEST_F(ContactReuse, LetsFallWhatLosesItsSupport) {
  Step(60);
  btRigidBody& support = *engine_.objects()[0];
  btTransform pose = support.getWorldTransform();
  pose.setOrigin(pose.getOrigin() + btVector3(5, 0, 0));
  support.setWorldTransform(pose);
  EXPECT_GT(Step(120), 0);
  EXPECT_NEAR(Position(engine_, 1).y(), -9.5, 0.05);
}

TEST_F(ContactReuse, FindsTheContactsOfWhatCreeps) {
  Step(60);
  int found = 0;
  for (int step = 0; step < 30; ++step) {
    // Less than the tolerance in one step, but more in several.
    engine_.objects()[1]->setLinearVelocity(btVector3(btScalar(0.05), 0, 0));
    found += Step(1);
  }
  EXPECT_GT(found, 0);
}

}  // namespace
}  // namespace cdb::tests
