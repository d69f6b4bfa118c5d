// The engine compared with formulae that hold for every correct engine. Bounds are derived at each
// test; kEpsilon is the relative spacing of numbers, so that a rounding error is at most kEpsilon /
// 2.
#include <gtest/gtest.h>

#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

plan::Scene FreeScene() {
  plan::Scene scene = EngineScene(1, 1000);
  SetWorld(scene, "world.walls", Word("none"));
  return scene;
}

TEST(FreeFall, FollowsTheDiscreteFormula) {
  // v_n = v_0 + n g dt and x_n = x_0 + n v_0 dt + g dt^2 n (n + 1)/2: velocity first, then
  // position.
  const plan::Scene scene = [] {
    plan::Scene s = FreeScene();
    SetGroup(s, "linear_velocity", Vector3d(3, 20, -1));
    return s;
  }();
  const Vector3d start(10, 200, -30), v(3, 20, -1), g(0, -9.8, 0);
  world::Engine engine = WholeEngine(scene, OneObjectAt(scene, start));
  const double dt = 1.0 / 60;
  double farthest = start.norm(), way = 0;
  for (int n = 1; n <= 600; ++n) {
    engine.Step();
    const Vector3d velocity = v + n * dt * g;
    const Vector3d expected = start + n * dt * v + dt * dt * n * (n + 1) / 2 * g;
    farthest = std::max(farthest, expected.norm());
    way += velocity.norm() * dt;
    // g, dt, the force m g and the product of the impulse are each rounded once: 8 roundings in
    // each velocity, and one more for each addition, so n + 8 in total. Each position adds a
    // rounding of the sum and one of the step.
    const double speed = v.norm() + n * dt * g.norm();
    EXPECT_LE((Velocity(engine) - velocity).norm(), (n + 8) * kEpsilon * speed);
    EXPECT_LE((Position(engine) - expected).norm(),
              kEpsilon * (n * farthest + (n + 8) * (way + n * dt * v.norm())));
  }
}

TEST(FreeFall, IsOfFirstOrderInTheTimestep) {
  // x_n - x(t) = g dt t/2: half the step gives half the error.
  const auto error = [](double dt, int steps) {
    plan::Scene scene = FreeScene();
    SetWorld(scene, "timestep", dt);
    world::Engine engine = WholeEngine(scene, OneObjectAt(scene, Vector3d::Zero()));
    Steps(engine, steps);
    const double t = steps * dt;
    return Position(engine).y() + 9.8 * t * t / 2;
  };
  const double coarse = error(1.0 / 32, 32), fine = error(1.0 / 64, 64);
  // A fall of 5 m in 64 steps is off by less than 64 * 2 * 5 roundings.
  const double rounding = 64 * 2 * 5 * kEpsilon;
  EXPECT_NEAR(coarse, -9.8 / 64, rounding);
  EXPECT_NEAR(fine, -9.8 / 128, rounding);
}

TEST(RestingSphere, StaysOnTheFloorAndFallsAsleep) {
  plan::Scene scene = EngineScene(1, 500);
  world::Engine engine =
      WholeEngine(scene, OneObjectAt(scene, {0, -225, 0}));  // touches the floor at -250
  const double dt = 1.0 / 60;
  for (int n = 0; n < 300; ++n) {
    engine.Step();
    // The solver undoes the whole fall of a step while the sphere touches; it is never deeper than
    // the fall of the step in which the contact was made, nor higher than it started.
    EXPECT_NEAR(Position(engine).y(), -225, 9.8 * dt * dt + 500 * kEpsilon);
    EXPECT_NEAR(Position(engine).x(), 0, 500 * kEpsilon);
  }
  EXPECT_EQ(engine.objects()[0]->getActivationState(), ISLAND_SLEEPING);
}

/// The floor with gravity tilted by `angle` towards x: an incline.
plan::Scene InclineScene(double angle) {
  plan::Scene scene = EngineScene(1, 500);
  SetWorld(scene, "world.walls", Word("floor"));
  SetWorld(scene, "acceleration", Vector3d(9.8 * std::sin(angle), -9.8 * std::cos(angle), 0));
  SetWorld(scene, "sleeping", false);
  return scene;
}

TEST(Incline, WithoutFrictionASphereSlidesAndDoesNotRoll) {
  plan::Scene scene = InclineScene(0.5);
  SetGroup(scene, "friction", 0.0);
  world::Engine engine = WholeEngine(scene, OneObjectAt(scene, {0, -225, 0}));
  const double dt = 1.0 / 60, a = 9.8 * std::sin(0.5);
  for (int n = 1; n <= 240; ++n) {
    engine.Step();
    const double expected = a * dt * dt * n * (n + 1) / 2;
    // As in free fall; the floor's normal is exactly y, so contacts leave x alone.
    EXPECT_NEAR(Position(engine).x(), expected, kEpsilon * (3 * n + 8) * (expected + 1));
    EXPECT_EQ(engine.objects()[0]->getAngularVelocity().length(), 0);
  }
}

TEST(Incline, FrictionDecidesBetweenStickingAndSliding) {
  // Bullet uses the product of both frictions. It solves friction along two axes in 10 iterations,
  // and a box rocks on its corners: 3 % of the distance.
  const auto slide = [](double friction, int steps, double of_floor = 0.5) {
    plan::Scene scene = InclineScene(0.35);  // tan 0.35 = 0.365
    SetGroup(scene, "type", Word("cuboid"));
    SetGroup(scene, "friction", friction);
    SetWorld(scene, "world.wall_friction", of_floor);
    world::Engine engine = WholeEngine(scene, OneObjectAt(scene, {0, -225, 0}));
    Steps(engine, steps);
    return Position(engine).x();
  };
  EXPECT_NEAR(slide(1.0, 120), 0, 0.05);  // 0.5 > 0.365
  const double dt = 1.0 / 60, a = 9.8 * (std::sin(0.35) - 0.1 * std::cos(0.35));
  const double way = a * dt * dt * 120 * 121 / 2;
  EXPECT_NEAR(slide(0.2, 120), way, 0.03 * way);
  EXPECT_NEAR(slide(1.0, 120, 0.1), way, 0.03 * way);
  EXPECT_NEAR(slide(0.2, 120, 2), 0, 0.05);
}

/// A ball of radius 25 m on a level floor, with an angular velocity, after 120 steps.
Vector3d SpinOnFloor(const Vector3d& spin, double rolling, double spinning, double of_floor) {
  plan::Scene scene = InclineScene(0);
  SetGroup(scene, "friction", 1.0);
  SetGroup(scene, "rolling_friction", rolling);
  SetGroup(scene, "spinning_friction", spinning);
  SetGroup(scene, "angular_velocity", spin);
  SetGroup(scene, "linear_velocity", Vector3d(-25 * spin.z(), 0, 25 * spin.x()));  // it rolls
  SetWorld(scene, "world.wall_friction", of_floor);
  world::Engine engine = WholeEngine(scene, OneObjectAt(scene, {0, -225, 0}));
  Steps(engine, 120);
  return ToEigen(engine.objects()[0]->getAngularVelocity());
}

TEST(RollingFriction, IsALeverArmTimesTheFrictionOfTheOther) {
  // The torque b mu m g brakes a rolling ball by 5 b mu g / (7 r^2) in rad/s^2.
  for (const double of_floor : {0.5, 1.0}) {
    const double brake = 5 * 0.1 * of_floor * 9.8 / (7 * 25 * 25);
    const double spin = SpinOnFloor({0, 0, -1}, 0.1, 0, of_floor).z();
    EXPECT_NEAR(spin, -1 + 2 * brake, 0.05 * 2 * brake) << of_floor;
  }
}

TEST(SpinningFriction, BrakesTheSpinAboutTheNormalOfAContactThatHasRollingFriction) {
  // The torque s mu m g brakes the ball by 5 s mu g / (2 r^2).
  for (const double of_floor : {0.5, 1.0}) {
    const double brake = 5 * 0.3 * of_floor * 9.8 / (2 * 25 * 25);
    const double spin = SpinOnFloor({0, 1, 0}, 1e-6, 0.3, of_floor).y();
    EXPECT_NEAR(spin, 1 - 2 * brake, 0.05 * 2 * brake) << of_floor;
  }
  EXPECT_NEAR(SpinOnFloor({0, 1, 0}, 0, 0.3, 0.5).y(), 1, 1e-5);
}

TEST(Spin, OfABallIsConstantAndTurnsByOmegaDt) {
  plan::Scene scene = FreeScene();
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  const Vector3d omega(0.5, 2, -1);
  SetGroup(scene, "angular_velocity", omega);
  world::Engine engine = WholeEngine(scene, OneObjectAt(scene, Vector3d::Zero()));
  const double dt = 1.0 / 60;
  for (int n = 1; n <= 300; ++n) {
    engine.Step();
    const Vector3d spin = ToEigen(engine.objects()[0]->getAngularVelocity());
    // Bullet's gyroscopic term solves for a change of spin that is zero for a ball, up to the
    // rounding of a 3 x 3 system: 32 roundings a step.
    EXPECT_LE((spin - omega).norm(), 32 * n * kEpsilon * omega.norm());
    const btQuaternion q = engine.objects()[0]->getWorldTransform().getRotation();
    const Eigen::Quaterniond turn(q.w(), q.x(), q.y(), q.z());
    const double off = turn.angularDistance(layouts::TurnAbout(omega * n * dt));
    // Each step multiplies quaternions and converts to a matrix: 32 roundings, and the error of the
    // spin, summed over n steps. angularDistance loses half the digits near zero, but not here.
    EXPECT_LE(off, 32 * n * kEpsilon + 32 * kEpsilon * omega.norm() * dt * n * (n + 1) / 2);
  }
}

TEST(Damping, TakesItsPartInASecond) {
  plan::Scene scene = FreeScene();
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(scene, "sleeping", false);
  SetGroup(scene, "linear_velocity", Vector3d(100, 0, 0));
  SetGroup(scene, "angular_velocity", Vector3d(0, 3, 0));
  SetGroup(scene, "linear_damping", 0.3);
  SetGroup(scene, "angular_damping", 0.6);
  world::Engine engine = WholeEngine(scene, OneObjectAt(scene, Vector3d::Zero()));
  Steps(engine, 120);  // 2 s
  // (1 - d)^(1/60) to the 120th: pow and product are off by a few roundings a step.
  EXPECT_NEAR(Velocity(engine).x(), 100 * 0.7 * 0.7, 49 * 120 * 8 * kEpsilon);
  EXPECT_NEAR(engine.objects()[0]->getAngularVelocity().y(), 3 * 0.4 * 0.4,
              0.48 * 120 * 32 * kEpsilon);
}

TEST(HeadOnCollision, KeepsMomentumAndExchangesVelocitiesWhenElastic) {
  plan::Scene scene = EngineScene(2, 1000);
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(scene, "contact", Word("faithful"));
  SetGroup(scene, "restitution", 1.0);
  SetGroup(scene, "friction", 0.0);
  layouts::InitialState state = layouts::DrawObjects(scene);
  state.objects[0].pose.position = {-60, 0, 0};
  state.objects[1].pose.position = {60, 0, 0};
  state.objects[0].linear_velocity = {30, 0, 0};
  state.objects[1].linear_velocity = {-10, 0, 0};
  world::Engine engine = WholeEngine(scene, state);
  Steps(engine, 240);
  // One impulse of 40 between equal masses: a dozen roundings of it.
  EXPECT_NEAR(Velocity(engine, 0).x(), -10, 40 * 12 * kEpsilon);
  EXPECT_NEAR(Velocity(engine, 1).x(), 30, 40 * 12 * kEpsilon);
  EXPECT_NEAR((Velocity(engine, 0) + Velocity(engine, 1)).x(), 20, 40 * 4 * kEpsilon);
}

TEST(Bounce, OffTheFloorKeepsTheRestitutionsPart) {
  // faithful: a sphere that falls 100 m hits the floor at v and leaves at e v. Bullet adds the
  // restitution to the velocity at the start of the step, before that step's g dt.
  for (const auto& [kept, of_floor] : {std::pair(0.5, 1.0), {0.9, 1.0}, {0.9, 0.5}}) {
    plan::Scene scene = EngineScene(1, 500);
    SetWorld(scene, "world.wall_restitution", of_floor);
    SetWorld(scene, "contact", Word("faithful"));
    SetGroup(scene, "restitution", kept);
    world::Engine engine = WholeEngine(scene, OneObjectAt(scene, {0, -125, 0}));
    double fastest_down = 0, fastest_up = 0;
    for (int n = 0; n < 350 && fastest_up == 0; ++n) {
      engine.Step();
      fastest_down = std::min(fastest_down, Velocity(engine).y());
      fastest_up = std::max(fastest_up, Velocity(engine).y());
    }
    EXPECT_NEAR(fastest_up, -kept * of_floor * fastest_down, 2 * 9.8 / 60) << kept;
  }
}

TEST(BoxOnFloor, CuboidCylinderAndConeStandAtTheirHalfHeight) {
  // The extents equal the sides for any margin: the base is at -250 for each.
  for (const char* type : {"cuboid", "cylinder", "cone"}) {
    for (const double margin : {0.04, 1.0}) {
      plan::Scene scene = EngineScene(1, 500);
      SetGroup(scene, "type", Word(type));
      SetGroup(scene, "margin", margin);
      SetGroup(scene, "aspect", schema::Ratio{{1, 0.5, 1}});
      const layouts::InitialState drawn = layouts::DrawObjects(scene);
      const double rest =
          -250 - objects::Bounds(drawn.objects[0].solid, Eigen::Quaterniond::Identity()).lower.y();
      world::Engine engine = WholeEngine(scene, OneObjectAt(scene, {0, rest, 0}));
      Steps(engine, 300);
      // Bullet's split impulse leaves penetrations above -0.04 to the next steps.
      EXPECT_NEAR(Position(engine).y(), rest, 0.04 + 9.8 / 3600) << type << " margin " << margin;
    }
  }
}

}  // namespace
}  // namespace cdb::tests
