// Accelerations and velocities that change during a run.
#include "runtime/engine/world/engine.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using schema::Call;
using schema::Value;

Value Every(std::uint64_t cycles, Value value) { return Call{"every", {cycles, std::move(value)}}; }
Value Rotating(const Vector3d& vector, const Vector3d& about, double period) {
  return Call{"rotating", {vector, about, period}};
}

plan::Scene FreeScene(std::uint64_t quantity) {
  plan::Scene scene = EngineScene(quantity, 1e5);
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(scene, "cycles", std::uint64_t{100});
  return scene;
}

/// Steps as RunScene does, and calls `look` after each step.
template <typename Look>
void RunSteps(const plan::Scene& scene, std::uint64_t steps, const Look& look) {
  world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  world::Schedules schedules(scene, engine);
  for (std::uint64_t step = 0; step < steps; ++step) {
    schedules.BeforeStep(step);
    engine.Step();
    look(step, engine);
  }
}

TEST(Schedules, VelocitiesAreDrawnAnewEverySoManySteps) {
  plan::Scene scene = FreeScene(3);
  SetGroup(scene, "linear_velocity",
           Every(10, Uniform(Value(Vector3d(-9, -9, -9)), Value(Vector3d(9, 9, 9)))));
  SeedStreams(scene);
  // The values of a stream of the same name, group by group and time after time.
  distributions::Draw draw(scene, scene.groups[0], "linear_velocity");
  std::vector<Vector3d> expected(3);
  RunSteps(scene, 35, [&](std::uint64_t step, const world::Engine& engine) {
    if (step % 10 == 0)
      for (Vector3d& velocity : expected) velocity = draw.Vector();
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_LE((Velocity(engine, i) - expected[i]).norm(), 20 * kEpsilon) << step;
  });
}

TEST(Schedules, AnAccelerationTurnsSteadily) {
  plan::Scene scene = FreeScene(1);
  const double period = 0.5, dt = 1.0 / 60;
  SetWorld(scene, "acceleration", Rotating({0, -9.8, 0}, {0, 0, 2}, period));
  SeedStreams(scene);
  Vector3d velocity = Vector3d::Zero();
  RunSteps(scene, 100, [&](std::uint64_t step, const world::Engine& engine) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(step) * dt / period;
    // By the right-hand rule about z, from -y to +x.
    velocity += 9.8 * Vector3d(std::sin(angle), -std::cos(angle), 0) * dt;
    EXPECT_LE((Velocity(engine) - velocity).norm(), 100 * kEpsilon * 10) << step;
  });
  EXPECT_GT(velocity.norm(), 0.1) << "it is not all zero";
}

TEST(Schedules, WhoSleepsIsWoken) {
  plan::Scene scene = EngineScene(1, 500);
  SetWorld(scene, "acceleration", Every(300, Value(Vector3d(0, -9.8, 0))));
  SeedStreams(scene);
  world::Engine engine = WholeEngine(scene, OneObjectAt(scene, {0, -225, 0}));
  world::Schedules schedules(scene, engine);
  for (std::uint64_t step = 0; step < 301; ++step) {
    if (step == 300) {
      EXPECT_EQ(engine.objects()[0]->getActivationState(), ISLAND_SLEEPING);
    }
    schedules.BeforeStep(step);
    engine.Step();
  }
  EXPECT_EQ(engine.objects()[0]->getActivationState(), ACTIVE_TAG);
}

TEST(Schedules, FixedObjectsStayFixed) {
  plan::Scene scene = FreeScene(1);
  SetGroup(scene, "mass", Word("fixed"));
  SetGroup(scene, "linear_velocity", Every(1, Value(Vector3d(5, 0, 0))));
  SeedStreams(scene);
  const Vector3d start = layouts::MakeInitialState(scene).objects[0].pose.position;
  RunSteps(scene, 5, [&](std::uint64_t, const world::Engine& engine) {
    EXPECT_LE((Position(engine) - start).norm(), 1e5 * kEpsilon);
  });
}

TEST(Schedules, NothingIsLeftOutThatAChangeCouldNeed) {
  // Without a schedule, nothing touches here, and nearly everything is omitted.
  plan::Scene scene = EngineScene(4, 2000);
  SetWorld(scene, "cycles", std::uint64_t{400});
  SetWorld(scene, "acceleration", Rotating({0, -200, 0}, {1, 0, 0}, 3));
  SetGroup(scene, "linear_velocity",
           Every(50, Uniform(Value(Vector3d(-200, -200, -200)), Value(Vector3d(200, 200, 200)))));
  SeedStreams(scene);
  const Recorded pruned = RunHere(scene);
  ASSERT_TRUE(pruned.done()) << pruned.message();
  EXPECT_NE(pruned.header().decisions.str().find("the acceleration changes during the run"),
            std::string::npos);
  SetWorld(scene, "omit", schema::WordList{"none"});
  EXPECT_EQ(RunHere(scene).hash(), pruned.hash());
}

}  // namespace
}  // namespace cdb::tests
