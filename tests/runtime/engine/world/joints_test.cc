// Joints between groups against closed forms, in both precisions.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/runtime/engine/engine_fixture.h"
#include "tests/runtime/engine/paired_run.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using schema::GroupParameter;

/// Cuboids of 1 m and 1 kg in free space, without weight; the group `objects` has one at the
/// origin.
plan::Scene JointScene(double rate = 240) {
  plan::Scene scene = EngineScene(1, 1000);
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(scene, "sleeping", false);
  SetWorld(scene, "timestep", 1 / rate);
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", 1.0);
  SetGroup(scene, "location", Layout("at", {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}}));
  return scene;
}

/// A group like the first one, at another place. Returns its index.
std::size_t AddPart(plan::Scene& scene, const std::string& name, const schema::Value& location) {
  scene.groups.push_back({name, scene.groups[0].settings});
  scene.groups.back().settings.Set("location", location);
  return scene.groups.size() - 1;
}

schema::Value PlaceAt(double x, double y, double z) {
  return Layout("at", {{"x", x}, {"y", y}, {"z", z}});
}

plan::GroupSettings& AddJoint(plan::Scene& scene, std::string_view type, std::string_view parent,
                              std::string_view child, const Vector3d& at = Vector3d::Zero()) {
  plan::GroupSettings& settings =
      scene.joints.emplace_back(plan::Joint{"joint" + std::to_string(scene.joints.size()), {}})
          .settings;
  settings.Set("joints.type", Word(type));
  settings.Set("joints.parent", Word(parent));
  settings.Set("joints.child", Word(child));
  settings.Set("joints.at", at);
  return settings;
}

world::Engine EngineOfJoints(const plan::Scene& scene) {
  return WholeEngine(scene, layouts::MakeInitialState(scene));
}

Vector3d SpinOf(const world::Engine& engine, std::size_t object = 0) {
  return ToEigen(engine.objects()[object]->getAngularVelocity());
}

/// Of a cuboid of 1 m and 1 kg, kg m^2.
constexpr double kInertiaOfCube = 1.0 / 6;

TEST(Hinge, IsAPhysicalPendulum) {
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

TEST(Motor, ReachesItsVelocityWithItsEffort) {
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

TEST(Motor, OfTheOtherSideTurnsTheOtherWay) {
  // The velocity is that of the child relative to the parent.
  plan::Scene scene = JointScene();
  auto& joint = AddJoint(scene, "hinge", "objects", "world");
  joint.Set("joints.motor.velocity", 2.0);
  joint.Set("joints.motor.effort", 10.0);
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 100);
  EXPECT_NEAR(SpinOf(engine).z(), -2, 1e-5);
}

TEST(Damping, IsThatOfTheIntegrator) {
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

TEST(Slider, FallsToItsLimit) {
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

TEST(Hinge, StopsAtALimitAfterATurn) {
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

TEST(Joints, CloseAFourBarLoop) {
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

TEST(Joints, MoveAsLinksDo) {
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
    EXPECT_GT(std::abs(Position(one, 3).x()), type == std::string("fixed") ? 0 : 0.1);
    const auto gaps = one.links().MeasureGaps(), others = other.links().MeasureGaps();
    EXPECT_NEAR(gaps.largest, others.largest, 1e-3);
    EXPECT_NEAR(gaps.stretch, others.stretch, 1e-3);
    EXPECT_NEAR(gaps.bend, others.bend, 0.05);
  }
}

TEST(Joints, TellWhenTheyPart) {
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

TEST(Joints, OfAKinematicParentFollowIt) {
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

TEST(Joints, TurnTheFrameOfTheParent) {
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

TEST(Joints, JoinEachToOneOrToItsOwn) {
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
  EXPECT_EQ(engine.world().getNumConstraints(), 9);
  EXPECT_EQ(layouts::JointPairsOf(scene)[1].parent, 2u);
  EXPECT_EQ(layouts::JointPairsOf(scene)[1].child, 5u);
  EXPECT_EQ(layouts::JointPairsOf(scene)[5].parent, 0u);
  EXPECT_EQ(layouts::JointPairsOf(scene)[5].child, 3u);
}

TEST(Joints, KeepWhatTheyPullAt) {
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

TEST(Jerk, TakesWhatASliderCannotKeep) {
  plan::Scene scene = JointScene();
  AddJoint(scene, "slider", "world", "objects");
  SetGroup(scene, "linear_velocity", Vector3d(3, 0, 2));
  world::Engine engine = EngineOfJoints(scene);
  EXPECT_NEAR(engine.links().JerkEnergy(), 4.5, 1e-6);
  Steps(engine, 1);
  EXPECT_NEAR(Velocity(engine).z(), 2, 1e-5);
  EXPECT_NEAR(Velocity(engine).x(), 0, 1e-5);
}

}  // namespace
}  // namespace cdb::tests
