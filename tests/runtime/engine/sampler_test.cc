// The pass that collects errors: what it samples, and that it goes the way of the timed one.
#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

#include "compiler/reference.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::test {
namespace {

using Eigen::Vector3d;
using namespace runtime;

/// A gas of 30 balls in a small cube, sampled every fifth of its 20 cycles.
compiler::Scene Gas(compiler::WordList metrics) {
  compiler::Scene scene = EngineScene(30, 500);
  SetWorld(scene, "cycles", std::uint64_t{20});
  SetWorld(scene, "accuracy.metrics", std::move(metrics));
  SetGroup(scene, "linear_velocity",
           Uniform(Vector3d(Vector3d::Constant(-300)), Vector3d(Vector3d::Constant(300))));
  SetGroup(scene, "restitution", 1.0);
  SeedStreams(scene);
  return scene;
}

Samples SamplesOf(const Recorded& recorded, const compiler::Scene& scene) {
  return {*SampleShapeOf(scene), scene.world.Real("accuracy.interval"),
          recorded.recording.SampleValues()};
}

TEST(Sampler, SeesWhatTheTimedPassRecords) {
  compiler::Scene scene = Gas({"position"});
  SetWorld(scene, "record", compiler::WordList{"counts", "energy", "poses", "timing"});
  Recorded recorded = RunHere(scene);
  ASSERT_TRUE(recorded.done()) << recorded.message();
  const Samples samples = SamplesOf(recorded, scene);
  ASSERT_EQ(samples.shape.samples, 6u);
  const auto poses = recorded.recording.Reals("poses");
  const auto kinetic = recorded.recording.Reals("kinetic_energy");
  const auto contacts = recorded.recording.Ints("contacts");
  for (std::size_t s = 1; s < 6; ++s) {
    const std::size_t cycle = 4 * s - 1;
    for (std::size_t i = 0; i < 30; ++i)
      for (std::size_t k = 0; k < kPoseSize; ++k)
        EXPECT_EQ(samples.values[samples.shape.State(s, i) + k],
                  poses[(cycle * 30 + i) * kPoseSize + k]);
    EXPECT_NEAR(samples.observable(s, kKinetic), kinetic[cycle], 1e-5 * kinetic[cycle]);
    EXPECT_EQ(samples.observable(s, kContactCount), contacts[cycle]);
  }
  EXPECT_EQ(
      samples.position(0, 0),
      recorded.engine->initial_state().objects[0].pose.position.cast<btScalar>().cast<double>());
}

TEST(Sampler, ChangesNothingOfTheTimedPass) {
  const compiler::Scene scene = Gas({"position", "pairs"});
  compiler::Scene plain = scene;
  SetWorld(plain, "accuracy.metrics", compiler::WordList{"none"});
  const Recorded with = RunHere(scene), without = RunHere(plain);
  ASSERT_TRUE(with.done()) << with.message();
  EXPECT_EQ(with.hash(), without.hash());
  EXPECT_TRUE(without.recording.SampleValues().empty());
}

TEST(Sampler, LooksAtThePairsOfEveryDetector) {
  for (const char* detector : {"simple", "sap", "sap32", "dbvt"}) {
    compiler::Scene scene = Gas({"pairs"});
    SetWorld(scene, "detector", Word(detector));
    SetWorld(scene, "world.side", 300.0);
    const Recorded recorded = RunHere(scene);
    ASSERT_TRUE(recorded.done()) << recorded.message();
    const Samples samples = SamplesOf(recorded, scene);
    double exact = 0;
    for (std::size_t s = 1; s < samples.shape.samples; ++s) {
      exact += samples.observable(s, kPairsExact);
      EXPECT_EQ(samples.observable(s, kPairsMissed), 0) << detector;
      EXPECT_GE(samples.observable(s, kPairsPhantom), 0) << detector;
    }
    EXPECT_GT(exact, 0) << "nothing to find";
  }
}

TEST(Sampler, SeesHowDeepContactsAre) {
  compiler::Scene scene = EngineScene(1, 100);
  SetWorld(scene, "cycles", std::uint64_t{120});
  SetWorld(scene, "accuracy.metrics", compiler::WordList{"penetration"});
  SetWorld(scene, "sleeping", false);
  SetGroup(scene, "size", 10.0);
  SetGroup(scene, "location", Layout("at", {{"x", 0.0}, {"y", -44.0}, {"z", 0.0}}));
  Recorded recorded = RunHere(scene);
  ASSERT_TRUE(recorded.done()) << recorded.message();
  const auto deepest = recorded.recording.Reals("max_penetration");
  const Samples samples = SamplesOf(recorded, scene);
  double most = 0;
  for (std::size_t s = 1; s < samples.shape.samples; ++s) {
    EXPECT_NEAR(samples.observable(s, kDepthMax), deepest[4 * s - 1] / 10, 1e-12);
    EXPECT_LE(samples.observable(s, kDepthMean), samples.observable(s, kDepthMax));
    most = std::max(most, samples.observable(s, kDepthMax));
  }
  EXPECT_GT(most, 0);
}

/// The reference of `scene` in this engine's precision.
compiler::Scene ReferenceHere(compiler::Scene scene) {
  SetWorld(scene, "accuracy.reference.precision", Word(EnginePrecision()));
  SetWorld(scene, "accuracy.reference.timestep", 1.0 / 240);
  return compiler::ReferenceOf(scene);
}

TEST(Reference, StartsWhereTheRunDoesAndIsSampledAtTheSameTimes) {
  const compiler::Scene scene = Gas({"position"});
  const compiler::Scene reference = ReferenceHere(scene);
  const Recorded run = RunHere(scene), truth = RunHere(reference);
  ASSERT_TRUE(truth.done()) << truth.message();
  EXPECT_EQ(truth.header().cycles_done.load(), 80u);
  const Samples samples = SamplesOf(run, scene), true_samples = SamplesOf(truth, reference);
  EXPECT_EQ(samples.shape, true_samples.shape);
  for (std::size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(samples.position(0, i), true_samples.position(0, i));
    EXPECT_EQ(samples.velocity(0, i), true_samples.velocity(0, i));
  }
  // Free flight for the first fifteenth of a second, and errors of order one in the time step.
  EXPECT_GT((samples.position(1, 0) - true_samples.position(1, 0)).norm(), 0);
}

TEST(Twin, IsNudgedByABillionthOfEachSize) {
  const compiler::Scene reference = ReferenceHere(Gas({"position"}));
  const compiler::Scene twin = compiler::TwinOf(reference);
  const Recorded truth = RunHere(reference), other = RunHere(twin);
  ASSERT_TRUE(other.done()) << other.message();
  const Samples a = SamplesOf(truth, reference), b = SamplesOf(other, twin);
  if (std::string_view(EnginePrecision()) == "double") {
    for (std::size_t i = 0; i < 30; ++i)
      EXPECT_NEAR((a.position(0, i) - b.position(0, i)).norm() / a.size(i), 1e-9, 1e-13);
    EXPECT_NE(truth.hash(), other.hash());
  } else {
    for (std::size_t i = 0; i < 30; ++i)
      EXPECT_NEAR((a.position(0, i) - b.position(0, i)).norm(), 0, 1e-4);
  }
}

}  // namespace
}  // namespace cdb::test
