// Forces and torques on objects, motors that give a torque, and armatures, against closed forms, in
// both coordinates and both precisions.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "library/scene_error.h"
#include "runtime/protocol/verdict.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/runtime/engine/world/joint_scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

constexpr double kStep = 1.0 / 240;

INSTANTIATE_TEST_SUITE_P(Forces, InCoordinates, testing::Values("maximal", "reduced"),
                         [](const auto& coordinates) { return std::string(coordinates.param); });

class TableFile {
 public:
  explicit TableFile(const std::string& text)
      : path_(testing::TempDir() + "cdb_forces_" + world::EnginePrecision() +
              std::to_string(++count_) + ".csv") {
    std::ofstream(path_) << text;
  }
  ~TableFile() { std::filesystem::remove(path_); }
  TableFile(const TableFile&) = delete;
  TableFile& operator=(const TableFile&) = delete;

  schema::Value Table(const char* between = "line", const char* then = "stay") const {
    return Layout(
        "table", {{"file", schema::Text{path_}}, {"between", Word(between)}, {"then", Word(then)}});
  }

 private:
  static inline int count_ = 0;
  std::string path_;
};

/// A cube of 1 m and 1 kg in free space.
plan::Scene FreeCube() {
  plan::Scene scene = EngineScene(1, 1000);
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(scene, "timestep", kStep);
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", 1.0);
  SetGroup(scene, "location", PlaceAt(0, 0, 0));
  return scene;
}

/// Steps with the schedules of the scene.
void StepsOf(const plan::Scene& scene, world::Engine& engine, std::uint64_t count) {
  world::Schedules schedules(scene, engine);
  for (std::uint64_t step = 0; step < count; ++step) {
    schedules.BeforeStep(step);
    engine.Step();
  }
}

TEST(Forces, AForceIsMassTimesAcceleration) {
  plan::Scene scene = FreeCube();
  SetGroup(scene, "mass", 2.0);
  SetGroup(scene, "force", Vector3d(0, 3, -1));
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 240);
  EXPECT_LT((Velocity(engine) - Vector3d(0, 1.5, -0.5)).norm(), 300 * kEpsilon);
  // x = a t (t + dt) / 2, as Bullet integrates.
  EXPECT_LT((Position(engine) - Vector3d(0, 1.5, -0.5) * (1 + kStep) / 2).norm(), 300 * kEpsilon);
  EXPECT_NEAR(engine.Work(), 2 * (1.5 * 1.5 + 0.5 * 0.5) / 2, 1e3 * kEpsilon);
}

TEST(Forces, ATorqueTurnsAFreeInertia) {
  plan::Scene scene = FreeCube();
  SetGroup(scene, "torque", Vector3d(0, 0.5, 0));
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 240);
  EXPECT_NEAR(SpinOf(engine).y(), 0.5 / kInertiaOfCube, 1e-4);
  EXPECT_NEAR(engine.Work(), kInertiaOfCube * std::pow(0.5 / kInertiaOfCube, 2) / 2, 1e-3);
}

TEST(Forces, ObjectsWithAForceDoNotSleep) {
  plan::Scene scene = FreeCube();
  ASSERT_TRUE(scene.world.On("sleeping"));
  // After the two seconds in which Bullet puts bodies to sleep, it is slower than these may be.
  SetGroup(scene, "force", Vector3d(0.05, 0, 0));
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 2400);
  EXPECT_NEAR(Velocity(engine).x(), 0.5, 1e-3);
}

TEST(Forces, FrictionHoldsAForceBelowItAndBrakesAboveIt) {
  for (const double force : {4.0, 6.0}) {
    plan::Scene scene = FreeCube();
    SetWorld(scene, "world.walls", Word("floor"));
    SetWorld(scene, "world.wall_shape", Word("box"));
    SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
    SetGroup(scene, "friction", 1.0);
    SetGroup(scene, "aspect", schema::Ratio{{1, 0.2, 1}});
    SetGroup(scene, "location", PlaceAt(0, -500 + 0.1, 0));
    SetGroup(scene, "force", Vector3d(force, 0, 0));
    world::Engine engine = EngineOfJoints(scene);
    Steps(engine, 480);
    // mu m g = 4.9 N.
    const double due = force > 4.9 ? 2 * (force - 4.9) : 0;
    EXPECT_NEAR(Velocity(engine).x(), due, 0.02 * due + 1e-3) << force;
    if (due == 0) {
      EXPECT_LT(std::abs(Position(engine).x()), 2e-3);
    }
  }
}

TEST(Forces, TablesActInTheMiddleOfEachStep) {
  plan::Scene scene = FreeCube();
  const TableFile push("t [ms],x [N],y,z\n0,0,0,0\n100,1,0,0\n200,0,0,0\n");
  SetGroup(scene, "force", push.Table());
  world::Engine engine = EngineOfJoints(scene);
  StepsOf(scene, engine, 240);
  EXPECT_NEAR(Velocity(engine).x(), 0.1, 1e-5);  // the area of the triangle

  const TableFile blow("t,x,y,z\n0.1,0,5,0\n0.2,0,0,0\n");
  SetGroup(scene, "force", blow.Table("hold"));
  world::Engine second = EngineOfJoints(scene);
  StepsOf(scene, second, 240);
  // Before the first line its value applies; 48 steps begin before 0.2 s.
  EXPECT_NEAR(Velocity(second).y(), 5 * 48 * kStep, 1e-5);

  const TableFile wave("0,0,0,0\n0.1,0,0,1\n0.2,0,0,0\n");
  SetGroup(scene, "force", wave.Table("line", "repeat"));
  world::Engine third = EngineOfJoints(scene);
  StepsOf(scene, third, 240);
  EXPECT_NEAR(Velocity(third).z(), 0.5, 1e-5);
}

TEST(Forces, ATableThatChangedIsRefused) {
  plan::Scene scene = FreeCube();
  const TableFile push("t,x,y,z\n0,0,0,0\n");
  schema::Value table = push.Table();
  std::get<schema::Call>(table).arguments[1] = schema::Text{std::string(64, '0')};
  SetGroup(scene, "force", table);
  EXPECT_THROW(EngineOfJoints(scene), library::SceneError);
}

TEST_P(InCoordinates, AForceActsOnALink) {
  plan::Scene scene = JointScene();
  SetGroup(scene, "force", Vector3d(0, 0, 2));
  AddJoint(scene, "hinge", "objects", "world", {0, 0.5, 0}).Set("joints.axis", Vector3d(1, 0, 0));
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 24);
  // Turned by 0.0024 rad only.
  const double rate = 2 * 0.5 / (kInertiaOfCube + 0.25);
  EXPECT_NEAR(std::abs(SpinOf(engine).x()), 0.1 * rate, 1e-3 * rate);
}

TEST_P(InCoordinates, ATorqueActsOnTheBaseAndOnLinks) {
  // Two cubes in a fixed joint are one body of the inertia 1/6 + 1/6 about x.
  plan::Scene scene = JointScene();
  AddPart(scene, "other", PlaceAt(1, 0, 0));
  SetGroup(scene, "overlap", true);
  scene.groups[1].settings.Set("torque", Vector3d(0.3, 0, 0));
  scene.groups[0].settings.Set("force", Vector3d(2, 0, 0));
  AddJoint(scene, "fixed", "objects", "other", {0.5, 0, 0});
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 240);
  EXPECT_NEAR(SpinOf(engine).x(), 0.3 / (2 * kInertiaOfCube), 1e-3);
  EXPECT_NEAR(Velocity(engine).x(), 1, 1e-3);
}

TEST_P(InCoordinates, AMotorGivesItsTorque) {
  for (const bool turns : {true, false}) {
    plan::Scene scene = JointScene();
    auto& joint = AddJoint(scene, turns ? "hinge" : "slider", "world", "objects");
    joint.Set("joints.axis", Vector3d(0, 3, 0));
    if (turns)
      joint.Set("joints.motor.torque", 0.5);
    else
      joint.Set("joints.motor.force", 0.5);
    world::Engine engine = EngineOfJoints(scene);
    Steps(engine, 240);
    const double rate = 0.5 / (turns ? kInertiaOfCube : 1);
    EXPECT_NEAR(turns ? SpinOf(engine).y() : Velocity(engine).y(), rate, 1e-4 * rate);
    EXPECT_NEAR(engine.Work(), (turns ? kInertiaOfCube : 1) * rate * rate / 2, 1e-3);
  }
}

TEST_P(InCoordinates, AMotorTurnsBothBodies) {
  plan::Scene scene = JointScene();
  AddPart(scene, "other", PlaceAt(0, 1, 0));
  SetGroup(scene, "overlap", true);
  auto& joint = AddJoint(scene, "hinge", "objects", "other", {0, 0.5, 0});
  joint.Set("joints.axis", Vector3d(0, 1, 0));
  joint.Set("joints.motor.torque", 0.25);
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 240);
  EXPECT_NEAR(SpinOf(engine, 0).y(), -0.25 / kInertiaOfCube, 2e-3);
  EXPECT_NEAR(SpinOf(engine, 1).y(), 0.25 / kInertiaOfCube, 2e-3);
  EXPECT_NEAR(WholeEnergy(engine), engine.Work(), 1e-2 * engine.Work());
}

TEST_P(InCoordinates, ATorqueHoldsAPendulumAtAnAngle) {
  // Tilted by 30 degrees about its pivot at the origin, with the centre of mass 0.5 m away.
  plan::Scene scene = JointScene();
  SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
  const double angle = std::numbers::pi / 6;
  SetGroup(scene, "orientation", Vector3d(0, 0, angle));
  SetGroup(scene, "location", PlaceAt(0.5 * std::sin(angle), -0.5 * std::cos(angle), 0));
  auto& joint = AddJoint(scene, "hinge", "world", "objects");
  joint.Set("joints.motor.torque", 9.8 * 0.5 * std::sin(angle));
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 480);
  EXPECT_NEAR(Position(engine).x(), 0.5 * std::sin(angle), 1e-3);
  EXPECT_LT(SpinOf(engine).norm(), 5e-3);
}

TEST_P(InCoordinates, TablesDriveMotors) {
  const TableFile angle("t,q [deg]\n0,0\n1,90\n2,90\n");
  plan::Scene scene = JointScene();
  auto& joint = AddJoint(scene, "hinge", "world", "objects");
  joint.Set("joints.motor.position", angle.Table());
  joint.Set("joints.motor.effort", 1000.0);
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 120);
  // It follows by the error reduction, a fifth of the distance in a step.
  const double rate = std::numbers::pi / 2;
  EXPECT_NEAR(SpinOf(engine).z(), rate, 1e-3);
  Steps(engine, 360);
  const Eigen::AngleAxisd turned(Orientation(engine));
  EXPECT_NEAR(turned.angle(), rate, 1e-3);

  const TableFile torque("t,tau [N m]\n0,0\n1,1\n");
  plan::Scene pushed = JointScene();
  AddJoint(pushed, "hinge", "world", "objects").Set("joints.motor.torque", torque.Table());
  world::Engine second = EngineOfJoints(pushed);
  Steps(second, 240);
  EXPECT_NEAR(SpinOf(second).z(), 0.5 / kInertiaOfCube, 1e-3);
}

/// Armatures are of reduced coordinates.
class Armatures : public InCoordinates {};
INSTANTIATE_TEST_SUITE_P(Joints, Armatures, testing::Values("reduced"),
                         [](const auto& coordinates) { return std::string(coordinates.param); });

TEST_P(Armatures, AddToTheInertiaOfTheJoint) {
  for (const bool turns : {true, false}) {
    plan::Scene scene = JointScene();
    auto& joint = AddJoint(scene, turns ? "hinge" : "slider", "world", "objects");
    if (turns)
      joint.Set("joints.motor.torque", 0.5);
    else
      joint.Set("joints.motor.force", 0.5);
    joint.Set("joints.armature", 1.5);
    world::Engine engine = EngineOfJoints(scene);
    Steps(engine, 240);
    const double inertia = (turns ? kInertiaOfCube : 1) + 1.5, rate = 0.5 / inertia;
    EXPECT_NEAR(turns ? SpinOf(engine).z() : Velocity(engine).x() + Velocity(engine).z(), rate,
                1e-4 * rate);
    EXPECT_NEAR(engine.links().RotorEnergy(), 1.5 * rate * rate / 2, 1e-4);
    EXPECT_NEAR(engine.Work(), inertia * rate * rate / 2, 1e-4);
  }
}

TEST_P(Armatures, SlowAPendulum) {
  // T = 2 pi sqrt((I + m l^2 + a) / (m g l)).
  plan::Scene scene = JointScene();
  SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
  SetGroup(scene, "orientation", Vector3d(0, 0, 0.05));
  AddJoint(scene, "hinge", "objects", "world", {0, 0.5, 0}).Set("joints.armature", 0.7);
  world::Engine engine = EngineOfJoints(scene);
  const double period =
      2 * std::numbers::pi * std::sqrt((kInertiaOfCube + 0.25 + 0.7) / (9.8 * 0.5));
  const double middle = -0.5 * std::sin(0.05);
  double last = 0, first = 0, passage = 0;
  int passages = 0;
  for (int n = 1; passages < 4 && n < 4000; ++n) {
    engine.Step();
    const double x = Position(engine).x() - middle;
    if (last < 0 && x >= 0) {
      passage = (n - x / (x - last)) * kStep;
      if (passages++ == 0) first = passage;
    }
    last = x;
  }
  ASSERT_EQ(passages, 4);
  EXPECT_NEAR((passage - first) / 3, period, 2e-3 * period);
}

TEST_P(Armatures, CoupleTheJointsOfAChainAsLagrangesEquationsSay) {
  // Two cubes that turn about parallel axes through their centres: with the angles q1 of the first
  // and q1 + q2 of the second, both about y, the kinetic energy is I q1'^2 / 2 + I (q1' + q2')^2 /
  // 2
  // + a1 q1'^2 / 2 + a2 q2'^2 / 2, and a torque of the second joint gives
  // (2 I + a1) q1'' + I q2'' = 0, I q1'' + (I + a2) q2'' = T.
  plan::Scene scene = JointScene();
  AddPart(scene, "other", PlaceAt(0, 1, 0));
  SetGroup(scene, "overlap", true);
  auto& base = AddJoint(scene, "hinge", "world", "objects");
  base.Set("joints.axis", Vector3d(0, 1, 0));
  base.Set("joints.armature", 0.4);
  auto& joint = AddJoint(scene, "hinge", "objects", "other", {0, 0.5, 0});
  joint.Set("joints.axis", Vector3d(0, 1, 0));
  joint.Set("joints.armature", 0.9);
  joint.Set("joints.motor.torque", 0.25);
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 240);
  Eigen::Matrix2d inertia;
  inertia << 2 * kInertiaOfCube + 0.4, kInertiaOfCube, kInertiaOfCube, kInertiaOfCube + 0.9;
  const Eigen::Vector2d rates = inertia.inverse() * Eigen::Vector2d(0, 0.25);
  EXPECT_NEAR(SpinOf(engine, 0).y(), rates[0], 1e-4);
  EXPECT_NEAR(SpinOf(engine, 1).y(), rates[0] + rates[1], 1e-4);
}

TEST_P(Armatures, CountForTheEffortOfAMotor) {
  plan::Scene scene = JointScene();
  AddPart(scene, "other", PlaceAt(0, 1, 0));
  SetGroup(scene, "overlap", true);
  AddJoint(scene, "fixed", "world", "objects");
  auto& joint = AddJoint(scene, "hinge", "objects", "other", {0, 0.5, 0});
  joint.Set("joints.axis", Vector3d(0, 1, 0));
  joint.Set("joints.armature", 5.0);
  joint.Set("joints.motor.velocity", 3.0);
  joint.Set("joints.motor.effort", 2.0);
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 120);
  const double rate = 2 / (kInertiaOfCube + 5);
  EXPECT_NEAR(SpinOf(engine, 1).y(), 0.5 * rate, 1e-3 * rate);
  Steps(engine, 2400);
  EXPECT_NEAR(SpinOf(engine, 1).y(), 3, 1e-3);
}

TEST_P(Armatures, MakeALinkHarderToStrike) {
  // A ball strikes a bar on a hinge near its end: with I the inertia about the hinge
  // and a the armature, its effective mass there is (I + a) / r^2.
  plan::Scene scene = JointScene(960);
  SetGroup(scene, "restitution", 1.0);
  SetGroup(scene, "friction", 0.0);
  SetGroup(scene, "aspect", schema::Ratio{{4, 1, 1}});
  SetGroup(scene, "size", 0.25);
  const std::size_t ball = AddPart(scene, "ball", PlaceAt(0.4, 0.5, 0));
  scene.groups[ball].settings.Set("type", Word("sphere"));
  scene.groups[ball].settings.Set("aspect", schema::Ratio{{1, 1, 1}});
  scene.groups[ball].settings.Set("linear_velocity", Vector3d(0, -2, 0));
  AddJoint(scene, "hinge", "world", "objects").Set("joints.armature", 0.3);
  world::Engine engine = EngineOfJoints(scene);
  Steps(engine, 480);
  const double inertia = (1 + 0.0625) / 12, effective = (inertia + 0.3) / (0.4 * 0.4);
  // Bullet loses a part of the rebound, but no momentum about the hinge.
  const double impulse = Velocity(engine, 1).y() + 2;
  EXPECT_GT(impulse, 1);
  EXPECT_NEAR(-0.4 * SpinOf(engine).z() * effective, impulse, 0.01);
}

// What forces and motors do is no gain of energy, and a gain is still seen.

plan::Scene Judged(plan::Scene scene, std::uint64_t cycles) {
  SetWorld(scene, "record", schema::WordList{"counts", "energy", "stability"});
  SetWorld(scene, "cycles", cycles);
  return scene;
}

protocol::Judgement VerdictOf(const plan::Scene& scene) {
  const Recorded run = RunHere(scene);
  EXPECT_TRUE(run.done()) << run.message();
  return protocol::Judge(scene, run.recording, scene.world.Count("cycles"));
}

TEST(Forces, TheirWorkIsNoGain) {
  plan::Scene scene = Judged(FreeCube(), 480);
  SetGroup(scene, "force", Vector3d(5, 0, 0));
  SetGroup(scene, "torque", Vector3d(0, 0, 0.1));
  EXPECT_EQ(protocol::VerdictText(VerdictOf(scene)), "stable");
  // Pushed into a wall, and through air against its weight.
  plan::Scene walled = Judged(FreeCube(), 960);
  SetWorld(walled, "world.walls", Word("all"));
  SetWorld(walled, "world.side", 10.0);
  SetWorld(walled, "acceleration", Vector3d(0, -9.8, 0));
  SetGroup(walled, "force", Vector3d(0, 30, 0));
  EXPECT_EQ(protocol::VerdictText(VerdictOf(walled)), "stable");
}

TEST(Forces, DoNotHideAGain) {
  // A spring too stiff for the time step, of a pushed object.
  plan::Scene scene = Judged(FreeCube(), 30);
  SetGroup(scene, "links.type", Word("spring"));
  SetGroup(scene, "links.stiffness", 2.5e5);
  SetGroup(scene, "force", Vector3d(0, -5, 0));
  EXPECT_EQ(VerdictOf(scene).verdict, protocol::Verdict::kExploded);
}

TEST_P(InCoordinates, TheWorkOfATorqueIsNoGain) {
  plan::Scene scene = Judged(JointScene(), 480);
  SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
  auto& joint = AddJoint(scene, "hinge", "objects", "world", {0, 0.5, 0});
  joint.Set("joints.motor.torque", 3.0);
  EXPECT_EQ(protocol::VerdictText(VerdictOf(scene)), "stable");
  if (!IsReduced()) return;
  joint.Set("joints.armature", 0.5);
  EXPECT_EQ(protocol::VerdictText(VerdictOf(scene)), "stable");
}

}  // namespace
}  // namespace cdb::tests
