// Universal joints against closed forms, in both precisions and coordinates.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/runtime/engine/world/joint_scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

class Universal : public InCoordinates {};
INSTANTIATE_TEST_SUITE_P(Joints, Universal, testing::Values("maximal", "reduced"),
                         [](const auto& coordinates) { return std::string(coordinates.param); });

TEST_P(Universal, TurnsAnOutputAsCardanSays) {
  // Two shafts at an angle b, the first one turned by a motor. With the arm of the input in the
  // plane of the shafts at the start, tan(out) = tan(in) / cos(b); with that of the output,
  // tan(out) = tan(in) cos(b).
  constexpr double kAngle = 0.6;
  for (const bool is_input_in_plane : {true, false}) {
    plan::Scene scene = JointScene();
    SetGroup(scene, "size", 0.5);
    SetGroup(scene, "location", PlaceAt(-1, 0, 0));
    const Vector3d along(std::cos(kAngle), std::sin(kAngle), 0);
    const std::size_t output = AddPart(scene, "output", PlaceAt(along.x(), along.y(), 0));
    auto& input = AddJoint(scene, "hinge", "world", "objects", {-1, 0, 0});
    input.Set("joints.axis", Vector3d(1, 0, 0));
    input.Set("joints.motor.velocity", 2.0);
    input.Set("joints.motor.effort", 1e3);
    AddJoint(scene, "hinge", "world", "output", along).Set("joints.axis", along);
    auto& cross = AddJoint(scene, "universal", "objects", "output", {1, 0, 0});
    const Vector3d across(-along.y(), along.x(), 0);
    cross.Set("joints.axis", is_input_in_plane ? Vector3d(0, 1, 0) : Vector3d(0, 0, 1));
    cross.Set("joints.axis2", is_input_in_plane ? Vector3d(0, 0, 1) : across);
    world::Engine engine = EngineOfJoints(scene);
    const double ratio = is_input_in_plane ? 1 / std::cos(kAngle) : std::cos(kAngle);
    const auto turn = [&](std::size_t object, const Vector3d& axis) {
      const Eigen::Quaterniond pose = Orientation(engine, object);
      return 2 * std::atan2(pose.vec().dot(axis), pose.w());
    };
    double fastest = 0, slowest = 1e9;
    for (int n = 1; n <= 960; ++n) {
      engine.Step();
      const double in = turn(0, Vector3d::UnitX()), out = turn(output, along);
      // The angle between the two sides, without the poles of the tangent.
      const double wanted = std::atan2(ratio * std::sin(in), std::cos(in));
      ASSERT_NEAR(std::remainder(out - wanted, 2 * std::numbers::pi), 0, 6e-3) << n;
      const double speed = SpinOf(engine, output).dot(along);
      fastest = std::max(fastest, speed);
      slowest = std::min(slowest, speed);
      ASSERT_LT(engine.links().MeasureGaps().largest, 2e-3) << n;
      ASSERT_LT(engine.links().MeasureGaps().bend, 6e-3) << n;
    }
    // Between cos(b) and 1 / cos(b) times the speed of the input.
    EXPECT_NEAR(fastest, 2 / std::cos(kAngle), 0.02);
    EXPECT_NEAR(slowest, 2 * std::cos(kAngle), 0.02);
  }
}

TEST_P(Universal, SwingsAboutEachAxisAsAPendulum) {
  // A plate at the end of two lengths: T = 2 pi sqrt((I + m l^2) / (m g l)), I about that axis.
  for (const int axis : {0, 1}) {
    plan::Scene scene = JointScene();
    SetWorld(scene, "acceleration", Vector3d(0, 0, -9.8));
    SetGroup(scene, "aspect", schema::Ratio{{2, 0.25, 1}});
    constexpr double kLength = 0.75, kWide[] = {0.25, 2};  // across the axes x and y
    const double inertia = (1 + kWide[axis] * kWide[axis]) / 12 + kLength * kLength;
    auto& joint = AddJoint(scene, "universal", "world", "objects", {0, 0, kLength});
    joint.Set("joints.axis", Vector3d(1, 0, 0));
    joint.Set("joints.axis2", Vector3d(0, 1, 0));
    const double omega = std::sqrt(9.8 * kLength / inertia);
    constexpr double kSwing = 0.02;
    SetGroup(scene, "angular_velocity", Vector3d(kSwing * omega * Vector3d::Unit(axis)));
    SetGroup(scene, "linear_velocity",
             Vector3d((kSwing * omega * Vector3d::Unit(axis)).cross(Vector3d(0, 0, -kLength))));
    world::Engine engine = EngineOfJoints(scene);
    double farthest = 0;
    for (int n = 1; n <= 480; ++n) {
      engine.Step();
      const double angle = 2 * Orientation(engine).vec()[axis];
      farthest = std::max(farthest, std::abs(angle - kSwing * std::sin(omega * n / 240)));
    }
    EXPECT_LT(farthest, 0.05 * kSwing) << axis;
    EXPECT_LT(engine.links().MeasureGaps().largest, 1e-4);
  }
}

TEST_P(Universal, DoesNotTwist) {
  // About the third axis, what it joins turns as one: of the spins w and 0, w / 2 is left.
  plan::Scene scene = JointScene();
  const std::size_t other = AddPart(scene, "other", PlaceAt(0, 0, 2));
  SetGroup(scene, "angular_velocity", Vector3d(0, 0, 2));
  SetGroup(scene, "angular_velocity", Vector3d(0, 0, 0), other);
  auto& joint = AddJoint(scene, "universal", "objects", "other", {0, 0, 1});
  joint.Set("joints.axis", Vector3d(1, 0, 0));
  joint.Set("joints.axis2", Vector3d(0, 1, 0));
  world::Engine engine = EngineOfJoints(scene);
  EXPECT_NEAR(engine.links().JerkEnergy(), IsReduced() ? 0 : kInertiaOfCube, 1e-5);
  Steps(engine, 1);
  EXPECT_NEAR((SpinOf(engine) - Vector3d(0, 0, 1)).norm(), 0, 1e-4);
  EXPECT_NEAR((SpinOf(engine, other) - Vector3d(0, 0, 1)).norm(), 0, 1e-4);
}

TEST_P(Universal, TellsWhenItTwists) {
  plan::Scene scene = JointScene();
  auto& joint = AddJoint(scene, "universal", "world", "objects");
  joint.Set("joints.axis", Vector3d(1, 0, 0));
  joint.Set("joints.axis2", Vector3d(0, 1, 0));
  world::Engine engine = EngineOfJoints(scene);
  const auto bend_at = [&](const Vector3d& axis, double angle) {
    engine.objects()[0]->setWorldTransform(
        btTransform(world::BasisOf(Eigen::AngleAxisd(angle, axis).toRotationMatrix())));
    return engine.links().MeasureGaps().bend;
  };
  EXPECT_NEAR(bend_at(Vector3d::UnitX(), 0.3), 0, 1e-6);
  EXPECT_NEAR(bend_at(Vector3d::UnitY(), 0.3), 0, 1e-6);
  EXPECT_NEAR(bend_at(Vector3d::UnitZ(), 0.3), 0.3, 1e-5);
}

TEST_P(Universal, KeepsTheMomentumOfWhatIsFree) {
  plan::Scene scene = JointScene(960);
  SetGroup(scene, "aspect", schema::Ratio{{0.5, 1, 0.75}});
  AddPart(scene, "other", PlaceAt(0, 1.5, 0));
  SetGroup(scene, "angular_velocity", Vector3d(1, 0.5, 0.25));
  AddJoint(scene, "universal", "objects", "other", {0, 0.75, 0});
  world::Engine engine = EngineOfJoints(scene);
  const Vector3d before = MomentumOf(engine);
  Steps(engine, 960);
  EXPECT_LT((MomentumOf(engine) - before).norm(), 0.01 * before.norm());
  EXPECT_LT(engine.links().MeasureGaps().largest, IsReduced() ? 100 * kEpsilon : 0.01);
  EXPECT_LT(engine.links().MeasureGaps().bend, IsReduced() ? 100 * kEpsilon : 0.01);
}

}  // namespace
}  // namespace cdb::tests
