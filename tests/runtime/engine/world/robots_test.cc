// Robots in the engine, and what joints have for them: positions at the start, friction, motors
// that hold, and damping that is larger than a step allows.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "compiler/compile.h"
#include "library/robots/reader.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

plan::Scene RobotScene(const std::string& text) {
  compiler::CompileOptions options;
  options.read_robot = robots::ReadRobot;
  const std::string path = (SourceFolder() / "examples/test.cdb").string();
  const compiler::Compilation compiled = compiler::Compile(
      path,
      [&](const std::string& file, std::string& why) -> std::optional<std::string> {
        if (file == path) return "benchmark b { world.side 20\n" + text + "\n}";
        return compiler::ReadFromDisk(file, why);
      },
      options);
  EXPECT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
  plan::Scene scene = compiled.plans.at(0).runs.at(0).scene;
  SetWorld(scene, "precision", Word(world::EnginePrecision()));
  SetWorld(scene, "sleeping", false);
  return scene;
}

/// Of all objects, with 0 at the height of the origin, J.
double EnergyOf(const world::Engine& engine) {
  double energy = 0;
  for (const auto& body : engine.objects()) {
    if (body->isStaticOrKinematicObject()) continue;
    const double mass = 1 / static_cast<double>(body->getInvMass());
    const Vector3d velocity = ToEigen(body->getLinearVelocity());
    const Vector3d spin = ToEigen(body->getWorldTransform().getBasis()).transpose() *
                          ToEigen(body->getAngularVelocity());
    const Vector3d inertia = ToEigen(body->getInvInertiaDiagLocal()).cwiseInverse();
    energy += mass * velocity.squaredNorm() / 2 + spin.cwiseAbs2().dot(inertia) / 2 +
              mass * 9.8 * ToEigen(body->getWorldTransform().getOrigin()).y();
  }
  return energy;
}

class RobotsInTheEngine : public ::testing::Test {
 protected:
  void SetUp() override {
    if (robots::HasReader(robots::Format::kUrdf)) return;
    std::cout << "skipped: needs liburdfdom-dev (./setup --import)\n";
    GTEST_SKIP();
  }
};

TEST_F(RobotsInTheEngine, AnArmSwingsWithItsEnergy) {
  // It falls from near its highest pose, through 2 s, without anything that takes energy.
  plan::Scene scene = RobotScene(
      "timestep 1/960; robot arm { file \"arm.urdf\"; location at(0, 0, 0); positions { shoulder "
      "0.4; elbow 0.3; wrist 0.05 } }\n"
      "shoulder.damping 0; shoulder.friction 0");
  for (plan::Joint& joint : scene.joints)
    for (const auto limit : std::initializer_list<schema::GroupParameter>{"joints.limits.lower",
                                                                          "joints.limits.upper"})
      joint.settings.Set(limit, Word("none"));
  scene.joints[2].settings.Set("joints.type", Word("fixed"));
  world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  const double start = EnergyOf(engine);
  double least = 1e9, most = -1e9, height = Position(engine, 3).y();
  for (int n = 0; n < 2 * 960; ++n) {
    engine.Step();
    least = std::min(least, EnergyOf(engine));
    most = std::max(most, EnergyOf(engine));
    height = std::min(height, Position(engine, 3).y());
    ASSERT_LT(engine.links().MeasureGaps().largest, 2e-3) << n;
  }
  EXPECT_LT(height, 0.3) << "the hand swings through";
  // The fall of the masses is some 25 J.
  EXPECT_LT(most - start, 0.25);
  EXPECT_LT(start - least, 0.5);
}

TEST_F(RobotsInTheEngine, HoldKeepsThePositions) {
  const plan::Scene scene = RobotScene(
      "timestep 1/240; robot arm { file \"arm.urdf\"; location at(0, 0, 0); hold on; positions { "
      "shoulder 0.5; elbow 1 } }");
  world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  std::vector<Vector3d> places;
  for (std::size_t i = 0; i < engine.objects().size(); ++i) places.push_back(Position(engine, i));
  Steps(engine, 480);
  for (std::size_t i = 0; i < places.size(); ++i)
    EXPECT_LT((Position(engine, i) - places[i]).norm(), 5e-3) << i;
}

TEST_F(RobotsInTheEngine, ACartDrives) {
  const plan::Scene scene = RobotScene(
      "timestep 1/240; robot cart { file \"cart.urdf\"; location at(0, -10, 0) }\n"
      "body.friction 0\n"
      "left_axle.motor.velocity 5; left_axle.motor.effort 2\n"
      "right_axle.motor.velocity 5; right_axle.motor.effort 2");
  world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  Steps(engine, 240);
  const double at_one_second = Position(engine).x();
  Steps(engine, 240);
  // Wheels of 0.1 m at 5 rad/s; x is forward.
  EXPECT_NEAR(Position(engine).x() - at_one_second, 0.5, 0.01);
  EXPECT_NEAR(Position(engine).z(), 0, 0.01);
}

/// A cuboid of 1 m and 1 kg on a joint to the world, turning at 1 rad/s about z.
plan::Scene SpinningLinkScene(schema::GroupParameter parameter, double value) {
  plan::Scene scene = EngineScene(1, 100);
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(scene, "sleeping", false);
  SetWorld(scene, "timestep", 1.0 / 240);
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", 1.0);
  SetGroup(scene, "angular_velocity", Vector3d(0, 0, 1));
  SetGroup(scene, "location", Layout("at", {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}}));
  plan::GroupSettings& joint = scene.joints.emplace_back(plan::Joint{"axle", {}}).settings;
  joint.Set("joints.parent", Word("world"));
  joint.Set("joints.child", Word("objects"));
  joint.Set(parameter, value);
  return scene;
}

double SpinAfter(const plan::Scene& scene, int steps) {
  world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  Steps(engine, steps);
  return ToEigen(engine.objects()[0]->getAngularVelocity()).z();
}

TEST(Damping, OfAnySizeStopsTheMotion) {
  for (const double damping : {39.0, 41.0, 100.0, 1e6})
    EXPECT_NEAR(SpinAfter(SpinningLinkScene("joints.damping", damping), 30), 0, 1e-4) << damping;
}

TEST(Friction, TakesAConstantTorque) {
  // A moment of inertia of 1/6 kg m^2, and 0.1 N m.
  EXPECT_NEAR(SpinAfter(SpinningLinkScene("joints.friction", 0.1), 240 / 4), 1 - 0.1 * 6 / 4, 1e-3);
  EXPECT_NEAR(SpinAfter(SpinningLinkScene("joints.friction", 0.1), 2 * 240), 0, 1e-6);
}

}  // namespace
}  // namespace cdb::tests
