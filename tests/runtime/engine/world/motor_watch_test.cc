// Whether motors miss what they seek: with effort left, without, at limits, in gear and in touch.
#include "runtime/engine/world/motor_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "tests/runtime/engine/world/joint_scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

class MotorMiss : public InCoordinates {
 protected:
  /// The miss after that many steps.
  static std::optional<double> After(world::Engine& engine, world::MotorWatch& watch, int steps) {
    std::optional<double> miss;
    for (int i = 0; i < steps; ++i) {
      engine.Step();
      miss = watch.LargestMiss(engine.world(), 1);
    }
    return miss;
  }
  /// A motor that seeks a velocity.
  static void Drive(plan::GroupSettings& joint, double velocity, double effort) {
    joint.Set("joints.motor.velocity", velocity);
    joint.Set("joints.motor.effort", effort);
  }
};
INSTANTIATE_TEST_SUITE_P(Joints, MotorMiss, testing::Values("maximal", "reduced"),
                         [](const auto& coordinates) { return std::string(coordinates.param); });

TEST_P(MotorMiss, IsNoneWithoutMotors) {
  plan::Scene scene = JointScene();
  AddJoint(scene, "hinge", "world", "objects");
  world::Engine engine = EngineOfJoints(scene);
  EXPECT_EQ(engine.links().WatchMotors(), nullptr);
}

TEST_P(MotorMiss, IsNothingWhereTheMotorReachesItsGoalOrIsSpent) {
  // The efforts: ample, and so small that the wheel speeds up to the end.
  for (const double effort : {1e3, 0.1}) {
    plan::Scene scene = JointScene();
    Drive(AddJoint(scene, "hinge", "world", "objects"), 6, effort);
    world::Engine engine = EngineOfJoints(scene);
    const auto watch = engine.links().WatchMotors();
    ASSERT_NE(watch, nullptr);
    EXPECT_FALSE(watch->LargestMiss(engine.world(), 1)) << "no step yet";
    for (int i = 0; i < 100; ++i) {
      const auto miss = After(engine, *watch, 1);
      ASSERT_TRUE(miss);
      ASSERT_LT(*miss, 1e-4) << effort << " " << i;
    }
    EXPECT_EQ(SpinOf(engine).z() < 1, effort < 1);
  }
}

TEST_P(MotorMiss, IsNothingAtALimitAndOfAPositionThatIsApproached) {
  plan::Scene scene = JointScene();
  plan::GroupSettings& limited = AddJoint(scene, "hinge", "world", "objects");
  Drive(limited, 6, 1e3);
  limited.Set("joints.limits.lower", -1.0);
  limited.Set("joints.limits.upper", 0.5);
  world::Engine engine = EngineOfJoints(scene);
  const auto watch = engine.links().WatchMotors();
  for (int i = 0; i < 100; ++i) ASSERT_LT(After(engine, *watch, 1).value(), 1e-2) << i;
  EXPECT_NEAR(SpinOf(engine).z(), 0, 1e-2) << "it stands at the limit";

  plan::Scene seeking = JointScene();
  plan::GroupSettings& holding = AddJoint(seeking, "hinge", "world", "objects");
  holding.Set("joints.motor.position", 1.0);
  holding.Set("joints.motor.effort", 1e3);
  world::Engine other = EngineOfJoints(seeking);
  const auto other_watch = other.links().WatchMotors();
  for (int i = 0; i < 100; ++i) ASSERT_LT(After(other, *other_watch, 1).value(), 1e-4) << i;
}

TEST_P(MotorMiss, IsThePartOfTheSpeedThatTheSolverLeaves) {
  // A wheel drives one of 100 times its mass at its own speed: in one iteration, the solver cannot.
  plan::Scene scene = JointScene(60);
  SetWorld(scene, "solver.iterations", std::uint64_t{2});
  SetGroup(scene, "mass", 100.0, AddPart(scene, "other", PlaceAt(3, 0, 0)));
  Drive(AddJoint(scene, "hinge", "world", "objects"), 6, 1e5);
  AddJoint(scene, "hinge", "world", "other", {3, 0, 0});
  plan::GroupSettings& gear = scene.joints.back().settings;
  gear.Set("joints.gear.with", Word("joint0"));
  gear.Set("joints.gear.ratio", 1.0);
  // A torque that the motor has to hold against.
  plan::GroupSettings& brake = scene.joints.back().settings;
  brake.Set("joints.damping", 100.0);
  world::Engine engine = EngineOfJoints(scene);
  const auto watch = engine.links().WatchMotors();
  for (int i = 0; i < 60; ++i) {
    const double miss = After(engine, *watch, 1).value();
    EXPECT_NEAR(miss, std::abs(1 - SpinOf(engine).z() / 6), 1e-4) << i;
    if (IsReduced()) {
      EXPECT_GT(miss, 0.3) << i;
    }
  }
}

TEST_P(MotorMiss, IsNotJudgedWhereSomethingTouchesOrMotorsMayContradict) {
  plan::Scene scene = JointScene();
  AddPart(scene, "wall", PlaceAt(0, 0.95, 0));
  SetGroup(scene, "mass", Word("fixed"), 1);
  SetGroup(scene, "overlap", true);
  SetGroup(scene, "overlap", true, 1);
  plan::GroupSettings& slider = AddJoint(scene, "slider", "world", "objects");
  slider.Set("joints.axis", Vector3d(0, 1, 0));
  Drive(slider, 1, 1e3);
  world::Engine engine = EngineOfJoints(scene);
  const auto watch = engine.links().WatchMotors();
  EXPECT_FALSE(After(engine, *watch, 10)) << "it presses on the wall";

  plan::Scene geared = JointScene();
  AddPart(geared, "other", PlaceAt(3, 0, 0));
  Drive(AddJoint(geared, "hinge", "world", "objects"), 1, 1e3);
  plan::GroupSettings& second = AddJoint(geared, "hinge", "world", "other", {3, 0, 0});
  second.Set("joints.gear.with", Word("joint0"));
  second.Set("joints.gear.ratio", 1.0);
  Drive(second, -1, 1e3);
  world::Engine both = EngineOfJoints(geared);
  EXPECT_EQ(both.links().WatchMotors(), nullptr);
}

}  // namespace
}  // namespace cdb::tests
