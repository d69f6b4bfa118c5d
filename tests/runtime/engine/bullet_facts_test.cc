// Limits of Bullet 3.24 that affect a benchmark, with their values. convergence_test.cc has another
// one: default bounces lose energy.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/library/closed_forms/closed_form_scenes.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

plan::Scene InThisPrecision(plan::Scene scene) {
  SetWorld(scene, "precision", Word(world::EnginePrecision()));
  return scene;
}

TEST(Fact, AMassPastTheSquareRootOfThreeOverEpsilonFallsThroughTheFloor) {
  // Bullet drops a contact's mass, 1/(1/m), if it is not below this limit: 1.453e7 in single
  // precision, 7.80e15 in double.
  const double limit = std::sqrt(3.0) / kEpsilon;
  const auto height = [](double mass) {
    plan::Scene scene = InThisPrecision(OneObjectScene());
    SetGroup(scene, "mass", mass);
    SetGroup(scene, "location", At(0, -4.4, 0));
    world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
    Steps(engine, 60);
    return Position(engine).y();
  };
  EXPECT_NEAR(height(0.998 * limit), -4.5, 0.01);
  EXPECT_NEAR(height(1.002 * limit), -4.4 - 4.9 - 4.9 / 60, 0.01);  // as if the floor were missing
}

TEST(Fact, ABoxWithADiagonalOfAMillionIsSwitchedOffInMidAir) {
  const auto engine_of = [](double size, double speed, bool sleeping) {
    plan::Scene scene = InThisPrecision(FlightScene());
    SetWorld(scene, "world.side", 1e9);
    SetWorld(scene, "sleeping", sleeping);
    SetGroup(scene, "size", size);
    SetGroup(scene, "linear_velocity", Vector3d(speed, 0, 0));
    auto engine = std::make_unique<world::Engine>(scene, layouts::MakeInitialState(scene),
                                                  omissions::KeepEverything(scene));
    Steps(*engine, 10);
    return engine;
  };
  const auto is_off = [&](double size, double speed) {
    const auto engine = engine_of(size, speed, true);
    const bool off = engine->objects()[0]->getActivationState() == DISABLE_SIMULATION;
    EXPECT_EQ(off, Position(*engine).norm() == 0);
    return off;
  };
  const double limit = 1e6 / std::sqrt(3.0);
  EXPECT_FALSE(is_off(0.999 * limit, 0));
  EXPECT_TRUE(is_off(1.001 * limit, 0));
  // The box extends to the body's position at the end of the step.
  EXPECT_FALSE(is_off(1, 0.999e6 * 60));
  EXPECT_TRUE(is_off(1, 1.001e6 * 60));
  // Bullet does not deactivate bodies that must not sleep: the body's box stays where it was.
  const auto awake = engine_of(1.001 * limit, 1000, false);
  EXPECT_EQ(awake->objects()[0]->getActivationState(), DISABLE_DEACTIVATION);
  EXPECT_GT(Position(*awake).x(), 100);
  EXPECT_NEAR(static_cast<double>(awake->objects()[0]->getBroadphaseHandle()->m_aabbMax.x()),
              1.001 * limit / 2, 1);
}

TEST(Fact, NaNSpreadsThroughTheIslandInOneCycleAndNoFarther) {
  plan::Scene scene = InThisPrecision(StackScene(5));
  AddGroup(scene, "apart", 1, At(5, 0, 0));
  world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  Steps(engine, 30);
  engine.objects()[2]->setLinearVelocity({std::numeric_limits<btScalar>::quiet_NaN(), 0, 0});
  engine.Step();
  for (std::size_t i = 0; i < 5; ++i) EXPECT_FALSE(Position(engine, i).allFinite()) << i;
  EXPECT_TRUE(Position(engine, 5).allFinite());
  Steps(engine, 100);
  EXPECT_TRUE(Position(engine, 5).allFinite());
}

TEST(Fact, ATurnIsClampedPastAnEighthOfACircle) {
  // For turns above pi/4, Bullet uses the sine of pi/8: 2 atan(w dt tan(pi/8)/(pi/4)).
  const double slope = std::tan(std::numbers::pi / 8) / (std::numbers::pi / 4);  // 0.527
  for (const double turn : {0.1, 0.78, 0.8, 1.41, 3.0, 100.0}) {
    plan::Scene scene = InThisPrecision(SpinScene());
    SetGroup(scene, "type", Word("sphere"));
    SetGroup(scene, "aspect", schema::Ratio{{1, 1, 1}});
    SetGroup(scene, "angular_velocity", Vector3d(0, 60 * turn, 0));
    world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
    const Eigen::Quaterniond before = Orientation(engine);
    engine.Step();
    const double turned = before.angularDistance(Orientation(engine));
    EXPECT_NEAR(turned, turn < std::numbers::pi / 4 ? turn : 2 * std::atan(slope * turn),
                200 * kEpsilon);
    if (turn == 1.41) {
      EXPECT_NEAR(turned / turn, 0.907, 0.001);  // 10 % too low at 1.44
    }
  }
}

struct Column {
  int oldest = 0;   ///< age of the oldest contact between objects, in cycles
  double sunk = 0;  ///< by which the uppermost ball has sunk, m
};

/// Five stacked balls after 4 s; `tall` is the ratio of their height to their width.
Column BallColumn(double tall, double warm_start) {
  plan::Scene scene = InThisPrecision(StackScene(5));
  SetGroup(scene, "type", Word("sphere"));
  SetGroup(scene, "aspect", schema::Ratio{{1, tall, 1}});
  SetWorld(scene, "solver.warm_start", warm_start);
  world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  Steps(engine, 240);
  Column column;
  btDispatcher& dispatcher = *engine.world().getDispatcher();
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
    const bool is_between =
        std::max(manifold.getBody0()->getUserIndex(), manifold.getBody1()->getUserIndex()) < 5;
    for (int j = 0; is_between && j < manifold.getNumContacts(); ++j)
      column.oldest = std::max(column.oldest, manifold.getContactPoint(j).getLifeTime());
  }
  column.sunk = -20 + 4.5 * tall - Position(engine, 4).y();
  return column;
}

TEST(Fact, ContactsOfTwoSpheresAreNewInEveryCycleAndNeverWarmStart) {
  // An ellipsoid that is nearly a sphere is handled by Bullet's general algorithm, which keeps
  // contacts.
  const Column spheres = BallColumn(1, 0.85), nearly = BallColumn(1.0001, 0.85);
  EXPECT_EQ(spheres.oldest, 0);
  EXPECT_EQ(nearly.oldest, 240);
  // With warm starting, it sinks 1 - 0.85 as far as without: 6.7 times less. Spheres sink as
  // without warm starting in single precision, 6.7 times as deep as the near spheres; in double
  // precision 4.0 times, because their one persistent contact, with the floor, is solved last.
  const Column cold = BallColumn(1.0001, 0);
  EXPECT_NEAR(cold.sunk / nearly.sunk, 1 / 0.15, 0.1);
  EXPECT_NEAR(spheres.sunk / nearly.sunk, sizeof(btScalar) == 4 ? 1 / 0.15 : 4.0, 0.1);
}

}  // namespace
}  // namespace cdb::tests
