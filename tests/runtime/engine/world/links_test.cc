// Joints and springs against closed forms, in both precisions.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "library/scene_error.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/runtime/engine/paired_run.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

constexpr double kTimestep = 1.0 / 60;

/// Linked objects of size 1 in free space, one below the other.
plan::Scene LinkedScene(std::uint64_t quantity, const char* type) {
  plan::Scene scene = EngineScene(quantity, 1000);
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(scene, "sleeping", false);
  SetGroup(scene, "size", 1.0);
  SetGroup(scene, "location", Layout("line", {}));
  SetGroup(scene, "links.type", Word(type));
  return scene;
}

/// Springs with w dt = `w_dt` for a mass of 1 kg.
plan::Scene SpringChainScene(std::uint64_t quantity, double w_dt) {
  plan::Scene scene = LinkedScene(quantity, "spring");
  SetGroup(scene, "links.stiffness", std::pow(w_dt / kTimestep, 2));
  return scene;
}

double KineticEnergy(const world::Engine& engine) {
  double energy = 0;
  for (std::size_t i = 0; i < engine.objects().size(); ++i)
    energy += engine.initial_state().objects[i].mass * Velocity(engine, i).squaredNorm() / 2;
  return energy;
}

TEST(Spring, SwingsWithTheIntegratorsOwnFrequency) {
  // v' = v - w^2 x dt, x' = x + v' dt: x_n = v_0 dt sin(n a) / sin(a) with cos(a) = 1 - (w dt)^2/2,
  // valid up to w dt = 2.
  for (const double w_dt : {0.01, 0.1, 1.0, 1.9}) {
    SCOPED_TRACE(w_dt);
    const plan::Scene scene = SpringChainScene(1, w_dt);
    layouts::InitialState state = OneObjectAt(scene, Vector3d::Zero());
    state.objects[0].linear_velocity = {0, -0.5, 0};
    world::Engine engine = WholeEngine(scene, state);
    const double angle = std::acos(1 - w_dt * w_dt / 2);
    const double swing = 0.5 * kTimestep / std::sin(angle);
    for (int n = 1; n <= 400; ++n) {
      engine.Step();
      const double expected = -swing * std::sin(n * angle);
      // The rounding of a step, a few kEpsilon of the amplitude, adds an oscillation, and that of
      // the frequency accumulates; near w dt = 2 both are larger by 1 / sin(a).
      EXPECT_NEAR(Position(engine).y(), expected, 32 * n * kEpsilon * swing / std::sin(angle));
      EXPECT_EQ(Position(engine).x(), 0);
    }
  }
}

TEST(Spring, SwingsAboutWhereGravityTakesIt) {
  plan::Scene scene = SpringChainScene(1, 0.1);
  SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
  world::Engine engine = WholeEngine(scene, OneObjectAt(scene, Vector3d::Zero()));
  // The mean over whole periods of 2 pi / 0.1 steps.
  double sum = 0;
  for (int n = 0; n < 628; ++n) {
    engine.Step();
    sum += Position(engine).y();
  }
  EXPECT_NEAR(sum / 628, -9.8 / 36, 0.01 * 9.8 / 36);
}

TEST(Spring, ExplodesPastTwo) {
  const auto speed_after = [](double w_dt) {
    const plan::Scene scene = SpringChainScene(1, w_dt);
    layouts::InitialState state = OneObjectAt(scene, Vector3d::Zero());
    state.objects[0].linear_velocity = {0, -0.1, 0};
    world::Engine engine = WholeEngine(scene, state);
    double fastest = 0;
    for (int n = 0; n < 200; ++n) {
      engine.Step();
      fastest = std::max(fastest, Velocity(engine).norm());
    }
    return fastest;
  };
  EXPECT_LT(speed_after(1.99), 0.1 * 2 / std::sqrt(1 - std::pow(1.99 / 2, 2)));
  EXPECT_GT(speed_after(2.01), 1e6);
}

TEST(Spring, BetweenTwoSwingsWithTheirReducedMass) {
  plan::Scene scene = SpringChainScene(2, 0.2);
  SetGroup(scene, "links.anchor", false);
  SetGroup(scene, "links.end_mass", 3.0);
  layouts::InitialState state = layouts::MakeInitialState(scene);
  const double length = (state.objects[1].pose.position - state.objects[0].pose.position).norm();
  EXPECT_NEAR(length, 1.1, 1e-12);
  state.objects[1].linear_velocity = {0, 0.4, 0};
  world::Engine engine = WholeEngine(scene, state);
  const double w_dt = 0.2 / std::sqrt(0.75), angle = std::acos(1 - w_dt * w_dt / 2);
  for (int n = 1; n <= 300; ++n) {
    engine.Step();
    const double stretch = Position(engine, 0).y() - Position(engine, 1).y() - length;
    const double expected = -0.4 * kTimestep * std::sin(n * angle) / std::sin(angle);
    // Positions of about 4 m are rounded twice a step.
    EXPECT_NEAR(stretch, expected, 16 * n * kEpsilon);
    EXPECT_NEAR(Velocity(engine, 0).y() + 3 * Velocity(engine, 1).y(), 1.2, 8 * n * kEpsilon);
  }
}

TEST(Spring, IsDampedByTheWholeDamper) {
  // Also if the damper is stronger than the spring, and opposes it.
  for (const double damping : {0.5, 6.0, 60.0}) {
    SCOPED_TRACE(damping);
    plan::Scene scene = SpringChainScene(1, 0.3);
    SetGroup(scene, "links.damping", damping);
    layouts::InitialState state = OneObjectAt(scene, Vector3d::Zero());
    state.objects[0].linear_velocity = {0, 1, 0};
    world::Engine engine = WholeEngine(scene, state);
    const double stiffness = std::pow(0.3 / kTimestep, 2);
    double x = 0, v = 1;
    for (int n = 1; n <= 100; ++n) {
      engine.Step();
      v -= kTimestep * (stiffness * x + damping * v);
      x += kTimestep * v;
      EXPECT_NEAR(Position(engine).y(), x, 16 * n * kEpsilon);
      EXPECT_NEAR(Velocity(engine).y(), v, 32 * n * kEpsilon);
    }
  }
}

TEST(Spring, KeepsItsEnergyWithTheIntegratorsTerm) {
  // x and v stay on an ellipse; those of a chain on one for each mode.
  plan::Scene scene = SpringChainScene(6, 0.5);
  SetGroup(scene, "links.end_mass", 4.0);
  layouts::InitialState state = layouts::MakeInitialState(scene);
  state.objects[2].linear_velocity = {0, 1, 0};
  world::Engine engine = WholeEngine(scene, state);
  for (int n = 1; n <= 1000; ++n) {
    engine.Step();
    const double energy = KineticEnergy(engine) + engine.links().SpringEnergy(kTimestep);
    ASSERT_NEAR(energy, 0.5, 64 * n * kEpsilon);
  }
  EXPECT_FALSE(engine.links().HasJoints());
}

TEST(BallJoint, IsAPendulum) {
  // A ball of radius 1/2 on a pivot at its top: w^2 = g l / (l^2 + 2/5 r^2) = 14.
  plan::Scene scene = LinkedScene(1, "ball");
  SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
  layouts::InitialState state = OneObjectAt(scene, Vector3d::Zero());
  state.objects[0].linear_velocity = {0.05, 0, 0};
  state.objects[0].angular_velocity = {0, 0, 0.1};
  world::Engine engine = WholeEngine(scene, state);
  const double period = 2 * std::numbers::pi / std::sqrt(14.0);
  // Upward zero crossings, interpolated; the first is counted from 0.
  double last = 0, passage = 0;
  int passages = 0;
  for (int n = 1; passages < 10 && n < 2000; ++n) {
    engine.Step();
    const double x = Position(engine).x();
    if (last < 0 && x >= 0) {
      ++passages;
      passage = (n - x / (x - last)) * kTimestep;
    }
    last = x;
    // A fifth of the gap is corrected in each step.
    EXPECT_LT(engine.links().MeasureGaps().largest, 1e-4);
  }
  ASSERT_EQ(passages, 10);
  // (w dt)^2 / 24 = 1.6e-4 from the integrator, 4.5e-5 from the amplitude; Bullet loses some
  // energy.
  EXPECT_NEAR(passage / 10, period, 2e-3 * period);
}

TEST(HingeJoint, TurnsAboutZAlone) {
  plan::Scene scene = LinkedScene(3, "hinge");
  SetWorld(scene, "acceleration", Vector3d(4, -9.8, 4));
  world::Engine engine(WholeEngine(scene, layouts::MakeInitialState(scene)));
  double widest = 0, out = 0;
  for (int n = 0; n < 300; ++n) {
    engine.Step();
    for (std::size_t i = 0; i < 3; ++i) {
      widest = std::max(widest, std::abs(Position(engine, i).x()));
      out = std::max(out, std::abs(Position(engine, i).z()));
    }
  }
  EXPECT_GT(widest, 0.5);
  EXPECT_LT(out, 0.1) << "the gaps of the joints";
}

TEST(FixedJoint, KeepsDistanceAndTurn) {
  plan::Scene scene = LinkedScene(2, "fixed");
  SetGroup(scene, "links.anchor", false);
  layouts::InitialState state = layouts::MakeInitialState(scene);
  state.objects[1].linear_velocity = {1, 0, 0};
  world::Engine engine = WholeEngine(scene, state);
  for (int n = 0; n < 300; ++n) {
    engine.Step();
    EXPECT_NEAR((Position(engine, 1) - Position(engine, 0)).norm(), 1.1, 0.02);
    const btQuaternion apart = engine.objects()[0]->getWorldTransform().getRotation().inverse() *
                               engine.objects()[1]->getWorldTransform().getRotation();
    EXPECT_LT(std::abs(static_cast<double>(apart.getAngleShortestPath())), 0.05);
  }
  // A rigid bar that is hit at its end rotates: (v / 2) / (d / 2).
  EXPECT_GT(static_cast<double>(engine.objects()[0]->getAngularVelocity().norm()), 0.3);
}

/// A horizontal chain with the given mass at its end, for two seconds.
Recorded RunOfChain(const char* type, const Vector3d& along, double end_mass) {
  plan::Scene scene = LinkedScene(4, type);
  SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
  SetWorld(scene, "record", schema::WordList{"stability"});
  SetWorld(scene, "cycles", std::uint64_t{120});
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "location", Layout("line", {{"along", along}}));
  SetGroup(scene, "links.end_mass", end_mass);
  return RunHere(scene);
}

TEST(Links, TellHowFarTheyBendAndStretch) {
  const Recorded beam = RunOfChain("fixed", {1, 0, 0}, 1);
  ASSERT_TRUE(beam.done()) << beam.message();
  const double bend = beam.recording.Reals("joint_bend")[119];
  const Vector3d end = beam.engine->initial_state().objects[3].pose.position;
  const double sunk = (Position(*beam.engine, 3) - end).norm();
  EXPECT_GT(bend, 0.05);
  EXPECT_NEAR(bend, sunk / 3.85, 0.02) << "over the length of the beam";
  EXPECT_LT(beam.recording.Reals("joint_gap")[119], 0.05);
  const Recorded hanging = RunOfChain("fixed", {0, -1, 0}, 1);
  EXPECT_LT(hanging.recording.Reals("joint_bend")[119], 0.01);
  const Recorded rope = RunOfChain("ball", {0, -1, 0}, 100);
  EXPECT_GT(rope.recording.Reals("joint_stretch")[119], 0.02);
  EXPECT_EQ(rope.recording.Reals("joint_bend")[119], 0);
}

TEST(Links, DoNotLetNeighboursCollide) {
  plan::Scene scene = LinkedScene(2, "ball");
  SetGroup(scene, "location", Layout("line", {{"gap", -0.5}}));
  SetGroup(scene, "overlap", true);
  world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  Steps(engine, 5);
  const double apart = (Position(engine, 1) - Position(engine, 0)).norm();
  EXPECT_NEAR(apart, 0.5, 4 * kEpsilon);
  SetGroup(scene, "links.type", Word("none"));
  world::Engine loose = WholeEngine(scene, layouts::MakeInitialState(scene));
  Steps(loose, 5);
  EXPECT_GT((Position(loose, 1) - Position(loose, 0)).norm(), 0.51);
}

TEST(Links, AreRecorded) {
  for (const char* type : {"ball", "spring"}) {
    plan::Scene scene = LinkedScene(4, type);
    SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
    SetWorld(scene, "record", schema::WordList{"stability"});
    SetWorld(scene, "cycles", std::uint64_t{100});
    SetGroup(scene, "links.end_mass", 20.0);
    Recorded recorded = RunHere(scene), again = RunHere(scene);
    ASSERT_TRUE(recorded.done()) << recorded.message();
    EXPECT_EQ(recorded.hash(), again.hash());
    const double gap = recorded.recording.Reals("joint_gap")[99];
    for (std::size_t i = 0; i < 100; ++i) {
      const double motion = recorded.recording.Reals("motion_ratio")[i];
      EXPECT_TRUE(std::isnan(motion) || std::abs(motion - 1) < 1e-3) << motion;
      const double fall = recorded.recording.Reals("fall_ratio")[i];
      EXPECT_TRUE(std::isnan(fall)) << "what is held does not fly freely";
    }
    if (type == std::string("ball")) {
      EXPECT_GT(gap, 0);
      EXPECT_EQ(gap, recorded.engine->links().MeasureGaps().largest);
    } else {
      EXPECT_TRUE(std::isnan(gap));
      // Gravity and springs together.
      const auto energy = recorded.recording.Reals("energy");
      EXPECT_NEAR(energy[99], energy[0], 1e-4 * std::abs(energy[0]));
    }
  }
}

TEST(Links, KeepWhatTheyPullAt) {
  using schema::Component;
  for (const char* type : {"ball", "hinge", "fixed", "spring"}) {
    SCOPED_TRACE(type);
    plan::Scene scene = LinkedScene(5, type);
    SetWorld(scene, "world.walls", Word("all"));
    SetWorld(scene, "sleeping", true);
    SetWorld(scene, "record", schema::WordList{"energy"});
    SetWorld(scene, "cycles", std::uint64_t{200});
    SetWorld(scene, "acceleration", Vector3d(1, -9.8, 0));
    const PairedRun paired = RunPaired(scene);
    for (const Component component : {Component::kWalls, Component::kDetection, Component::kSolver,
                                      Component::kSleeping, Component::kRotation})
      EXPECT_FALSE(paired.Omits(component)) << schema::InfoOf(component).name;
    EXPECT_EQ(paired.why(Component::kSolver), "objects are linked and pull on one another");
  }
}

TEST(Links, NeedTwoPlacesForASpring) {
  plan::Scene scene = LinkedScene(2, "spring");
  SetGroup(scene, "location", Layout("line", {{"gap", -1.0}}));
  SetGroup(scene, "overlap", true);
  EXPECT_THROW(WholeEngine(scene, layouts::MakeInitialState(scene)), library::SceneError);
}

TEST(Links, BetweenFixedObjectsAreNone) {
  plan::Scene scene = LinkedScene(2, "ball");
  layouts::InitialState state = layouts::MakeInitialState(scene);
  for (layouts::ObjectState& object : state.objects) object.mass = 0;
  world::Engine engine = WholeEngine(scene, state);
  Steps(engine, 3);
  EXPECT_FALSE(engine.links().HasJoints());
}

TEST(Jerk, TakesWhatThePivotCannotKeep) {
  // A ball of radius 25 m that moves at 14 m/s without turning, on a pivot at its top: it keeps
  // 5/7, as its moment of inertia about the pivot is 7/5 m r^2.
  plan::Scene scene = EngineScene(1, 500);
  SetGroup(scene, "links.type", Word("ball"));
  SetGroup(scene, "linear_velocity", Vector3d(14, 0, 0));
  world::Engine engine = WholeEngine(scene, OneObjectAt(scene, Vector3d::Zero()));
  EXPECT_NEAR(engine.links().JerkEnergy(), 98.0 * 2 / 7, 1e-4);
  // Bullet's solver takes the same.
  const auto kinetic = [&] {
    const btRigidBody& body = *engine.objects()[0];
    return (body.getLinearVelocity().length2() +
            0.4 * 25 * 25 * body.getAngularVelocity().length2()) /
           2;
  };
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  engine.Step();
  EXPECT_NEAR(static_cast<double>(kinetic()), 98.0 * 5 / 7, 1);
}

TEST(Jerk, TakesAllFromAnObjectBetweenTwoThatAreFixed) {
  // Two pivots on a line through its centre let it turn about the line only, and one of their six
  // equations follows from the others.
  for (const char* joint : {"ball", "hinge", "fixed"}) {
    plan::Scene scene = EngineScene(2, 500);
    SetGroup(scene, "links.type", Word(joint));
    layouts::InitialState state = layouts::DrawObjects(scene);
    state.objects[0].pose.position = {0, 0, 0};
    state.objects[0].linear_velocity = {14, 0, 0};
    state.objects[1].pose.position = {0, -60, 0};
    state.objects[1].mass = 0;
    world::Engine engine = WholeEngine(scene, state);
    EXPECT_NEAR(engine.links().JerkEnergy(), 98, 1e-3) << joint;
  }
}

}  // namespace
}  // namespace cdb::tests
