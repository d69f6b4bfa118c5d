// The pass that samples errors: its samples, and that it moves like the timed pass.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "compiler/analysis/reference.h"
#include "runtime/engine/probes/pair_referee.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

/// A gas of 30 balls in a small cube, sampled every fifth of its 20 cycles.
plan::Scene Gas(schema::WordList metrics) {
  plan::Scene scene = EngineScene(30, 500);
  SetWorld(scene, "cycles", std::uint64_t{20});
  SetWorld(scene, "accuracy.metrics", std::move(metrics));
  SetGroup(scene, "linear_velocity",
           Uniform(Vector3d(Vector3d::Constant(-300)), Vector3d(Vector3d::Constant(300))));
  SetGroup(scene, "restitution", 1.0);
  SeedStreams(scene);
  return scene;
}

protocol::Samples SamplesOf(const Recorded& recorded, const plan::Scene& scene) {
  return {*protocol::SampleShapeOf(scene), scene.world.Real("accuracy.interval"),
          recorded.recording.SampleValues()};
}

TEST(Sampler, SeesWhatTheTimedPassRecords) {
  plan::Scene scene = Gas({"position"});
  SetWorld(scene, "record", schema::WordList{"counts", "energy", "poses", "timing"});
  Recorded recorded = RunHere(scene);
  ASSERT_TRUE(recorded.done()) << recorded.message();
  const protocol::Samples samples = SamplesOf(recorded, scene);
  ASSERT_EQ(samples.shape.samples, 6u);
  const auto poses = recorded.recording.Reals("poses");
  const auto kinetic = recorded.recording.Reals("kinetic_energy");
  const auto contacts = recorded.recording.Ints("contacts");
  for (std::size_t s = 1; s < 6; ++s) {
    const std::size_t cycle = 4 * s - 1;
    for (std::size_t i = 0; i < 30; ++i)
      for (std::size_t k = 0; k < protocol::kPoseSize; ++k)
        EXPECT_EQ(samples.values[samples.shape.State(s, i) + k],
                  poses[(cycle * 30 + i) * protocol::kPoseSize + k]);
    EXPECT_NEAR(samples.observable(s, protocol::kKinetic), kinetic[cycle], 1e-5 * kinetic[cycle]);
    EXPECT_EQ(samples.observable(s, protocol::kContactCount), contacts[cycle]);
  }
  EXPECT_EQ(
      samples.position(0, 0),
      recorded.engine->initial_state().objects[0].pose.position.cast<btScalar>().cast<double>());
}

TEST(Sampler, ChangesNothingOfTheTimedPass) {
  const plan::Scene scene = Gas({"position", "pairs"});
  plan::Scene plain = scene;
  SetWorld(plain, "accuracy.metrics", schema::WordList{"none"});
  const Recorded with = RunHere(scene), without = RunHere(plain);
  ASSERT_TRUE(with.done()) << with.message();
  EXPECT_EQ(with.hash(), without.hash());
  EXPECT_TRUE(without.recording.SampleValues().empty());
}

TEST(Sampler, LooksAtThePairsOfEveryDetector) {
  for (const char* detector : {"simple", "sap", "sap32", "dbvt"}) {
    plan::Scene scene = Gas({"pairs"});
    SetWorld(scene, "detector", Word(detector));
    SetWorld(scene, "world.side", 300.0);
    const Recorded recorded = RunHere(scene);
    ASSERT_TRUE(recorded.done()) << recorded.message();
    const protocol::Samples samples = SamplesOf(recorded, scene);
    double exact = 0;
    for (std::size_t s = 1; s < samples.shape.samples; ++s) {
      exact += samples.observable(s, protocol::kPairsExact);
      EXPECT_EQ(samples.observable(s, protocol::kPairsMissed), 0) << detector;
      EXPECT_GE(samples.observable(s, protocol::kPairsPhantom), 0) << detector;
    }
    EXPECT_GT(exact, 0) << "nothing to find";
  }
}

TEST(Sampler, SeesHowDeepContactsAre) {
  plan::Scene scene = EngineScene(1, 100);
  SetWorld(scene, "cycles", std::uint64_t{30});
  SetWorld(scene, "accuracy.metrics", schema::WordList{"penetration"});
  SetWorld(scene, "accuracy.interval", 1.0 / 60);
  SetGroup(scene, "linear_velocity", Vector3d(0, -200, 0));
  SetGroup(scene, "size", 10.0);
  SetGroup(scene, "location", Layout("at", {{"x", 0.0}, {"y", -44.0}, {"z", 0.0}}));
  Recorded recorded = RunHere(scene);
  ASSERT_TRUE(recorded.done()) << recorded.message();
  const auto deepest = recorded.recording.Reals("max_penetration");
  const protocol::Samples samples = SamplesOf(recorded, scene);
  double most = 0;
  for (std::size_t s = 1; s < samples.shape.samples; ++s) {
    EXPECT_NEAR(samples.observable(s, protocol::kDepthMax), deepest[s - 1] / 10, 1e-12);
    EXPECT_LE(samples.observable(s, protocol::kDepthMean),
              samples.observable(s, protocol::kDepthMax));
    most = std::max(most, samples.observable(s, protocol::kDepthMax));
  }
  EXPECT_GT(most, 0);
}

/// Sums over all samples of the narrow phase's results for the overlaps of a scene.
struct Geometry {
  double overlaps = 0, missed = 0, depth_sum = 0, normal_sum = 0, normals = 0;
};

Geometry GeometryOf(plan::Scene scene) {
  SetWorld(scene, "accuracy.metrics", schema::WordList{"geometry"});
  SetWorld(scene, "accuracy.interval", 1.0 / 60);
  SeedStreams(scene);
  const Recorded recorded = RunHere(scene);
  EXPECT_TRUE(recorded.done()) << recorded.message();
  const protocol::Samples samples = SamplesOf(recorded, scene);
  EXPECT_TRUE(std::isnan(samples.observable(0, protocol::kOverlapsExact))) << "before any step";
  Geometry sums;
  for (std::size_t s = 1; s < samples.shape.samples; ++s) {
    sums.overlaps += samples.observable(s, protocol::kOverlapsExact);
    sums.missed += samples.observable(s, protocol::kOverlapsMissed);
    sums.depth_sum += samples.observable(s, protocol::kDepthErrorSum);
    sums.normal_sum += samples.observable(s, protocol::kNormalErrorSum);
    sums.normals += samples.observable(s, protocol::kNormalCount);
  }
  return sums;
}

/// An object of 10 m that falls on the floor of a cube of 100 m.
plan::Scene OnTheFloor(const char* type, const char* wall_shape) {
  plan::Scene scene = EngineScene(1, 100);
  SetWorld(scene, "cycles", std::uint64_t{60});
  SetWorld(scene, "world.wall_shape", Word(wall_shape));
  SetWorld(scene, "acceleration", Vector3d(0, -100, 0));
  SetGroup(scene, "type", Word(type));
  SetGroup(scene, "size", 10.0);
  SetGroup(scene, "linear_velocity", Vector3d(3, -200, 1));
  SetGroup(scene, "angular_velocity", Vector3d(1, 2, 3));
  SetGroup(scene, "location", Layout("at", {{"x", 0.0}, {"y", -44.0}, {"z", 0.0}}));
  return scene;
}

/// An object of 10 m at `upper`, turned by `turn`, and one at the origin, without any walls.
plan::Scene InEachOther(const char* upper_type, const char* lower_type, const Vector3d& upper,
                        const Vector3d& turn) {
  plan::Scene scene = EngineScene(1, 100);
  SetWorld(scene, "cycles", std::uint64_t{1});
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetGroup(scene, "size", 10.0);
  SetGroup(scene, "overlap", true);
  scene.groups.push_back(scene.groups[0]);
  scene.groups[1].name = "lower";
  SetGroup(scene, "type", Word(upper_type));
  SetGroup(scene, "orientation", turn);
  SetGroup(scene, "location", Layout("at", {{"x", upper.x()}, {"y", upper.y()}, {"z", upper.z()}}));
  SetGroup(scene, "type", Word(lower_type), 1);
  SetGroup(scene, "location", Layout("at", {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}}), 1);
  return scene;
}

void ExpectRight(const Geometry& sums) {
  EXPECT_EQ(sums.missed, 0);
  EXPECT_EQ(sums.normals, sums.overlaps);
  EXPECT_LE(sums.depth_sum, 20 * kEpsilon * sums.overlaps);
  EXPECT_LE(sums.normal_sum, 20 * kEpsilon * sums.overlaps);
}

TEST(Geometry, OfWhatStandsOnAWallIsRightToRounding) {
  for (const char* type : {"sphere", "cuboid"}) {
    for (const char* wall_shape : {"plane", "box"}) {
      SCOPED_TRACE(testing::Message() << type << " on " << wall_shape);
      const Geometry sums = GeometryOf(OnTheFloor(type, wall_shape));
      EXPECT_GT(sums.overlaps, 10);
      ExpectRight(sums);
    }
  }
}

TEST(Geometry, OfShallowOverlapsIsRightToRounding) {
  for (const char* upper : {"sphere", "cuboid"}) {
    for (const char* lower : {"sphere", "cuboid"}) {
      SCOPED_TRACE(testing::Message() << upper << " in " << lower);
      const Geometry sums = GeometryOf(InEachOther(upper, lower, {1, 9.3, -1}, {0.1, 0.3, 0.05}));
      EXPECT_EQ(sums.overlaps, 1);
      ExpectRight(sums);
    }
  }
}

TEST(Geometry, HoldsNoNormalAgainstOneOfTwo) {
  const Geometry sums = GeometryOf(InEachOther("cuboid", "cuboid", {9, 9, 0}, {0, 0, 0}));
  EXPECT_EQ(sums.overlaps, 1);
  EXPECT_EQ(sums.normals, 0) << "it can leave by x as well as by y";
  EXPECT_NEAR(sums.depth_sum, 0, 20 * kEpsilon);
}

TEST(Geometry, IsOfOverlapsAlone) {
  const Vector3d just(0, 10 - 0.5 * probes::kLeastOverlap * 10, 0);
  EXPECT_EQ(GeometryOf(InEachOther("sphere", "sphere", just, {0, 0, 0})).overlaps, 0) << "touch";
  // The tip of the cone is 7.5 m above its centre.
  EXPECT_EQ(GeometryOf(InEachOther("cuboid", "cone", {1, 12.49, 0}, {0, 0, 0})).overlaps, 1);
  EXPECT_EQ(GeometryOf(InEachOther("cuboid", "cone", {1, 12.51, 0}, {0, 0, 0})).overlaps, 0);
}

TEST(Geometry, LeavesOutThoseThatALinkLetsThrough) {
  plan::Scene scene = InEachOther("sphere", "sphere", {0, 8, 0}, {0, 0, 0});
  EXPECT_EQ(GeometryOf(scene).overlaps, 1);
  const Recorded recorded = RunHere(scene);
  btRigidBody &a = *recorded.engine->objects()[0], &b = *recorded.engine->objects()[1];
  ASSERT_EQ(probes::ExactOverlaps(*recorded.engine, {{0, 1}}).overlaps.size(), 1u);
  // As for a constraint that disables collisions between its two bodies.
  a.setIgnoreCollisionCheck(&b, true);
  EXPECT_TRUE(probes::ExactOverlaps(*recorded.engine, {{0, 1}}).overlaps.empty());
  a.setIgnoreCollisionCheck(&b, false);
}

/// The reference of `scene` in this engine's precision.
plan::Scene ReferenceHere(plan::Scene scene) {
  SetWorld(scene, "accuracy.reference.precision", Word(world::EnginePrecision()));
  SetWorld(scene, "accuracy.reference.timestep", 1.0 / 240);
  return analysis::ReferenceOf(scene);
}

TEST(Reference, StartsWhereTheRunDoesAndIsSampledAtTheSameTimes) {
  const plan::Scene scene = Gas({"position"});
  const plan::Scene reference = ReferenceHere(scene);
  const Recorded run = RunHere(scene), truth = RunHere(reference);
  ASSERT_TRUE(truth.done()) << truth.message();
  EXPECT_EQ(truth.header().cycles_done.load(), 80u);
  const protocol::Samples samples = SamplesOf(run, scene),
                          true_samples = SamplesOf(truth, reference);
  EXPECT_EQ(samples.shape, true_samples.shape);
  for (std::size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(samples.position(0, i), true_samples.position(0, i));
    EXPECT_EQ(samples.velocity(0, i), true_samples.velocity(0, i));
  }
  // Free flight for the first fifteenth of a second, with errors of first order in the time step.
  EXPECT_GT((samples.position(1, 0) - true_samples.position(1, 0)).norm(), 0);
}

TEST(Twin, IsMovedByABillionthOfEachSize) {
  const plan::Scene reference = ReferenceHere(Gas({"position"}));
  const plan::Scene twin = analysis::TwinOf(reference);
  const Recorded truth = RunHere(reference), other = RunHere(twin);
  ASSERT_TRUE(other.done()) << other.message();
  const protocol::Samples a = SamplesOf(truth, reference), b = SamplesOf(other, twin);
  if (std::string_view(world::EnginePrecision()) == "double") {
    for (std::size_t i = 0; i < 30; ++i)
      EXPECT_NEAR((a.position(0, i) - b.position(0, i)).norm() / a.size(i), 1e-9, 1e-13);
    EXPECT_NE(truth.hash(), other.hash());
  } else {
    for (std::size_t i = 0; i < 30; ++i)
      EXPECT_NEAR((a.position(0, i) - b.position(0, i)).norm(), 0, 1e-4);
  }
}

}  // namespace
}  // namespace cdb::tests
