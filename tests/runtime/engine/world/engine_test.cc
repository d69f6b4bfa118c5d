// No parameter is silently ignored: each row of the schema that concerns the engine has a scene in
// which changing it changes the final state.
#include <gtest/gtest.h>

#include <functional>
#include <map>

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
struct Variation {
  plan::Scene scene;
  Change change;
};

Change World(schema::WorldParameter name, schema::Value value) {
  return [=](plan::Scene& scene) { SetWorld(scene, name, value); };
}
Change Objects(schema::GroupParameter name, schema::Value value) {
  return [=](plan::Scene& scene) { SetGroup(scene, name, value); };
}

plan::Scene With(plan::Scene scene, const Change& change) {
  change(scene);
  return scene;
}

std::map<std::string, Variation> Variations() {
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
  return {
      {"cycles", {crowd, World("cycles", std::uint64_t{151})}},
      {"warmup", {crowd, World("warmup", std::uint64_t{1})}},
      {"acceleration", {crowd, World("acceleration", Vector3d(0, -99, 0))}},
      {"world.side", {crowd, World("world.side", 281.0)}},
      {"world.walls", {crowd, World("world.walls", Word("floor"))}},
      {"world.wall_shape", {crowd, World("world.wall_shape", Word("box"))}},
      {"timestep", {crowd, World("timestep", 1.0 / 61)}},
      {"detector", {crowd, World("detector", Word("sap32"))}},
      {"pair_order", {crowd, World("pair_order", Word("sorted"))}},
      {"contact", {crowd, World("contact", Word("faithful"))}},
      {"solver.iterations", {crowd, World("solver.iterations", std::uint64_t{11})}},
      {"solver.erp", {crowd, World("solver.erp", 0.3)}},
      {"solver.warm_start", {crowd, World("solver.warm_start", 0.0)}},
      {"sleeping", {resting, World("sleeping", false)}},
      {"objects.quantity", {crowd, Objects("quantity", std::uint64_t{41})}},
      {"objects.type", {crowd, Objects("type", Word("cone"))}},
      {"objects.aspect", {crowd, Objects("aspect", schema::Ratio{{1, 1, 1.1}})}},
      {"objects.location", {crowd, Objects("location", Word("normal"))}},
      {"objects.size", {crowd, Objects("size", 49.0)}},
      {"objects.mass", {crowd, Objects("mass", Uniform(1.0, 9.0))}},
      {"objects.linear_velocity", {crowd, Objects("linear_velocity", Vector3d(1, 0, 0))}},
      {"objects.angular_velocity", {crowd, Objects("angular_velocity", Vector3d(1, 0, 0))}},
      {"objects.friction", {crowd, Objects("friction", 0.4)}},
      {"objects.rolling_friction", {crowd, Objects("rolling_friction", 0.1)}},
      {"objects.restitution", {crowd, Objects("restitution", 0.5)}},
      {"objects.linear_damping", {crowd, Objects("linear_damping", 0.1)}},
      {"objects.angular_damping", {crowd, Objects("angular_damping", 0.1)}},
      {"objects.margin", {crowd, Objects("margin", 0.5)}},
      {"objects.contact_stiffness", {crowd, Objects("contact_stiffness", 5000.0)}},
      {"objects.contact_damping",
       {With(crowd, Objects("contact_stiffness", 5000.0)), Objects("contact_damping", 30.0)}},
      {"objects.ccd", {BulletScene(), Objects("ccd", true)}},
      {"objects.collides_with", {crowd, Objects("collides_with", schema::WordList{"walls"})}},
      {"objects.orientation", {crowd, Objects("orientation", Word("random"))}},
      {"objects.links.type", {chain, Objects("links.type", Word("ball"))}},
      {"objects.links.stiffness", {chain, Objects("links.stiffness", 900.0)}},
      {"objects.links.damping", {chain, Objects("links.damping", 1.0)}},
      {"objects.links.anchor", {chain, Objects("links.anchor", false)}},
      {"objects.links.end_mass", {chain, Objects("links.end_mass", 2.0)}},
  };
}

/// Rows that must not change the final state, and the reason.
const std::map<std::string, std::string> kNotTheEngines = {
    {"seed", "is in the plan's stream seeds"},
    {"precision", "chooses the worker"},
    {"objects.overlap", "is of layouts that are refused without it"},
    {"repeats", "is the schedule's"},
    {"trace", "is run without the engine: replay_test.cc"},
    {"narrow_phase", "needs a detector that comes with a package; adapter_test.cc has one"},
    {"threads", "must not change what a detector finds"},
    {"expect", "is the verdict's"},
    {"timeout", "is the schedule's"},
    {"memory", "is the schedule's"},
    {"record", "is what is stored; a test of its own says that it changes nothing"},
    {"omit", "leaves out only what changes nothing"},
};

TEST(Parameters, EachOfTheEnginesChangesTheEnd) {
  const auto variations = Variations();
  for (const schema::Parameter& parameter : schema::Schema()) {
    const std::string name = parameter.FullName();
    if (kNotTheEngines.contains(name)) continue;
    if (parameter.name.starts_with("accuracy.")) continue;  // of a separate pass: sampler_test.cc
    const auto found = variations.find(name);
    ASSERT_NE(found, variations.end()) << "no test shows that `" << name << "` takes effect";
    const Recorded before = RunHere(found->second.scene);
    const Recorded after = RunHere(With(found->second.scene, found->second.change));
    ASSERT_TRUE(before.done()) << name << ": " << before.message();
    ASSERT_TRUE(after.done()) << name << ": " << after.message();
    EXPECT_NE(before.hash(), after.hash()) << "`" << name << "` is ignored";
    EXPECT_EQ(before.hash(), RunHere(found->second.scene).hash()) << name;
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
