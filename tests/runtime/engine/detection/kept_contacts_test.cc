// The points of a pair whose contacts a detector finds: accumulated as by Bullet, or replaced.
#include "runtime/engine/detection/kept_contacts.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <new>
#include <random>
#include <string>
#include <vector>

#include "library/detectors/bullet/vectors.h"
#include "runtime/engine/probes/state_hash.h"
#include "tests/runtime/engine/paired_run.h"

namespace cdb::tests {
namespace {

using detection::KeptContacts;

/// Two bodies at about the origin, of which the first is a ball if the second is.
class KeptContactsTest : public testing::Test {
 protected:
  void Make(btCollisionShape& first, btCollisionShape& second) {
    a_.setCollisionShape(&first);
    b_.setCollisionShape(&second);
    for (btCollisionObject* body : {&a_, &b_}) {
      body->setFriction(btScalar(0.7));
      body->setRestitution(btScalar(0.3));
      body->setRollingFriction(btScalar(0.02));
      body->setContactStiffnessAndDamping(1000, 10);
    }
    kept_ = new (dispatcher_.allocateCollisionAlgorithm(sizeof(KeptContacts)))
        KeptContacts(dispatcher_, a_, b_);
    btManifoldArray manifolds;
    kept_->getAllContactManifolds(manifolds);
    manifold_ = manifolds[0];
  }
  void TearDown() override {
    kept_->~KeptContacts();
    dispatcher_.freeCollisionAlgorithm(kept_);
    EXPECT_EQ(dispatcher_.getNumManifolds(), 0);
  }
  btManifoldPoint& Point(int i) { return manifold_->getContactPoint(i); }

  static Contact At(double x, double z, double distance = -0.001) {
    return {.a = 0,
            .b = 1,
            .on_a = {x, distance, z},
            .on_b = {x, 0, z},
            .normal = {0, 1, 0},
            .distance = distance};
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btBoxShape box_{btVector3(1, 1, 1)}, other_box_{btVector3(1, 1, 1)};
  btSphereShape ball_{1}, other_ball_{1};
  btCollisionObject a_, b_;
  KeptContacts* kept_ = nullptr;
  btPersistentManifold* manifold_ = nullptr;
};

TEST_F(KeptContactsTest, AccumulateAsInBulletToTheBit) {
  Make(box_, other_box_);
  btPersistentManifold expected(&a_, &b_, 0, manifold_->getContactBreakingThreshold(),
                                manifold_->getContactProcessingThreshold());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-0.03, 0.03), depth(-0.02, 0.03);
  for (int cycle = 0; cycle < 200; ++cycle) {
    const auto turn = static_cast<btScalar>(place(random));
    a_.setWorldTransform(btTransform(btQuaternion(turn, turn / 2, 0), btVector3(turn, 0, turn)));
    std::vector<Contact> contacts(random() % 6);
    for (Contact& contact : contacts) contact = At(place(random), place(random), depth(random));
    kept_->Update(contacts, false);
    const btCollisionObjectWrapper first(nullptr, &box_, &a_, a_.getWorldTransform(), -1, -1),
        second(nullptr, &other_box_, &b_, b_.getWorldTransform(), -1, -1);
    btManifoldResult result(&first, &second);
    result.setPersistentManifold(&expected);
    for (const Contact& contact : contacts)
      result.addContactPoint(bullet::ToBullet(contact.normal), bullet::ToBullet(contact.on_b),
                             static_cast<btScalar>(contact.distance));
    result.refreshContactPoints();
    ASSERT_EQ(manifold_->getNumContacts(), expected.getNumContacts()) << cycle;
    for (int i = 0; i < expected.getNumContacts(); ++i) {
      btManifoldPoint &point = Point(i), &other = expected.getContactPoint(i);
      // The solver overwrites the directions of friction before it reads them.
      other.m_lateralFrictionDir1 = point.m_lateralFrictionDir1;
      other.m_lateralFrictionDir2 = point.m_lateralFrictionDir2;
      const auto same = [&](const btVector3& x, const btVector3& y) {
        return std::memcmp(x.m_floats, y.m_floats, 3 * sizeof(btScalar)) == 0;
      };
      EXPECT_TRUE(same(point.m_localPointA, other.m_localPointA));
      EXPECT_TRUE(same(point.m_localPointB, other.m_localPointB));
      EXPECT_TRUE(same(point.m_positionWorldOnA, other.m_positionWorldOnA));
      EXPECT_TRUE(same(point.m_positionWorldOnB, other.m_positionWorldOnB));
      EXPECT_TRUE(same(point.m_normalWorldOnB, other.m_normalWorldOnB));
      EXPECT_EQ(point.m_distance1, other.m_distance1);
      EXPECT_EQ(point.m_combinedFriction, other.m_combinedFriction);
      EXPECT_EQ(point.m_combinedRestitution, other.m_combinedRestitution);
      EXPECT_EQ(point.m_combinedRollingFriction, other.m_combinedRollingFriction);
      EXPECT_EQ(point.m_combinedContactStiffness1, other.m_combinedContactStiffness1);
      EXPECT_EQ(point.m_combinedContactDamping1, other.m_combinedContactDamping1);
      EXPECT_EQ(point.m_contactPointFlags, other.m_contactPointFlags);
      EXPECT_EQ(point.m_lifeTime, other.m_lifeTime);
      EXPECT_EQ(point.m_appliedImpulse, other.m_appliedImpulse);
      point.m_appliedImpulse = other.m_appliedImpulse = static_cast<btScalar>(cycle + i);
    }
  }
}

TEST_F(KeptContactsTest, KeepImpulsesWherePointsStay) {
  Make(box_, other_box_);
  const std::vector<Contact> before = {At(-1, -1), At(-1, 1), At(1, 1), At(1, -1)};
  kept_->Update(before, true);
  ASSERT_EQ(manifold_->getNumContacts(), 4);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(Point(i).m_appliedImpulse, 0);
    EXPECT_EQ(Point(i).m_lifeTime, 1);
    Point(i).m_appliedImpulse = static_cast<btScalar>(i + 1);
    Point(i).m_appliedImpulseLateral1 = static_cast<btScalar>(10 * (i + 1));
  }
  // Bodies move together: a point is found by its place on the first.
  const btVector3 moved(5, 0, 0);
  a_.setWorldTransform(btTransform(btQuaternion::getIdentity(), moved));
  b_.setWorldTransform(btTransform(btQuaternion::getIdentity(), moved));
  const std::vector<Contact> after = {At(6.001, 0.999), At(4, -1), At(5, 0)};
  kept_->Update(after, true);
  ASSERT_EQ(manifold_->getNumContacts(), 3);
  EXPECT_EQ(Point(0).m_appliedImpulse, 3);
  EXPECT_EQ(Point(0).m_appliedImpulseLateral1, 30);
  EXPECT_EQ(Point(0).m_lifeTime, 2);
  EXPECT_EQ(Point(1).m_appliedImpulse, 1);
  EXPECT_EQ(Point(2).m_appliedImpulse, 0) << "nothing was there";
  EXPECT_EQ(Point(2).m_lifeTime, 1);
  EXPECT_NEAR(static_cast<double>(Point(0).m_localPointA.x()), 1.001, 1e-6);
  EXPECT_NEAR(static_cast<double>(Point(0).m_combinedFriction), 0.49, 1e-6);
}

TEST_F(KeptContactsTest, GiveAnImpulseToOnePoint) {
  Make(box_, other_box_);
  kept_->Update(std::vector{At(0, 0)}, true);
  Point(0).m_appliedImpulse = 8;
  kept_->Update(std::vector{At(0.002, 0), At(0.001, 0)}, true);
  ASSERT_EQ(manifold_->getNumContacts(), 2);
  EXPECT_EQ(Point(0).m_appliedImpulse + Point(1).m_appliedImpulse, 8);
}

TEST_F(KeptContactsTest, AreNoneWhereBodiesAreApart) {
  Make(box_, other_box_);
  kept_->Update(std::vector{At(0, 0)}, true);
  kept_->Update(std::vector{At(0, 0, 0.5)}, true);
  EXPECT_EQ(manifold_->getNumContacts(), 0) << "beyond the breaking threshold";
  kept_->Update(std::vector{At(0, 0)}, true);
  kept_->Update({}, true);
  EXPECT_EQ(manifold_->getNumContacts(), 0);
}

TEST_F(KeptContactsTest, AreFourOfMore) {
  Make(box_, other_box_);
  kept_->Update(std::vector{At(-1, -1), At(-1, 1), At(0, 0, -0.1), At(1, 1), At(1, -1)}, true);
  EXPECT_EQ(manifold_->getNumContacts(), 4);
}

TEST_F(KeptContactsTest, OfTwoBallsStartWithoutImpulses) {
  Make(ball_, other_ball_);
  for (const bool are_all : {false, true}) {
    kept_->Update(std::vector{At(0, 0)}, are_all);
    Point(0).m_appliedImpulse = 8;
    kept_->Update(std::vector{At(0, 0)}, are_all);
    ASSERT_EQ(manifold_->getNumContacts(), 1);
    EXPECT_EQ(Point(0).m_appliedImpulse, 0);
    kept_->Update({}, are_all);
    EXPECT_EQ(manifold_->getNumContacts(), 0);
  }
}

/// A scene with the narrow phase `batch`.
plan::Scene OfBatch(std::uint64_t quantity, const char* order) {
  plan::Scene scene = EngineScene(quantity, 20);
  SetWorld(scene, "detector", Word("auto"));
  SetWorld(scene, "narrow_phase", Word("batch"));
  SetWorld(scene, "pair_order", Word(order));
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", 1.0);
  return scene;
}

std::vector<const btPersistentManifold*> Manifolds(world::Engine& engine) {
  btDispatcher& dispatcher = *engine.world().getDispatcher();
  std::vector<const btPersistentManifold*> all;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
    all.push_back(dispatcher.getManifoldByIndexInternal(i));
  return all;
}

TEST(Manifolds, ComeWithTheFirstContactAndGoWithThePair) {
  plan::Scene scene = OfBatch(2, "sorted");
  SetWorld(scene, "acceleration", Eigen::Vector3d(0, 0, 0));
  SetWorld(scene, "timestep", 1.0 / 60);
  layouts::InitialState state = layouts::DrawObjects(scene);
  state.objects[0].pose.position = {0, 0.03, 0};  // boxes overlap, bodies are too far for a contact
  state.objects[1].pose.position = {0, 1.06, 0};
  world::Engine engine = WholeEngine(scene, state);
  engine.Step();
  const auto pairs = [&] { return engine.world().getPairCache()->getNumOverlappingPairs(); };
  EXPECT_EQ(pairs(), 1);
  EXPECT_TRUE(Manifolds(engine).empty());
  const auto set_speed = [&](btScalar y) {
    engine.objects()[0]->setLinearVelocity(btVector3(0, y, 0));
    engine.objects()[1]->setLinearVelocity(btVector3(0, 0, 0));
  };
  set_speed(btScalar(2.1));
  Steps(engine, 2);
  const auto touching = Manifolds(engine);
  ASSERT_EQ(touching.size(), 1u);
  EXPECT_EQ(touching[0]->getNumContacts(), 4);
  set_speed(btScalar(-1.2));
  Steps(engine, 3);
  EXPECT_EQ(pairs(), 1);
  ASSERT_EQ(Manifolds(engine), touching) << "kept with the pair";
  EXPECT_EQ(touching[0]->getNumContacts(), 0);
  Steps(engine, 20);
  EXPECT_EQ(pairs(), 0);
  EXPECT_TRUE(Manifolds(engine).empty());
}

// The poses of sleeping bodies are read once. Where one that has woken were taken to be where it
// slept, its contacts would be inside of it, or outside.
TEST(Manifolds, AreOnTheSurfacesOfBodiesThatSlept) {
  plan::Scene scene = OfBatch(3, "sorted");
  SetWorld(scene, "timestep", 1.0 / 60);
  SetWorld(scene, "sleeping", true);
  layouts::InitialState state = layouts::DrawObjects(scene);
  const double height = -0.5 * 20 + 0.5;
  state.objects[0].pose.position = {0, height, 0};
  state.objects[1].pose.position = {3, height, 0};
  state.objects[2].pose.position = {-6, height, 0};
  world::Engine engine = WholeEngine(scene, state);
  Steps(engine, 200);
  const double slept_at = Position(engine, 1).x();
  const auto off_surface = [](const btCollisionObject* body, const btVector3& at) {
    if (body->getCollisionShape()->getShapeType() != BOX_SHAPE_PROXYTYPE) return 0.0;
    return std::abs(static_cast<double>(at.absolute()[at.absolute().maxAxis()]) - 0.5);
  };
  int contacts = 0;
  for (const double speed : {12.0, -12.0}) {
    ASSERT_FALSE(engine.objects()[0]->isActive());
    ASSERT_FALSE(engine.objects()[1]->isActive());
    engine.objects()[2]->activate(true);
    engine.objects()[2]->setLinearVelocity(btVector3(btScalar(speed), 0, 0));
    for (int cycle = 0; cycle < 300; ++cycle) {
      engine.Step();
      for (const btPersistentManifold* manifold : Manifolds(engine))
        for (int i = 0; i < manifold->getNumContacts(); ++i, ++contacts) {
          const btManifoldPoint& point = manifold->getContactPoint(i);
          ASSERT_LT(off_surface(manifold->getBody0(), point.m_localPointA), 1e-3) << cycle;
          ASSERT_LT(off_surface(manifold->getBody1(), point.m_localPointB), 1e-3) << cycle;
        }
    }
  }
  EXPECT_GT(contacts, 1000);
  EXPECT_GT(Position(engine, 1).x(), slept_at + 0.1) << "it was pushed";
}

TEST(Manifolds, ComeWithThePairIfItsOrderIsListed) {
  plan::Scene scene = OfBatch(2, "listed");
  layouts::InitialState state = layouts::DrawObjects(scene);
  state.objects[0].pose.position = {0, 0, 0};
  state.objects[1].pose.position = {0, 1.03, 0};
  world::Engine engine = WholeEngine(scene, state);
  engine.Step();
  EXPECT_EQ(static_cast<int>(Manifolds(engine).size()),
            engine.world().getPairCache()->getNumOverlappingPairs());
}

TEST(Manifolds, AreTheSameWithAnyNumberOfThreads) {
  plan::Scene scene = OfBatch(1500, "sorted");
  SetWorld(scene, "acceleration", Eigen::Vector3d(0, -9.8, 0));
  const layouts::InitialState drawn = layouts::DrawObjects(scene);
  const auto run = [&](std::uint64_t threads) {
    SetWorld(scene, "threads", threads);
    layouts::InitialState state = drawn;
    for (std::size_t i = 0; i < state.objects.size(); ++i)  // a heap
      state.objects[i].pose.position =
          Eigen::Vector3d(static_cast<double>(i % 10), static_cast<double>(i / 100),
                          static_cast<double>(i / 10 % 10)) *
              0.99 -
          Eigen::Vector3d(4.5, 9.5, 4.5);
    world::Engine engine = WholeEngine(scene, state);
    Steps(engine, 20);
    EXPECT_GT(Manifolds(engine).size(), 3000u);
    return probes::StateHash(engine);
  };
  const std::string one = run(1);
  EXPECT_EQ(run(2), one);
  EXPECT_EQ(run(3), one);
}

TEST(Manifolds, OfAStackStayWhileItSleepsAndWhenItWakes) {
  plan::Scene scene = OfBatch(4, "sorted");
  SetWorld(scene, "acceleration", Eigen::Vector3d(0, -9.8, 0));
  layouts::InitialState state = layouts::DrawObjects(scene);
  for (std::size_t i = 0; i < 4; ++i)
    state.objects[i].pose.position = {0, -9.5 + static_cast<double>(i), 0};
  world::Engine engine = WholeEngine(scene, state);
  const auto asleep = [&] {
    int count = 0;
    for (const auto& body : engine.objects())
      count += body->getActivationState() == ISLAND_SLEEPING;
    return count;
  };
  const auto impulses = [&] {
    std::vector<btScalar> all;
    for (const btPersistentManifold* manifold : Manifolds(engine))
      for (int i = 0; i < manifold->getNumContacts(); ++i)
        all.push_back(manifold->getContactPoint(i).m_appliedImpulse);
    return all;
  };
  for (int step = 0; step < 600 && asleep() < 4; ++step) engine.Step();
  ASSERT_EQ(asleep(), 4);
  const std::vector<btScalar> before = impulses();
  EXPECT_EQ(before.size(), 16u);
  Steps(engine, 10);
  EXPECT_EQ(impulses(), before);
  engine.objects()[3]->activate(true);
  engine.Step();
  EXPECT_EQ(impulses().size(), 16u);
  for (const btScalar impulse : impulses()) EXPECT_GT(impulse, 0);
  Steps(engine, 60);
  EXPECT_NEAR(Position(engine, 3).y(), -6.5, 0.01);
}

}  // namespace
}  // namespace cdb::tests
