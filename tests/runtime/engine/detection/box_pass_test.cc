// The boxes computed in one pass equal Bullet's, bit for bit.
#include "runtime/engine/detection/box_pass.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "tests/runtime/engine/paired_run.h"

namespace cdb::tests {
namespace {

/// A world with bodies of every type and Bullet's own broad phase, and the pass over the same
/// bodies.
class BothBoxes {
 public:
  explicit BothBoxes(const plan::Scene& scene)
      : engine_(scene, layouts::MakeInitialState(scene), omissions::KeepEverything(scene)),
        bodies_(Bodies(engine_)),
        pass_(bodies_),
        boxes_(bodies_.size()),
        is_asleep_(bodies_.size()) {}

  world::Engine& engine() { return engine_; }
  detection::BoxPass& pass() { return pass_; }
  const std::vector<btRigidBody*>& bodies() const { return bodies_; }

  /// Updates both from the present poses. The pass comes first, because Bullet deactivates bodies
  /// that are too large.
  void Update() {
    std::vector<int> states;
    for (btRigidBody* body : bodies_) states.push_back(body->getActivationState());
    pass_.Update(true, boxes_, is_asleep_, parts_);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const int state = bodies_[i]->getActivationState();
      bodies_[i]->forceActivationState(states[i]);
      states[i] = state;
    }
    engine_.world().updateAabbs();
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      EXPECT_EQ(bodies_[i]->getActivationState(), states[i]) << "body " << i;
  }

  void ExpectSame(const std::string& where) {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const btBroadphaseProxy& proxy = *bodies_[i]->getBroadphaseHandle();
      const Box expected = {cdb::bullet::ToVec3(proxy.m_aabbMin),
                            cdb::bullet::ToVec3(proxy.m_aabbMax)};
      EXPECT_EQ(std::memcmp(&boxes_[i], &expected, sizeof expected), 0)
          << where << ", body " << i << ": " << boxes_[i].lower.x << " .. " << boxes_[i].upper.x
          << " instead of " << expected.lower.x << " .. " << expected.upper.x;
    }
  }

 private:
  static std::vector<btRigidBody*> Bodies(const world::Engine& engine) {
    std::vector<btRigidBody*> bodies;
    for (const auto& body : engine.objects()) bodies.push_back(body.get());
    for (const auto& wall : engine.walls()) bodies.push_back(wall.get());
    return bodies;
  }

  world::Engine engine_;
  std::vector<btRigidBody*> bodies_;
  detection::BoxPass pass_;
  kernels::PairParts parts_{3};
  std::vector<Box> boxes_;
  std::vector<std::uint8_t> is_asleep_;
};

plan::Scene AllShapes() {
  plan::Scene scene = EngineScene(120, 40);
  const schema::Value types =
      schema::Distribution{schema::DistributionKind::kAny,
                           {Word("sphere"), Word("cuboid"), Word("cylinder"), Word("cone"),
                            Word("capsule"), Word("tetrahedron")},
                           {1, 1, 1, 1, 1, 1}};
  SetWorld(scene, "world.wall_shape", Word("box"));
  SetGroup(scene, "type", types);
  SetGroup(scene, "size", Uniform(0.3, 1.5));
  SetGroup(scene, "orientation", Word("random"));
  SetGroup(scene, "linear_velocity", Normal(0.0, 20.0));
  SetGroup(scene, "angular_velocity", Normal(0.0, 10.0));
  return scene;
}

TEST(BoxPass, IsBulletsToTheBitForEveryShape) {
  for (const bool is_odd : {false, true}) {
    plan::Scene scene = AllShapes();
    if (!is_odd) SetGroup(scene, "size", 0.9);
    if (is_odd) SetGroup(scene, "aspect", schema::Ratio{Eigen::Vector3d(1, 2.5, 0.4)});
    BothBoxes both(scene);
    EXPECT_GT(both.pass().computed(), is_odd ? 10u : 50u);
    for (int step = 0; step < 60; ++step) {
      both.Update();
      both.ExpectSame("step " + std::to_string(step));
      both.engine().Step();
    }
  }
}

TEST(BoxPass, TreatsWhatIsFarLargeOrNoNumberAsBulletDoes) {
  BothBoxes both(AllShapes());
  std::mt19937 random(3);
  constexpr btScalar kNan = std::numeric_limits<btScalar>::quiet_NaN();
  constexpr btScalar kFar = std::numeric_limits<btScalar>::infinity();
  for (const btScalar value :
       {btScalar(1e5), btScalar(3e5), btScalar(7e5), btScalar(1e7), kFar, kNan}) {
    for (int trial = 0; trial < 20; ++trial) {
      btRigidBody& body = *both.bodies()[random() % 120];
      const int axis = static_cast<int>(random() % 3);
      btTransform pose = body.getWorldTransform();
      pose.getOrigin()[axis] = value;
      (trial % 2 == 0 ? body.getWorldTransform() : body.getInterpolationWorldTransform()) = pose;
    }
    both.Update();
    both.ExpectSame("value " + std::to_string(value));
  }
}

TEST(BoxPass, SkipsThoseThatStillSleep) {
  plan::Scene scene = EngineScene(30, 12);
  SetWorld(scene, "pair_order", Word("sorted"));
  SetWorld(scene, "timestep", 1.0 / 60);
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", 0.8);
  SetGroup(scene, "friction", 0.8);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const auto omissions = omissions::KeepEverything(scene);
  SetWorld(scene, "detector", Word("simple"));
  world::Engine bullet(scene, state, omissions);
  SetWorld(scene, "detector", Word("sweep"));
  world::Engine ours(scene, state, omissions);
  std::size_t most = 0;
  for (int step = 0; step < 600; ++step) {
    if (step == 500)
      for (const world::Engine* engine : {&bullet, &ours})
        for (const auto& body : engine->objects()) body->activate(true);
    bullet.Step();
    ours.Step();
    std::size_t asleep = 0;
    for (Id id = 0; id < 30; ++id) {
      const btBroadphaseProxy& proxy = *bullet.objects()[id]->getBroadphaseHandle();
      const Box expected = {cdb::bullet::ToVec3(proxy.m_aabbMin),
                            cdb::bullet::ToVec3(proxy.m_aabbMax)};
      ASSERT_EQ(std::memcmp(&ours.scene_view()->box(id), &expected, sizeof expected), 0)
          << "step " << step << ", body " << id;
      asleep += bullet.objects()[id]->getActivationState() == ISLAND_SLEEPING;
    }
    most = std::max(most, asleep);
  }
  EXPECT_GT(most, 10u);
}

}  // namespace
}  // namespace cdb::tests
