// No parameter is silently ignored: each row of the schema that concerns the engine has a scene in
// which changing it changes the final state.
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "compiler/schema/catalogue.h"
#include "compiler/schema/schema.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

/// Objects of all shapes that move in a small cube and touch each other.
plan::Scene CrowdScene() {
  plan::Scene scene = EngineScene(40, 280);
  SetWorld(scene, "cycles", std::uint64_t{150});
  SetWorld(scene, "acceleration", Vector3d(0, -98, 0));
  SetGroup(scene, "type", AnyType());
  SetGroup(scene, "linear_velocity", Normal(0.0, 60.0));
  SetGroup(scene, "angular_velocity", Normal(0.0, 1.0));
  return scene;
}

/// One fast ball between thin walls.
plan::Scene BulletScene() {
  plan::Scene scene = EngineScene(1, 500);
  SetWorld(scene, "world.wall_shape", Word("box"));
  SetGroup(scene, "linear_velocity", Vector3d(20000, 100, 0));
  return scene;
}

using Change = std::function<void(plan::Scene&)>;
/// A scene, and by parameter a change of it.
struct Variations {
  plan::Scene scene;
  std::map<std::string, Change> changes;
};

Change World(schema::WorldParameter name, schema::Value value) {
  return [=](plan::Scene& scene) { SetWorld(scene, name, value); };
}
Change Objects(schema::GroupParameter name, schema::Value value) {
  return [=](plan::Scene& scene) { SetGroup(scene, name, value); };
}

Change Joints(schema::GroupParameter name, schema::Value value) {
  return [=](plan::Scene& scene) { scene.joints[0].settings.Set(name, value); };
}

plan::Scene With(plan::Scene scene, const Change& change) {
  change(scene);
  return scene;
}

std::vector<Variations> AllVariations() {
  const plan::Scene crowd = CrowdScene();
  const plan::Scene resting = [] {
    // It rolls so slowly that it would fall asleep.
    plan::Scene scene = EngineScene(1, 500);
    SetWorld(scene, "cycles", std::uint64_t{400});
    SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
    SetGroup(scene, "linear_velocity", Vector3d(0.1, 0, 0));
    return scene;
  }();
  const plan::Scene chain = [] {
    plan::Scene scene = EngineScene(5, 500);
    SetWorld(scene, "cycles", std::uint64_t{50});
    SetGroup(scene, "size", 5.0);
    SetGroup(scene, "location", Layout("line", {}));
    SetGroup(scene, "links.type", Word("spring"));
    return scene;
  }();
  const plan::Scene arm = [] {
    plan::Scene scene = EngineScene(1, 500);
    SetWorld(scene, "cycles", std::uint64_t{50});
    SetGroup(scene, "location", Layout("at", {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}}));
    SetGroup(scene, "angular_velocity", Vector3d(1, 0, 2));
    scene.groups.push_back({"lower", scene.groups[0].settings});
    SetGroup(scene, "location", Layout("at", {{"x", 0.0}, {"y", -60.0}, {"z", 0.0}}), 1);
    SetGroup(scene, "angular_velocity", Vector3d(0, 0, 0), 1);
    scene.joints.push_back({"elbow", {}});
    scene.joints[0].settings.Set("joints.parent", Word("objects"));
    scene.joints[0].settings.Set("joints.child", Word("lower"));
    return scene;
  }();
  const plan::Scene limited = [&] {
    plan::Scene scene = arm;
    scene.joints[0].settings.Set("joints.limits.lower", -0.25);
    scene.joints[0].settings.Set("joints.limits.upper", 0.25);
    scene.joints[0].settings.Set("joints.motor.velocity", 1.0);
    scene.joints[0].settings.Set("joints.motor.effort", 1e3);
    return scene;
  }();
  const plan::Scene pair = [&] {
    plan::Scene scene = arm;
    scene.joints.push_back({"shoulder", {}});
    scene.joints[1].settings.Set("joints.child", Word("objects"));
    scene.joints[1].settings.Set("joints.at", Vector3d(0, 60, 0));
    return scene;
  }();
  const plan::Scene geared = With(pair, Joints("joints.gear.with", Word("shoulder")));
  const plan::Scene bent = [&] {
    plan::Scene scene = arm;
    SetGroup(scene, "location",
             Layout("relative_to", {{"group", Word("objects")}, {"offset", Vector3d(0, -60, 0)}}),
             1);
    return scene;
  }();
  const plan::Scene held = [&] {
    plan::Scene scene = arm;
    scene.joints[0].settings.Set("joints.motor.position", 0.0);
    scene.joints[0].settings.Set("joints.motor.effort", 1e3);
    return scene;
  }();
  const plan::Scene rounded = With(crowd, Objects("type", Word("superellipsoid")));
  plan::Scene pouring = EngineScene(20, 40);
  SetWorld(pouring, "world.walls", Word("none"));
  SetWorld(pouring, "cycles", std::uint64_t{60});
  SetGroup(pouring, "size", 2.0);
  SetGroup(pouring, "spawn.batch", std::uint64_t{2});
  SetGroup(pouring, "spawn.every", std::uint64_t{3});
  SeedStreams(pouring);
  return {
      {rounded, {{"objects.e1", Objects("e1", 0.4)}, {"objects.e2", Objects("e2", 1.6)}}},
      {arm,
       {
           {"joints.parent", Joints("joints.parent", Word("world"))},
           {"joints.child", Joints("joints.child", Word("world"))},
           {"joints.type", Joints("joints.type", Word("ball"))},
           {"joints.at", Joints("joints.at", Vector3d(0, -30, 0))},
           {"joints.axis", Joints("joints.axis", Vector3d(1, 0, 0))},
           {"joints.damping", Joints("joints.damping", 10.0)},
           {"joints.motor.torque", Joints("joints.motor.torque", 10.0)},
           {"joints.friction", Joints("joints.friction", 10.0)},
       }},
      {With(arm, World("sleeping", false)),
       {{"coordinates", World("coordinates", Word("reduced"))}}},
      {With(With(arm, World("sleeping", false)), World("coordinates", Word("reduced"))),
       {{"joints.armature", Joints("joints.armature", 0.5)}}},
      {With(arm, Joints("joints.type", Word("slider"))),
       {{"joints.motor.force", Joints("joints.motor.force", 10.0)}}},
      {pair, {{"joints.gear.with", Joints("joints.gear.with", Word("shoulder"))}}},
      {geared, {{"joints.gear.ratio", Joints("joints.gear.ratio", -2.0)}}},
      {With(arm, Joints("joints.type", Word("universal"))),
       {{"joints.axis2", Joints("joints.axis2", Vector3d(0, 1, 0))}}},
      {bent, {{"joints.start", Joints("joints.start", 0.5)}}},
      {held, {{"joints.motor.position", Joints("joints.motor.position", 0.5)}}},
      {limited,
       {
           {"joints.limits.lower", Joints("joints.limits.lower", -0.125)},
           {"joints.limits.upper", Joints("joints.limits.upper", 0.125)},
           {"joints.motor.velocity", Joints("joints.motor.velocity", -1.0)},
           {"joints.motor.effort", Joints("joints.motor.effort", 10.0)},
       }},
      {crowd,
       {
           {"cycles", World("cycles", std::uint64_t{151})},
           {"warmup", World("warmup", std::uint64_t{1})},
           {"acceleration", World("acceleration", Vector3d(0, -99, 0))},
           {"world.side", World("world.side", 281.0)},
           {"world.walls", World("world.walls", Word("floor"))},
           {"world.wall_shape", World("world.wall_shape", Word("box"))},
           {"world.wall_friction", World("world.wall_friction", 0.4)},
           {"timestep", World("timestep", 1.0 / 61)},
           {"detector", World("detector", Word("sap32"))},
           {"pair_order", World("pair_order", Word("sorted"))},
           {"contact", World("contact", Word("faithful"))},
           {"solver.iterations", World("solver.iterations", std::uint64_t{11})},
           {"solver.erp", World("solver.erp", 0.3)},
           {"solver.warm_start", World("solver.warm_start", 0.0)},
           {"objects.quantity", Objects("quantity", std::uint64_t{41})},
           {"objects.type", Objects("type", Word("cone"))},
           {"objects.aspect", Objects("aspect", schema::Ratio{{1, 1, 1.1}})},
           {"objects.location", Objects("location", Word("normal"))},
           {"objects.region",
            Objects("region",
                    schema::Call{"box", {Vector3d::Constant(-140), Vector3d(140, 140, 130)}})},
           {"objects.size", Objects("size", 49.0)},
           {"objects.mass", Objects("mass", Uniform(1.0, 9.0))},
           {"objects.force", Objects("force", Vector3d(1, 0, 0))},
           {"objects.torque", Objects("torque", Vector3d(1, 0, 0))},
           {"objects.linear_velocity", Objects("linear_velocity", Vector3d(1, 0, 0))},
           {"objects.angular_velocity", Objects("angular_velocity", Vector3d(1, 0, 0))},
           {"objects.friction", Objects("friction", 0.4)},
           {"objects.rolling_friction", Objects("rolling_friction", 0.1)},
           {"objects.restitution", Objects("restitution", 0.5)},
           {"objects.linear_damping", Objects("linear_damping", 0.1)},
           {"objects.angular_damping", Objects("angular_damping", 0.1)},
           {"objects.margin", Objects("margin", 0.5)},
           {"objects.contact_stiffness", Objects("contact_stiffness", 5000.0)},
           {"objects.collides_with", Objects("collides_with", schema::WordList{"walls"})},
           {"objects.orientation", Objects("orientation", Word("random"))},
       }},
      {With(crowd, Objects("restitution", 0.5)),
       {{"world.wall_restitution", World("world.wall_restitution", 0.5)}}},
      {With(crowd, Objects("rolling_friction", 0.1)),
       {{"objects.spinning_friction", Objects("spinning_friction", 0.1)}}},
      {resting, {{"sleeping", World("sleeping", false)}}},
      {With(crowd, Objects("contact_stiffness", 5000.0)),
       {{"objects.contact_damping", Objects("contact_damping", 30.0)}}},
      {BulletScene(), {{"objects.ccd", Objects("ccd", true)}}},
      {pouring,
       {
           {"objects.spawn.batch", Objects("spawn.batch", std::uint64_t{3})},
           {"objects.spawn.every", Objects("spawn.every", std::uint64_t{5})},
           {"objects.spawn.start", Objects("spawn.start", std::uint64_t{9})},
           {"objects.remove.below", Objects("remove.below", -5.0)},
           {"objects.remove.outside",
            Objects("remove.outside",
                    schema::Call{"box", {Vector3d::Constant(-9), Vector3d::Constant(9)}})},
           {"objects.remove.after", Objects("remove.after", std::uint64_t{20})},
       }},
      {chain,
       {
           {"objects.links.type", Objects("links.type", Word("ball"))},
           {"objects.links.stiffness", Objects("links.stiffness", 900.0)},
           {"objects.links.damping", Objects("links.damping", 1.0)},
           {"objects.links.anchor", Objects("links.anchor", false)},
           {"objects.links.end_mass", Objects("links.end_mass", 2.0)},
       }},
  };
}

/// Rows that must not change the final state, and the reason.
const std::map<std::string, std::string> kNotTheEngines = {
    {"seed", "is in the plan's stream seeds"},
    {"precision", "chooses the worker"},
    {"objects.edges", "is of surfaces; surface_test.cc has them"},
    {"objects.overlap", "is of layouts that are refused without it"},
    {"repeats", "is the schedule's"},
    {"trace", "is run without the engine: trace_command_test.cc"},
    {"configurations.positions", "replaces the simulation: run_configurations_test.cc"},
    {"configurations.of", "is of configurations"},
    {"configurations.by", "is of configurations"},
    {"configurations.ask", "is of configurations"},
    {"joints.goal", "is of configurations"},
    {"joints.gear.offset", "is that of the start, and counts in configurations: lanes_test.cc"},
    {"soft_world", "is of soft bodies, which have their own: soft_world_test.cc"},
    {"soft_cell", "is of soft bodies"},
    {"objects.soft.pin", "is of soft bodies"},
    {"objects.soft.correction", "is of soft bodies"},
    {"objects.soft.stiffness", "is of soft bodies"},
    {"objects.soft.damping", "is of soft bodies"},
    {"objects.soft.self_collision", "is of soft bodies"},
    {"objects.soft.drive.pin", "is of soft bodies: driven_pins_test.cc"},
    {"objects.soft.drive.linear_velocity", "is of soft bodies"},
    {"objects.soft.drive.angular_velocity", "is of soft bodies"},
    {"objects.soft.material", "is of soft bodies: block_test.cc"},
    {"objects.soft.young_modulus", "is of soft bodies"},
    {"objects.soft.poisson_ratio", "is of soft bodies"},
    {"objects.soft.stiffness_damping", "is of soft bodies"},
    {"narrow_phase", "needs a detector that comes with a package; adapter_test.cc has one"},
    {"threads", "must not change what a detector finds"},
    {"expect", "is the verdict's"},
    {"budget", "is the report's"},
    {"frame", "is the report's"},
    {"timeout", "is the schedule's"},
    {"memory", "is the schedule's"},
    {"clock", "is that of the measurement"},
    {"addresses", "is the launcher's: worker_test.cc"},
    {"record", "is what is stored; a test of its own says that it changes nothing"},
    {"omit", "leaves out only what changes nothing"},
};

TEST(Parameters, EachOfTheEnginesChangesTheEnd) {
  std::set<std::string> seen;
  for (const auto& [scene, changes] : AllVariations()) {
    const Recorded before = RunHere(scene);
    ASSERT_TRUE(before.done()) << before.message();
    for (const auto& [name, change] : changes) {
      const Recorded after = RunHere(With(scene, change));
      ASSERT_TRUE(after.done()) << name << ": " << after.message();
      EXPECT_NE(before.hash(), after.hash()) << "`" << name << "` is ignored";
      EXPECT_EQ(before.hash(), RunHere(scene).hash()) << name;
      seen.insert(name);
    }
  }
  for (const schema::Parameter& parameter : schema::Schema()) {
    const std::string name = parameter.FullName();
    if (parameter.name.starts_with("accuracy.")) continue;  // of a separate pass: sampler_test.cc
    // Queries read the scene and must not change it: queries_test.cc.
    if (parameter.NamedBlock() == schema::kQueriesBlock) continue;
    EXPECT_NE(seen.contains(name), kNotTheEngines.contains(name))
        << "`" << name
        << "` needs either a change that shows its effect, or a reason why it has none";
  }
}

TEST(Parameters, EverySwitchAndWordOfTheDetectorRuns) {
  for (const schema::DetectorInfo& info : schema::Detectors()) {
    if (!info.part.empty() || !info.HasPhase("broad")) continue;
    const std::string detector(info.name);
    plan::Scene scene = CrowdScene();
    SetWorld(scene, "detector", Word(detector));
    const Recorded run = RunHere(scene);
    EXPECT_TRUE(run.done()) << detector << ": " << run.message();
    EXPECT_EQ(run.hash(), RunHere(scene).hash()) << detector;
    EXPECT_EQ(run.recording.header().cycles_done.load(), 150u);
  }
}

TEST(Parameters, WhatIsRecordedChangesNothing) {
  plan::Scene scene = CrowdScene();
  const std::string hash = RunHere(scene).hash();
  for (const schema::WordList& record :
       {schema::WordList{}, schema::WordList{"counts"},
        schema::WordList{"timing", "counts", "energy", "stability", "poses", "memory"}}) {
    SetWorld(scene, "record", record);
    EXPECT_EQ(RunHere(scene).hash(), hash);
  }
}

TEST(Parameters, SettingsReachBullet) {
  plan::Scene scene = EngineScene(1, 500);
  SetWorld(scene, "solver.iterations", std::uint64_t{33});
  SetWorld(scene, "solver.erp", 0.5);
  SetWorld(scene, "solver.warm_start", 0.25);
  SetWorld(scene, "contact", Word("faithful"));
  SetGroup(scene, "contact_stiffness", 1000.0);
  SetGroup(scene, "contact_damping", 2.0);
  SetGroup(scene, "rolling_friction", 0.25);
  SetGroup(scene, "ccd", true);
  world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  const btContactSolverInfo& info = engine.world().getSolverInfo();
  EXPECT_EQ(info.m_numIterations, 33);
  EXPECT_EQ(info.m_erp, btScalar(0.5));
  EXPECT_EQ(info.m_erp2, btScalar(0.5));
  EXPECT_EQ(info.m_warmstartingFactor, btScalar(0.25));
  EXPECT_TRUE(info.m_solverMode & SOLVER_USE_WARMSTARTING);
  EXPECT_EQ(info.m_splitImpulsePenetrationThreshold, 0);
  const btRigidBody& body = *engine.objects()[0];
  EXPECT_EQ(body.getContactProcessingThreshold(), 0);
  EXPECT_EQ(engine.walls()[0]->getContactProcessingThreshold(), 0);
  EXPECT_EQ(body.getContactStiffness(), 1000);
  EXPECT_EQ(body.getContactDamping(), 2);
  EXPECT_EQ(body.getRollingFriction(), btScalar(0.25));
  EXPECT_EQ(body.getCcdMotionThreshold(), 25);
  EXPECT_EQ(body.getCcdSweptSphereRadius(), 25);
  EXPECT_EQ(engine.walls().size(), 6u);
}

TEST(Parameters, DefaultsAreBulletsOwn) {
  const plan::Scene scene = EngineScene(1, 500);
  world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  const btContactSolverInfo own;
  const btContactSolverInfo& info = engine.world().getSolverInfo();
  EXPECT_EQ(info.m_numIterations, own.m_numIterations);
  EXPECT_EQ(info.m_erp, own.m_erp);
  EXPECT_EQ(info.m_erp2, own.m_erp2);
  EXPECT_EQ(info.m_warmstartingFactor, own.m_warmstartingFactor);
  EXPECT_EQ(info.m_solverMode, own.m_solverMode);
  EXPECT_EQ(info.m_splitImpulsePenetrationThreshold, own.m_splitImpulsePenetrationThreshold);
  btSphereShape shape(25);
  const btRigidBody plain(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape));
  const btRigidBody& body = *engine.objects()[0];
  EXPECT_EQ(body.getFriction(), plain.getFriction());
  EXPECT_EQ(body.getRollingFriction(), plain.getRollingFriction());
  EXPECT_EQ(body.getSpinningFriction(), plain.getSpinningFriction());
  EXPECT_EQ(engine.walls()[0]->getFriction(), plain.getFriction());
  EXPECT_EQ(body.getRestitution(), plain.getRestitution());
  EXPECT_EQ(body.getLinearDamping(), plain.getLinearDamping());
  EXPECT_EQ(body.getAngularDamping(), plain.getAngularDamping());
  EXPECT_EQ(body.getContactProcessingThreshold(), plain.getContactProcessingThreshold());
  EXPECT_EQ(body.getCollisionFlags(), plain.getCollisionFlags());
  EXPECT_EQ(body.getContactDamping(), plain.getContactDamping());
  EXPECT_EQ(body.getFlags(), plain.getFlags());
  EXPECT_EQ(body.getCcdMotionThreshold(), 0);
  EXPECT_EQ(shape.getMargin(), engine.objects()[0]->getCollisionShape()->getMargin());
}

TEST(Ccd, StopsWhatWouldFlyThroughAWall) {
  // 20000 m/s is 333 m a cycle; the walls are 50 m thick, the ball is 50 m wide.
  plan::Scene scene = BulletScene();
  Recorded through = RunHere(scene);
  EXPECT_EQ(through.recording.Ints("escaped").back(), 1);
  SetGroup(scene, "ccd", true);
  Recorded stopped = RunHere(scene);
  EXPECT_EQ(stopped.recording.Ints("escaped").back(), 0);
}

}  // namespace
}  // namespace cdb::tests
