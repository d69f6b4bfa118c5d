// Joints between groups against closed forms, in both precisions.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "runtime/engine/world/manifolds.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/runtime/engine/paired_run.h"
#include "tests/runtime/engine/world/joint_scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using schema::GroupParameter;

INSTANTIATE_TEST_SUITE_P(Joints, InCoordinates, testing::Values("maximal", "reduced"),
                         [](const auto& coordinates) { return std::string(coordinates.param); });

TEST_P(InCoordinates, HingeIsAPhysicalPendulum) {
  // T = 2 pi sqrt(I / (m g l)): for a thin rod hinged at its end, 2 pi sqrt(2 L / (3 g)).
  plan::Scene scene = JointScene();
  constexpr double kWide = 0.05;
  SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
  SetGroup(scene, "aspect", schema::Ratio{{kWide, 1, kWide}});
  SetGroup(scene, "orientation", Vector3d(0, 0, 0.05));
  AddJoint(scene, "hinge", "objects", "world", {0, 0.5, 0});
  world::Engine engine = EngineOfJoints(scene);
  const double inertia = (1 + kWide * kWide) / 12 + 0.25;
  const double period = 2 * std::numbers::pi * std::sqrt(inertia / (9.8 * 0.5));
  EXPECT_NEAR(period, 2 * std::numbers::pi * std::sqrt(2 / (3 * 9.8)), 1e-3 * period);
  const double middle = -0.5 * std::sin(0.05);
  double last = 0, first = 0, passage = 0;
  int passages = 0;
  for (int n = 1; passages < 6 && n < 4000; ++n) {
    engine.Step();
    const double x = Position(engine).x() - middle;
    if (last < 0 && x >= 0) {
      passage = (n - x / (x - last)) / 240;
      if (passages++ == 0) first = passage;
    }
    last = x;
    EXPECT_LT(engine.links().MeasureGaps().largest, 1e-4);
  }
  ASSERT_EQ(passages, 6);
  EXPECT_NEAR((passage - first) / 5, period, 2e-3 * period);
}

TEST_P(InCoordinates, MotorReachesItsVelocityWithItsEffort) {
  for (const bool turns : {true, false}) {
    plan::Scene scene = JointScene();
    auto& joint = AddJoint(scene, turns ? "hinge" : "slider", "world", "objects");
    joint.Set("joints.axis", Vector3d(0, 3, 0));
    joint.Set("joints.motor.velocity", 2.0);
    joint.Set("joints.motor.effort", 0.5);
    world::Engine engine = EngineOfJoints(scene);
    const auto speed = [&] { return turns ? SpinOf(engine).y() : Velocity(engine).y(); };
    const double rate = 0.5 / (turns ? kInertiaOfCube : 1);
    for (int n = 1; n <= 600; ++n) {
      engine.Step();
      EXPECT_NEAR(speed(), std::min(2.0, rate * n / 240), 1e-5 * n / 10) << turns << " " << n;
    }
    EXPECT_NEAR(speed(), turns ? 2 : 1.25, 1e-5);
    EXPECT_NEAR(SpinOf(engine).norm(), turns ? 2 : 0, 1e-5);
  }
}

TEST_P(InCoordinates, MotorOfTheOtherSideTurnsTheOtherWay) {
  // The velocity is that of the child relative to the parent.
  plan::Scene scene = JointScene();
  auto& joint = AddJoint(scene, "hinge", "objects", "world");
  joint.Set("joints.motor.velocity", 2.0);
  joint.Set("joints.motor.effort", 10.0);
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 100);
  EXPECT_NEAR(SpinOf(engine).z(), -2, 1e-5);
}

TEST_P(InCoordinates, DampingIsThatOfTheIntegrator) {
  for (const bool turns : {true, false}) {
    plan::Scene scene = JointScene();
    AddJoint(scene, turns ? "hinge" : "slider", "world", "objects").Set("joints.damping", 0.25);
    SetGroup(scene, turns ? GroupParameter("angular_velocity") : GroupParameter("linear_velocity"),
             Vector3d(0, 0, 1));
    world::Engine engine = EngineOfJoints(scene);
    double speed = 1;
    for (int n = 1; n <= 200; ++n) {
      engine.Step();
      speed *= 1 - 0.25 / 240 / (turns ? kInertiaOfCube : 1);
      ASSERT_NEAR(turns ? SpinOf(engine).z() : Velocity(engine).z(), speed, 16 * n * kEpsilon);
    }
  }
}

TEST_P(InCoordinates, SliderFallsToItsLimit) {
  plan::Scene scene = JointScene();
  SetWorld(scene, "acceleration", Vector3d(1, -9.8, 2));
  auto& joint = AddJoint(scene, "slider", "world", "objects", {0.5, 3, 0});
  joint.Set("joints.axis", Vector3d(0, 1, 0));
  joint.Set("joints.limits.lower", -0.5);
  joint.Set("joints.limits.upper", 0.25);
  world::Engine engine = EngineOfJoints(scene);
  for (int n = 1; n <= 400; ++n) {
    engine.Step();
    const double fallen = 9.8 * n * (n + 1) / 2 / 240 / 240;
    EXPECT_NEAR(Position(engine).y(), -std::min(fallen, 0.5), 2e-3) << n;
    EXPECT_NEAR(std::hypot(Position(engine).x(), Position(engine).z()), 0, 2e-3);
  }
  EXPECT_NEAR(Velocity(engine).norm(), 0, 1e-3);
  EXPECT_NEAR(Position(engine).y(), -0.5, 1e-4);
}

TEST_P(InCoordinates, HingeStopsAtALimitAfterATurn) {
  plan::Scene scene = JointScene();
  auto& joint = AddJoint(scene, "hinge", "world", "objects");
  joint.Set("joints.limits.lower", -0.5);
  joint.Set("joints.limits.upper", 8.0);
  SetGroup(scene, "angular_velocity", Vector3d(0, 0, 5));
  world::Engine engine = EngineOfJoints(scene);
  for (int n = 1; n <= 600; ++n) {
    engine.Step();
    const double angle = std::min(5.0 * n / 240, 8.0);
    const Eigen::AngleAxisd off(Orientation(engine).conjugate() *
                                Eigen::AngleAxisd(angle, Vector3d::UnitZ()));
    EXPECT_NEAR(off.angle(), 0, 2e-3) << n;
  }
  EXPECT_NEAR(SpinOf(engine).norm(), 0, 1e-4);
  EXPECT_LT(engine.links().MeasureGaps().bend, 1e-3);
}

TEST_P(InCoordinates, JointsCloseAFourBarLoop) {
  // A parallelogram: the bar between the two cranks does not turn.
  plan::Scene scene = JointScene();
  SetWorld(scene, "acceleration", Vector3d(2, -9.8, 0));
  SetGroup(scene, "size", 1.0);
  SetGroup(scene, "aspect", schema::Ratio{{0.1, 1, 0.1}});
  AddPart(scene, "other", PlaceAt(1, 0, 0));
  const std::size_t bar = AddPart(scene, "bar", PlaceAt(0.5, -0.5, 0));
  SetGroup(scene, "orientation", Vector3d(0, 0, std::numbers::pi / 2), bar);
  AddJoint(scene, "hinge", "objects", "world", {0, 0.5, 0});
  AddJoint(scene, "hinge", "other", "world", {0, 0.5, 0});
  AddJoint(scene, "hinge", "objects", "bar", {0, -0.5, 0});
  AddJoint(scene, "hinge", "other", "bar", {0, -0.5, 0});
  world::Engine engine = EngineOfJoints(scene);
  const Eigen::Quaterniond start = Orientation(engine, bar);
  double widest = 0;
  for (int n = 1; n <= 480; ++n) {
    engine.Step();
    widest = std::max(widest, Position(engine, bar).x() - 0.5);
    ASSERT_LT(engine.links().MeasureGaps().largest, 2e-3) << n;
    ASSERT_NEAR(start.angularDistance(Orientation(engine, bar)), 0, 5e-3) << n;
  }
  EXPECT_GT(widest, 0.2);
}

TEST_P(InCoordinates, JointsMoveAsLinksDo) {
  for (const char* type : {"ball", "hinge", "fixed"}) {
    SCOPED_TRACE(type);
    plan::Scene links = JointScene();
    SetWorld(links, "acceleration", Vector3d(3, -9.8, 0));
    plan::Scene joints = links;
    SetGroup(links, "quantity", std::uint64_t{4});
    SetGroup(links, "links.type", Word(type));
    SetGroup(links, "location", Layout("line", {{"gap", 0.5}}));
    const layouts::InitialState state = layouts::MakeInitialState(links);
    std::string before = "world";
    Vector3d pivot = state.objects[0].pose.position + Vector3d(0, 0.75, 0);
    for (std::size_t i = 0; i < 4; ++i) {
      const Vector3d& place = state.objects[i].pose.position;
      const std::string name = i == 0 ? "objects" : "part" + std::to_string(i);
      if (i > 0) AddPart(joints, name, PlaceAt(0, 0, 0));
      SetGroup(joints, "location", PlaceAt(place.x(), place.y(), place.z()), i);
      AddJoint(joints, type, before, name, pivot);
      before = name;
      pivot = {0, -0.75, 0};
    }
    world::Engine one = WholeEngine(links, state), other = EngineOfJoints(joints);
    for (int n = 1; n <= 100; ++n) {
      one.Step();
      other.Step();
    }
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_LT((Position(one, i) - Position(other, i)).norm(), 1e-3) << i;
    EXPECT_GE(std::abs(Position(one, 3).x()), type == std::string("fixed") ? 0 : 0.1);
    const auto gaps = one.links().MeasureGaps(), others = other.links().MeasureGaps();
    EXPECT_NEAR(gaps.largest, others.largest, 1e-3);
    EXPECT_NEAR(gaps.stretch, others.stretch, 1e-3);
    EXPECT_NEAR(gaps.bend, others.bend, 0.05);
  }
}

TEST_P(InCoordinates, JointsTellWhenTheyPart) {
  struct Moved {
    const char* type;
    Vector3d by;    ///< m
    Vector3d turn;  ///< rad
    double gap, bend;
  };
  constexpr double kAngle = 0.25;
  const Moved all[] = {
      {"fixed", {0, 0, 0}, {0, 0, kAngle}, 0, kAngle},
      {"fixed", {0.5, 0, 0}, {0, 0, 0}, 0.5, 0},
      {"slider", {0, 0, 0.5}, {0, 0, 0}, 0, 0},
      {"slider", {0, 0, 3}, {0, 0, 0}, 1, 0},
      {"slider", {0, 0.5, 0}, {0, 0, 0}, 0.5, 0},
      {"slider", {0, 0, 0}, {0, 0, kAngle}, 0, kAngle},
      {"hinge", {0, 0, 0}, {0, 0, kAngle}, 0, 0},
      {"hinge", {0, 0, 0}, {0, 0, 2.5}, 0, 0.5},
      {"hinge", {0, 0, 0}, {kAngle, 0, 0}, 0, kAngle},
      {"ball", {0, 0, 0}, {kAngle, 0, 0}, 0, 0},
  };
  for (const Moved& moved : all) {
    plan::Scene scene = JointScene();
    auto& joint = AddJoint(scene, moved.type, "world", "objects");
    if (moved.type == std::string("hinge") || moved.type == std::string("slider")) {
      joint.Set("joints.limits.lower", -2.0);
      joint.Set("joints.limits.upper", 2.0);
    }
    world::Engine engine = EngineOfJoints(scene);
    const Eigen::AngleAxisd turn(moved.turn.norm(), moved.turn.norm() > 0
                                                        ? moved.turn.normalized().eval()
                                                        : Vector3d::UnitX().eval());
    engine.objects()[0]->setWorldTransform(
        btTransform(world::BasisOf(turn.toRotationMatrix()), ToBullet(moved.by)));
    const auto gaps = engine.links().MeasureGaps();
    EXPECT_NEAR(gaps.largest, moved.gap, 1e-6) << moved.type << moved.by.transpose();
    // Of a fixed joint whose pivot is the centre, the displacement has no arm.
    EXPECT_NEAR(gaps.bend, moved.bend, 1e-3) << moved.type << moved.turn.transpose();
  }
}

TEST_P(InCoordinates, JointsOfAKinematicParentFollowIt) {
  if (IsReduced()) GTEST_SKIP() << "refused";
  plan::Scene scene = JointScene();
  SetGroup(scene, "mass", Word("kinematic"));
  SetGroup(scene, "linear_velocity", Vector3d(1, 0, 0));
  const std::size_t child = AddPart(scene, "child", PlaceAt(0, -1, 0));
  SetGroup(scene, "mass", 1.0, child);
  AddJoint(scene, "fixed", "objects", "child", {0, -0.5, 0});
  world::Engine engine = EngineOfJoints(scene);
  const world::Kinematics kinematics(scene, engine);
  for (std::uint64_t n = 0; n < 240; ++n) {
    kinematics.BeforeStep(n);
    engine.Step();
    kinematics.AfterStep(n);
  }
  EXPECT_NEAR((Position(engine, child) - Vector3d(1, -1, 0)).norm(), 0, 2e-3);
}

TEST_P(InCoordinates, JointsTurnTheFrameOfTheParent) {
  // The parent lies along x; its y is the world's -x, and the child is placed and joined there.
  plan::Scene scene = JointScene();
  SetGroup(scene, "orientation", Vector3d(0, 0, std::numbers::pi / 2));
  const std::size_t child = AddPart(
      scene, "child",
      schema::Call{"relative_to", {Word("objects"), schema::Value(Vector3d(0, -1.5, 0.5))}});
  SetGroup(scene, "orientation", Vector3d(0.5, 0, 0), child);
  auto& joint = AddJoint(scene, "slider", "objects", "child", {0, -0.5, 0});
  joint.Set("joints.axis", Vector3d(0, -1, 0));
  joint.Set("joints.motor.velocity", 1.0);
  joint.Set("joints.motor.effort", 1e4);
  SetGroup(scene, "mass", Word("fixed"));
  SetGroup(scene, "mass", 1.0, child);
  world::Engine engine = EngineOfJoints(scene);
  EXPECT_NEAR((Position(engine, child) - Vector3d(1.5, 0, 0.5)).norm(), 0, 8 * kEpsilon);
  const Eigen::Quaterniond turned = Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(0.5, Vector3d::UnitX());
  EXPECT_NEAR(turned.angularDistance(Orientation(engine, child)), 0, 4 * std::sqrt(kEpsilon));
  Steps(engine, 240);
  EXPECT_NEAR((Position(engine, child) - Vector3d(2.5, 0, 0.5)).norm(), 0, 1e-3);
  EXPECT_NEAR(turned.angularDistance(Orientation(engine, child)), 0, 2e-3);
}

TEST_P(InCoordinates, JointsJoinEachToOneOrToItsOwn) {
  plan::Scene scene = JointScene();
  SetGroup(scene, "mass", Word("fixed"));
  const std::size_t many = AddPart(scene, "many", Layout("line", {{"gap", 1.0}}));
  SetGroup(scene, "quantity", std::uint64_t{3}, many);
  SetGroup(scene, "mass", 1.0, many);
  const std::size_t own =
      AddPart(scene, "own",
              schema::Call{"relative_to", {Word("many"), schema::Value(Vector3d(0, 0, 0.5))}});
  SetGroup(scene, "quantity", std::uint64_t{3}, own);
  SetGroup(scene, "mass", 1.0, own);
  AddJoint(scene, "ball", "many", "own");
  // `own` overlaps `many`, to which it is joined; `objects` overlaps one that it is joined to.
  AddJoint(scene, "ball", "objects", "many");
  AddJoint(scene, "ball", "objects", "own");
  world::Engine engine = EngineOfJoints(scene);
  EXPECT_EQ(engine.world().getNumConstraints(), IsReduced() ? 0 : 9);
  EXPECT_EQ(layouts::JointPairsOf(scene)[1].parent, 2u);
  EXPECT_EQ(layouts::JointPairsOf(scene)[1].child, 5u);
  EXPECT_EQ(layouts::JointPairsOf(scene)[5].parent, 0u);
  EXPECT_EQ(layouts::JointPairsOf(scene)[5].child, 3u);
}

TEST_P(InCoordinates, JointsKeepWhatTheyPullAt) {
  using schema::Component;
  plan::Scene scene = JointScene(60);
  SetWorld(scene, "world.walls", Word("all"));
  SetWorld(scene, "sleeping", true);
  SetWorld(scene, "record", schema::WordList{"energy"});
  SetWorld(scene, "cycles", std::uint64_t{100});
  SetWorld(scene, "acceleration", Vector3d(1, -9.8, 0));
  AddPart(scene, "child", PlaceAt(0, -1.5, 0));
  AddJoint(scene, "hinge", "objects", "child", {0, -0.75, 0});
  const PairedRun paired = RunPaired(scene);
  for (const Component component : {Component::kWalls, Component::kDetection, Component::kSolver,
                                    Component::kSleeping, Component::kRotation})
    EXPECT_FALSE(paired.Omits(component)) << schema::InfoOf(component).name;
}

TEST_P(InCoordinates, JerkTakesWhatASliderCannotKeep) {
  plan::Scene scene = JointScene();
  AddJoint(scene, "slider", "world", "objects");
  SetGroup(scene, "linear_velocity", Vector3d(3, 0, 2));
  world::Engine engine = EngineOfJoints(scene);
  // Reduced coordinates cannot hold such a velocity, so that it is gone at the start.
  EXPECT_NEAR(engine.links().JerkEnergy(), IsReduced() ? 0 : 4.5, 1e-6);
  Steps(engine, 1);
  EXPECT_NEAR(Velocity(engine).z(), 2, 1e-5);
  EXPECT_NEAR(Velocity(engine).x(), 0, 1e-5);
}

/// A chain of bars in free fall that strikes nothing, and turns.
plan::Scene TumblingChain(const plan::Scene& empty) {
  plan::Scene scene = empty;
  SetGroup(scene, "quantity", std::uint64_t{5});
  SetGroup(scene, "aspect", schema::Ratio{{0.2, 1, 0.3}});
  SetGroup(scene, "location", Layout("line", {{"gap", 0.25}}));
  SetGroup(scene, "links.type", Word("ball"));
  SetGroup(scene, "links.anchor", false);
  SetGroup(scene, "angular_velocity", Vector3d(1, 0.5, 0.25));
  return scene;
}

TEST_P(InCoordinates, AFreeChainKeepsItsMomentumAndItsStart) {
  plan::Scene scene = TumblingChain(JointScene(960));
  SetWorld(scene, "precision", Word("double"));
  world::Engine engine = EngineOfJoints(scene);
  const auto momentum = [&] {
    Vector3d sum = Vector3d::Zero();
    for (const auto& body : engine.objects()) {
      const Vector3d spin = ToEigen(body->getAngularVelocity());
      const Eigen::Matrix3d inverse = world::ToEigen(body->getInvInertiaTensorWorld());
      sum +=
          ToEigen(body->getWorldTransform().getOrigin()).cross(ToEigen(body->getLinearVelocity())) +
          inverse.inverse() * spin;
    }
    return sum;
  };
  // The velocities that the joints permit, nearest in kinetic energy, keep all momentum.
  plan::Scene free = scene;
  free.groups[0].settings.Set("links.type", Word("none"));
  const world::Engine loose = EngineOfJoints(free);
  const double drawn = WholeEnergy(loose);
  const Vector3d before = momentum();
  Steps(engine, 1);
  const double jerk = [&] {
    plan::Scene maximal = scene;
    SetWorld(maximal, "coordinates", Word("maximal"));
    return EngineOfJoints(maximal).links().JerkEnergy();
  }();
  EXPECT_GT(jerk, 0.1 * drawn);
  EXPECT_NEAR(WholeEnergy(engine), drawn - jerk, 5e-3 * drawn);
  Steps(engine, 959);
  EXPECT_LT((momentum() - before).norm(), 0.01 * before.norm());
  // Featherstone's joints are exact; constraints leave what a cycle opens.
  EXPECT_LT(engine.links().MeasureGaps().largest, IsReduced() ? 100 * kEpsilon : 0.01);
}

TEST_P(InCoordinates, AMotorTurnsWhateverHingeOfALoopItIsOn) {
  // A parallelogram whose cranks turn at the speed of either motor.
  for (const std::size_t driven : {std::size_t{0}, std::size_t{1}}) {
    plan::Scene scene = JointScene();
    SetGroup(scene, "aspect", schema::Ratio{{0.1, 1, 0.1}});
    AddPart(scene, "other", PlaceAt(1, 0, 0));
    const std::size_t bar = AddPart(scene, "bar", PlaceAt(0.5, -0.5, 0));
    SetGroup(scene, "orientation", Vector3d(0, 0, std::numbers::pi / 2), bar);
    AddJoint(scene, "hinge", "objects", "world", {0, 0.5, 0});
    AddJoint(scene, "hinge", "objects", "bar", {0, -0.5, 0});
    AddJoint(scene, "hinge", "other", "bar", {0, -0.5, 0});
    AddJoint(scene, "hinge", "other", "world", {0, 0.5, 0});
    auto& joint = scene.joints[driven == 0 ? 0 : 3].settings;
    joint.Set("joints.motor.velocity", 2.0);
    joint.Set("joints.motor.effort", 1e3);
    world::Engine engine = EngineOfJoints(scene);
    Steps(engine, 60);
    EXPECT_NEAR(SpinOf(engine).z(), -2, 2e-2) << driven;
    EXPECT_NEAR(SpinOf(engine, 1).z(), -2, 2e-2) << driven;
    EXPECT_LT(engine.links().MeasureGaps().largest, 2e-3);
  }
}

TEST_P(InCoordinates, ABridgeHangsBetweenItsAnchors) {
  plan::Scene scene = JointScene();
  SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
  SetGroup(scene, "aspect", schema::Ratio{{1, 0.2, 0.5}});
  AddPart(scene, "other", PlaceAt(1, 0, 0));
  AddJoint(scene, "ball", "objects", "world", {-0.5, 0, 0});
  AddJoint(scene, "ball", "objects", "other", {0.5, 0, 0});
  AddJoint(scene, "ball", "other", "world", {0.5, 0, 0});
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 240);
  EXPECT_LT(engine.links().MeasureGaps().largest, 5e-3);
  EXPECT_NEAR(Position(engine, 0).y(), 0, 0.05);
  EXPECT_NEAR(Position(engine, 1).y(), 0, 0.05);
}

TEST_P(InCoordinates, FrictionOfASlideTakesWhatItShouldInAnyDirection) {
  // Two plates on a hinge slide on the floor; v^2 = v_0^2 - 2 mu g s.
  for (const double angle : {0.0, 0.7, 0.5 * std::numbers::pi}) {
    plan::Scene scene = JointScene(480);
    SetWorld(scene, "world.walls", Word("floor"));
    SetWorld(scene, "world.side", 20.0);
    SetWorld(scene, "cycles", std::uint64_t{200});
    SetWorld(scene, "record", schema::WordList{"stability", "counts"});
    SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
    SetGroup(scene, "friction", 0.4);
    SetGroup(scene, "aspect", schema::Ratio{{1, 0.1, 1}});
    SetGroup(scene, "location", PlaceAt(0, -9.95, 0));
    const Vector3d velocity(2 * std::cos(angle), 0, 2 * std::sin(angle));
    SetGroup(scene, "linear_velocity", velocity);
    AddPart(scene, "other", PlaceAt(1.05, -9.95, 0));
    AddJoint(scene, "fixed", "objects", "other", {0.525, 0, 0});
    const Recorded run = RunHere(scene);
    ASSERT_TRUE(run.done()) << run.message();
    EXPECT_LT(run.recording.Reals("lost_energy").back(), 0.1) << angle;
  }
}

TEST_P(InCoordinates, WhatStandsOnLegsRests) {
  // Two legs with a motor that holds them, on the floor.
  plan::Scene scene = JointScene();
  SetWorld(scene, "world.walls", Word("floor"));
  SetWorld(scene, "world.side", 4.0);
  SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
  SetGroup(scene, "aspect", schema::Ratio{{1, 0.2, 0.5}});
  SetGroup(scene, "location", PlaceAt(0, -0.9, 0));
  for (const double side : {-1.0, 1.0}) {
    const std::string name = side < 0 ? "left" : "right";
    const std::size_t leg = AddPart(scene, name, PlaceAt(0.4 * side, -1.5, 0));
    SetGroup(scene, "aspect", schema::Ratio{{0.2, 1, 0.5}}, leg);
    auto& joint = AddJoint(scene, "hinge", "objects", name, {0.4 * side, -0.1, 0});
    joint.Set("joints.motor.position", 0.0);
    joint.Set("joints.motor.effort", 50.0);
  }
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 480);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_LT(Velocity(engine, i).norm(), 1e-2) << i;
  EXPECT_NEAR(Position(engine).y(), -0.9, 0.02);
  double carried = 0;
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine.world()))
    for (int i = 0; i < manifold.getNumContacts(); ++i)
      carried += static_cast<double>(manifold.getContactPoint(i).getAppliedImpulse()) * 240;
  EXPECT_NEAR(carried, 3 * 9.8, 0.3);
}

}  // namespace
}  // namespace cdb::tests
