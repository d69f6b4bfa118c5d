// The angle of repose and the runout of bodies that fill a cone.
#include <gtest/gtest.h>

#include <cmath>

#include "library/distributions/stream.h"
#include "runtime/engine/probes/probes.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

constexpr double kSide = 100;

struct Repose {
  double angle, runout;
};

Repose Measure(plan::Scene scene, const layouts::InitialState& state) {
  SetWorld(scene, "cycles", std::uint64_t{1});
  SetWorld(scene, "record", schema::WordList{"repose"});
  protocol::Recording recording = protocol::Recording::Create(scene);
  world::Engine engine = WholeEngine(scene, state);
  probes::Probes probes(scene, engine, recording, -1);
  probes.Begin();
  probes.Record(0);
  return {recording.Reals("repose_angle")[0], recording.Reals("runout")[0]};
}

plan::Scene Grains(std::uint64_t count) {
  plan::Scene scene = DefaultScene(count, kSide);
  SetGroup(scene, "size", 0.02);
  return scene;
}

/// Uniformly distributed in a cone of this height and radius on the floor, about (3, -5).
layouts::InitialState Cone(const plan::Scene& scene, double height, double radius) {
  layouts::InitialState state = layouts::MakeInitialState(scene);
  distributions::Stream stream(5);
  for (layouts::ObjectState& object : state.objects) {
    Vector3d at;
    do {
      at = {stream.Uniform(-radius, radius), stream.Uniform(0, height),
            stream.Uniform(-radius, radius)};
    } while (std::hypot(at.x(), at.z()) / radius + at.y() / height > 1);
    object.pose.position = at + Vector3d(3, -kSide / 2, -5);
    object.mass = stream.Uniform(1, 5);
  }
  return state;
}

TEST(Repose, IsThatOfTheConeThatBodiesFill) {
  const plan::Scene scene = Grains(20000);
  for (const auto& [height, radius] : {std::pair{3.0, 6.0}, {5.0, 5.0}, {1.0, 12.0}}) {
    const auto [angle, runout] = Measure(scene, Cone(scene, height, radius));
    EXPECT_NEAR(angle, std::atan(height / radius), 0.01 * angle);
    // 3 x^2 - 2 x^3 of the mass is within x radii.
    const double x = runout / radius;
    EXPECT_NEAR(3 * x * x - 2 * x * x * x, 0.95, 0.003);
  }
}

TEST(Repose, IsOfWhatCanMove) {
  const plan::Scene scene = Grains(2000);
  layouts::InitialState state = Cone(scene, 3, 6);
  const Repose all = Measure(scene, state);
  layouts::ObjectState fixed = state.objects[0];
  fixed.mass = 0;
  fixed.pose.position = Vector3d(40, 20, 40);
  state.objects[0] = fixed;
  EXPECT_NEAR(Measure(scene, state).angle, all.angle, 1e-3);
  // A few that rolled away change little.
  for (std::size_t i = 1; i < 20; ++i) {
    state.objects[i].pose.position = Vector3d(45, -kSide / 2, 0);
    state.objects[i].mass = 1;
  }
  EXPECT_NEAR(Measure(scene, state).angle, all.angle, 0.01);
  for (layouts::ObjectState& object : state.objects) object.mass = 0;
  EXPECT_TRUE(std::isnan(Measure(scene, state).angle));
}

}  // namespace
}  // namespace cdb::tests
