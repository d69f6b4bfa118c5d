// Gears between joints against closed forms, in both precisions and coordinates.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/runtime/engine/world/joint_scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

class Gears : public InCoordinates {};
INSTANTIATE_TEST_SUITE_P(Joints, Gears, testing::Values("maximal", "reduced"),
                         [](const auto& coordinates) { return std::string(coordinates.param); });

/// Couples the last joint to another.
void GearWith(plan::Scene& scene, const std::string& name, double ratio) {
  plan::GroupSettings& settings = scene.joints.back().settings;
  settings.Set("joints.gear.with", Word(name));
  settings.Set("joints.gear.ratio", ratio);
}

void SetMotor(plan::GroupSettings& joint, double velocity, double effort) {
  joint.Set("joints.motor.velocity", velocity);
  joint.Set("joints.motor.effort", effort);
}

TEST_P(Gears, OfTwoFlywheelsShareATorque) {
  // T = (I_1 + r^2 I_2) dw_1/dt and w_2 = r w_1; the energy is the work of the torque.
  constexpr double kTorque = 0.5;
  for (const double ratio : {-0.5, 3.0}) {
    plan::Scene scene = JointScene();
    const std::size_t other = AddPart(scene, "other", PlaceAt(3, 0, 0));
    SetGroup(scene, "mass", 2.0, other);
    SetMotor(AddJoint(scene, "hinge", "world", "objects"), 1e3, kTorque);
    AddJoint(scene, "hinge", "world", "other", {3, 0, 0});
    GearWith(scene, "joint0", ratio);
    world::Engine engine = EngineOfJoints(scene);
    const double inertia = kInertiaOfCube * (1 + 2 * ratio * ratio);
    double work = 0;
    for (int n = 1; n <= 480; ++n) {
      const double before = SpinOf(engine).z();
      engine.Step();
      const double after = SpinOf(engine).z(), wanted = kTorque / inertia * n / 240;
      work += kTorque * (before + after) / 2 / 240;
      ASSERT_NEAR(after, wanted, 1e-4 * (1 + wanted)) << ratio << " " << n;
      ASSERT_NEAR(SpinOf(engine, other).z(), ratio * wanted, 1e-4 * (1 + 3 * wanted)) << n;
      ASSERT_LT(engine.links().MeasureGaps().bend, 2e-5) << n;
    }
    const double energy = kInertiaOfCube *
                          (SpinOf(engine).squaredNorm() + 2 * SpinOf(engine, other).squaredNorm()) /
                          2;
    EXPECT_NEAR(energy, work, 1e-4 * work) << ratio;
    EXPECT_GT(SpinOf(engine).z(), 0.1) << "several turns, or a part of one";
  }
}

TEST_P(Gears, OnACarrierThatIsFreeKeepMomentum) {
  // Two wheels on one axis of a body that nothing holds. With the spin w of the first wheel against
  // the carrier: w_c = -(I_1 + r I_2) w / (I_c + I_1 + I_2), and the torque of the motor moves
  // I_1 + r^2 I_2 - (I_1 + r I_2)^2 / (I_c + I_1 + I_2). A gear that ignored the carrier would give
  // it no torque back.
  constexpr double kRatio = -2, kTorque = 0.25;
  plan::Scene scene = JointScene();
  const std::size_t first = AddPart(scene, "first", PlaceAt(0, 0, 1.5)),
                    second = AddPart(scene, "second", PlaceAt(0, 0, -1.5));
  SetGroup(scene, "mass", 3.0);
  SetMotor(AddJoint(scene, "hinge", "objects", "first", {0, 0, 1}), 1e3, kTorque);
  AddJoint(scene, "hinge", "objects", "second", {0, 0, -1});
  GearWith(scene, "joint0", kRatio);
  world::Engine engine = EngineOfJoints(scene);
  const double i = kInertiaOfCube, both = i * (1 + kRatio), all = 5 * i;
  const double effective = i * (1 + kRatio * kRatio) - both * both / all;
  for (int n = 1; n <= 240; ++n) {
    engine.Step();
    const double spin = kTorque / effective * n / 240, carrier = -both / all * spin;
    ASSERT_NEAR(SpinOf(engine).z(), carrier, 2e-4 * (1 + spin)) << n;
    ASSERT_NEAR(SpinOf(engine, first).z(), carrier + spin, 2e-4 * (1 + spin)) << n;
    ASSERT_NEAR(SpinOf(engine, second).z(), carrier + kRatio * spin, 4e-4 * (1 + spin)) << n;
    ASSERT_LT(engine.links().MeasureGaps().bend, 1e-4) << n;
  }
  EXPECT_NEAR(MomentumOf(engine).norm(), 0, 2e-4);
}

TEST_P(Gears, MakeARackAndAPinion) {
  // The rack falls by g m / (m + I / r^2), r in m/rad.
  constexpr double kRadius = 0.25, kWeight = 9.8;
  plan::Scene scene = JointScene();
  SetWorld(scene, "acceleration", Vector3d(0, -kWeight, 0));
  const std::size_t rack = AddPart(scene, "rack", PlaceAt(2, 0, 0));
  AddJoint(scene, "hinge", "world", "objects");
  AddJoint(scene, "slider", "world", "rack", {2, 0, 0}).Set("joints.axis", Vector3d(0, 1, 0));
  GearWith(scene, "joint0", kRadius);
  world::Engine engine = EngineOfJoints(scene);
  const double rate = kWeight / (1 + kInertiaOfCube / (kRadius * kRadius));
  for (int n = 1; n <= 240; ++n) {
    engine.Step();
    const double fallen = rate * n * (n + 1) / 2 / 240 / 240;
    ASSERT_NEAR(Position(engine, rack).y(), -fallen, 2e-4 * (1 + fallen)) << n;
    ASSERT_NEAR(SpinOf(engine).z(), Velocity(engine, rack).y() / kRadius, 1e-3 * n / 24) << n;
    ASSERT_LT(engine.links().MeasureGaps().largest, 1e-4) << n;
  }
}

TEST_P(Gears, DriveOneAnotherInATrain) {
  // The third turns at r_1 r_2 times the first, whichever has the motor.
  for (const std::size_t driven : {std::size_t{0}, std::size_t{2}}) {
    plan::Scene scene = JointScene();
    for (const int i : {1, 2}) AddPart(scene, "wheel" + std::to_string(i), PlaceAt(3 * i, 0, 0));
    AddJoint(scene, "hinge", "world", "objects");
    AddJoint(scene, "hinge", "world", "wheel1", {3, 0, 0});
    GearWith(scene, "joint0", -0.5);
    AddJoint(scene, "hinge", "world", "wheel2", {6, 0, 0});
    GearWith(scene, "joint1", -3);
    SetMotor(scene.joints[driven].settings, 6, 100);
    world::Engine engine = EngineOfJoints(scene);
    Steps(engine, 240);
    const double first = driven == 0 ? 6 : 4;
    EXPECT_NEAR(SpinOf(engine, 0).z(), first, 1e-2) << driven;
    EXPECT_NEAR(SpinOf(engine, 1).z(), -0.5 * first, 1e-2) << driven;
    EXPECT_NEAR(SpinOf(engine, 2).z(), 1.5 * first, 1e-2) << driven;
    EXPECT_LT(engine.links().MeasureGaps().bend, 1e-2);
  }
}

TEST_P(Gears, OfPairsAreEachTheirOwn) {
  plan::Scene scene = JointScene();
  SetGroup(scene, "quantity", std::uint64_t{2});
  SetGroup(scene, "location", Layout("line", {{"gap", 1.0}}));
  const std::size_t others =
      AddPart(scene, "others",
              schema::Call{"relative_to", {Word("objects"), schema::Value(Vector3d(0, 0, 3))}});
  SetGroup(scene, "quantity", std::uint64_t{2}, others);
  AddJoint(scene, "hinge", "objects", "world");
  AddJoint(scene, "hinge", "others", "world");
  GearWith(scene, "joint0", -1);
  plan::Scene driven = scene;
  SetMotor(driven.joints[0].settings, 2, 10);
  world::Engine all = EngineOfJoints(driven);
  Steps(all, 100);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(SpinOf(all, i).z(), i < 2 ? -2 : 2, 1e-2) << "of the world, the child";
  if (IsReduced()) return;  // where the state is that of the trees
  world::Engine engine = EngineOfJoints(scene);
  engine.objects()[0]->setAngularVelocity({0, 0, 2});
  Steps(engine, 100);
  EXPECT_NEAR(SpinOf(engine, 0).z(), 1, 1e-3);
  EXPECT_NEAR(SpinOf(engine, 2).z(), -1, 1e-3);
  EXPECT_NEAR(SpinOf(engine, 1).norm(), 0, 1e-6);
  EXPECT_NEAR(SpinOf(engine, 3).norm(), 0, 1e-6);
}

TEST_P(Gears, TellWhenTheySlip) {
  plan::Scene scene = JointScene();
  AddPart(scene, "other", PlaceAt(3, 0, 0));
  AddJoint(scene, "hinge", "world", "objects");
  AddJoint(scene, "hinge", "world", "other", {3, 0, 0});
  GearWith(scene, "joint0", -2);
  world::Engine engine = EngineOfJoints(scene);
  EXPECT_EQ(engine.links().MeasureGaps().bend, 0);
  btTransform turned = engine.objects()[1]->getWorldTransform();
  turned.setRotation(btQuaternion(btVector3(0, 0, 1), btScalar(0.5)));
  engine.objects()[1]->setWorldTransform(turned);
  EXPECT_NEAR(engine.links().MeasureGaps().bend, 0.5, 1e-5);
  turned = engine.objects()[0]->getWorldTransform();
  turned.setRotation(btQuaternion(btVector3(0, 0, 1), btScalar(-0.25)));
  engine.objects()[0]->setWorldTransform(turned);
  EXPECT_NEAR(engine.links().MeasureGaps().bend, 0, 1e-5);
}

TEST_P(Gears, TakeWhatTheStartContradicts) {
  // Of w and 0 with equal inertias and the ratio 1, half of the energy: I w^2 / 4.
  plan::Scene scene = JointScene();
  const std::size_t other = AddPart(scene, "other", PlaceAt(3, 0, 0));
  SetGroup(scene, "angular_velocity", Vector3d(0, 0, 2));
  SetGroup(scene, "angular_velocity", Vector3d(0, 0, 0), other);
  AddJoint(scene, "hinge", "world", "objects");
  AddJoint(scene, "hinge", "world", "other", {3, 0, 0});
  GearWith(scene, "joint0", 1);
  world::Engine engine = EngineOfJoints(scene);
  EXPECT_NEAR(engine.links().JerkEnergy(), kInertiaOfCube, 1e-5);
  Steps(engine, 1);
  EXPECT_NEAR(SpinOf(engine).z(), 1, 1e-4);
  EXPECT_NEAR(SpinOf(engine, other).z(), 1, 1e-4);
}

}  // namespace
}  // namespace cdb::tests
