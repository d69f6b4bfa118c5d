// The series of runs with a known course.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <numeric>

#include "library/scene_error.h"
#include "runtime/engine/detection/broad_phase.h"
#include "runtime/engine/probes/probes.h"
#include "runtime/engine/probes/processor_time.h"
#include "runtime/engine/probes/state_hash.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

void Record(plan::Scene& scene, schema::WordList words) {
  SetWorld(scene, "record", std::move(words));
}

/// Runs the scene with its one object at `position`, and returns the recording.
protocol::Recording RunOne(const plan::Scene& scene, const Vector3d& position) {
  protocol::Recording recording = protocol::Recording::Create(scene);
  world::Engine engine = WholeEngine(scene, OneObjectAt(scene, position));
  probes::Probes probes(scene, engine, recording, -1);
  probes.Begin();
  for (std::uint64_t i = 0; i < scene.world.Count("cycles"); ++i) {
    engine.Step();
    probes.Record(i);
  }
  return recording;
}

plan::Scene DenseScene() {
  plan::Scene scene = EngineScene(60, 320);
  SetWorld(scene, "cycles", std::uint64_t{120});
  SetWorld(scene, "acceleration", Vector3d(0, -98, 0));
  SetGroup(scene, "type", AnyType());
  SetGroup(scene, "orientation", Word("random"));
  return scene;
}

TEST(Run, ReportsHowItEnded) {
  const Recorded run = RunHere(DenseScene());
  EXPECT_TRUE(run.done());
  EXPECT_EQ(run.header().cycles_done.load(), 120u);
  EXPECT_EQ(run.hash().size(), 16u);
  EXPECT_EQ(run.hash().find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_EQ(run.message(), "");
  EXPECT_GT(run.header().scalars.place_ns, 0);
  EXPECT_GT(run.header().scalars.build_ns, 0);
  EXPECT_GT(run.header().scalars.fill_fraction, 0);
  EXPECT_GT(probes::PeakRssBytes(), 1e6);
}

TEST(Run, FailsWithAMessageWhereTheSceneCannotBe) {
  const Recorded run = RunHere(EngineScene(500, 400));
  EXPECT_EQ(run.header().outcome.load(), protocol::WorkerOutcome::kFailed);
  EXPECT_NE(run.message().find("% of the cube"), std::string::npos) << run.message();
  EXPECT_NEAR(run.header().scalars.fill_fraction, 0.511, 0.001);
  EXPECT_EQ(run.hash(), "");
  EXPECT_EQ(run.header().cycles_done.load(), 0u);
  EXPECT_EQ(run.engine, nullptr);
}

TEST(Run, LongMessagesAreCutAndEnd) {
  const plan::Scene scene = EngineScene(1, 500);
  protocol::Recording recording = protocol::Recording::Create(scene);
  worker::ReportFailure(recording, std::string(10000, 'x'));
  EXPECT_EQ(recording.header().message.str(),
            std::string(recording.header().message.kMaxLength, 'x'));
}

TEST(Run, WithoutObjects) {
  for (const char* detector : {"simple", "sap", "sap32", "dbvt"}) {
    for (const char* walls : {"all", "none"}) {
      plan::Scene scene = EngineScene(0, 500);
      SetWorld(scene, "detector", Word(detector));
      SetWorld(scene, "world.walls", Word(walls));
      Record(scene, {"timing", "counts", "energy", "stability", "poses", "memory"});
      Recorded run = RunHere(scene);
      EXPECT_TRUE(run.done()) << run.message();
      EXPECT_EQ(run.recording.Ints("pairs").back(), 0);
      EXPECT_EQ(run.recording.Reals("energy").back(), 0);
    }
  }
}

TEST(Determinism, SameSceneSameHash) {
  for (const char* detector : {"simple", "sap", "sap32", "dbvt"}) {
    plan::Scene scene = DenseScene();
    SetWorld(scene, "detector", Word(detector));
    const std::string hash = RunHere(scene).hash();
    // Other allocations in between, so that code that depends on addresses does not see the same
    // ones.
    std::vector<std::unique_ptr<char[]>> litter;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 500; ++j)
        litter.push_back(std::make_unique<char[]>(j * (i + 1) % 977));
      EXPECT_EQ(RunHere(scene).hash(), hash) << detector;
      litter.erase(litter.begin() + static_cast<std::ptrdiff_t>(litter.size() / 2), litter.end());
    }
    SeedStreams(scene, 1);
    EXPECT_NE(RunHere(scene).hash(), hash) << detector;
  }
}

TEST(Determinism, TheInitialStateIsTheSameInEveryPrecision) {
  // The single and the double test expect the same number. FNV-1a over the bits of every position
  // and orientation; the placement uses no library function for sine or logarithm.
  const layouts::InitialState state = layouts::MakeInitialState(DenseScene());
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](double value) {
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 8; ++i, bits >>= 8) hash = (hash ^ (bits & 0xff)) * 0x100000001b3;
  };
  for (const layouts::ObjectState& object : state.objects) {
    for (int axis = 0; axis < 3; ++axis) add(object.pose.position[axis]);
    for (int part = 0; part < 4; ++part) add(object.pose.orientation.coeffs()[part]);
  }
  EXPECT_EQ(hash, 0x4efb614ab0070dacu) << std::hex << hash;
}

TEST(Warmup, RunsBeforeTheFirstRecordedCycle) {
  plan::Scene scene = DenseScene();
  Record(scene, {"poses", "counts"});
  SetWorld(scene, "cycles", std::uint64_t{30});
  Recorded whole = RunHere(scene);
  SetWorld(scene, "warmup", std::uint64_t{12});
  SetWorld(scene, "cycles", std::uint64_t{18});
  Recorded late = RunHere(scene);
  EXPECT_EQ(late.hash(), whole.hash());
  EXPECT_EQ(late.header().cycles_done.load(), 18u);
  const auto all = whole.recording.Reals("poses").subspan(12 * 60 * protocol::kPoseSize);
  EXPECT_TRUE(std::ranges::equal(late.recording.Reals("poses"), all));
  EXPECT_TRUE(std::ranges::equal(late.recording.Ints("contacts"),
                                 whole.recording.Ints("contacts").subspan(12)));
}

TEST(Series, EveryCycleHasEveryValue) {
  plan::Scene scene = DenseScene();
  schema::WordList words;
  for (const schema::RecordWord& word : schema::kRecordWords)
    if (word.name != "contacts" && word.name != "vertices")  // written to a file of the runner, and
      words.emplace_back(word.name);                         // of soft bodies
  Record(scene, words);
  scene.queries.push_back({"sight", {}});
  scene.queries[0].settings.Set("queries.count", std::uint64_t{20});
  SeedStreams(scene);
  Recorded run = RunHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  for (const protocol::Series& series : protocol::AllSeries()) {
    ASSERT_EQ(protocol::IsRecordedBy(series, scene),
              series.on_traces != schema::OnTraces::kNarrowOnly &&
                  series.on_traces != schema::OnTraces::kBroadOnly &&
                  series.on_configurations != schema::OnConfigurations::kOnly &&
                  series.on_soft != schema::OnSoft::kOnly && !series.of_changes)
        << series.name;
    if (!protocol::IsRecordedBy(series, scene)) continue;
    if (series.type == protocol::SeriesType::kInt32) {
      for (const std::int32_t value : run.recording.Values<std::int32_t>(series))
        ASSERT_GE(value, 0) << series.name;
    } else {
      for (const double value : run.recording.Values<double>(series))
        ASSERT_TRUE(std::isfinite(value) || series.may_be_none) << series.name;
    }
  }
}

TEST(Series, PhasesAreStampedByThemselves) {
  Recorded run = RunHere(DenseScene());
  const auto duration = run.recording.Reals("duration");
  const auto at = [&](protocol::Phase phase, std::size_t cycle) {
    return duration[static_cast<std::size_t>(phase) * 120 + cycle];
  };
  for (std::size_t cycle = 0; cycle < 120; ++cycle) {
    for (const protocol::Phase phase : {protocol::Phase::kBroad, protocol::Phase::kNarrow,
                                        protocol::Phase::kSolve, protocol::Phase::kIntegrate}) {
      EXPECT_GT(at(phase, cycle), 0);
      EXPECT_EQ(at(phase, cycle), std::floor(at(phase, cycle)));
    }
    EXPECT_EQ(at(protocol::Phase::kDetect, cycle),
              at(protocol::Phase::kBroad, cycle) + at(protocol::Phase::kNarrow, cycle));
    EXPECT_GE(at(protocol::Phase::kStep, cycle), at(protocol::Phase::kDetect, cycle) +
                                                     at(protocol::Phase::kSolve, cycle) +
                                                     at(protocol::Phase::kIntegrate, cycle));
  }
}

TEST(Series, PairsAreTheBoxesThatOverlap) {
  // The objects are far apart: each has pairs with the six infinite walls only.
  plan::Scene scene = EngineScene(100, 50000);
  SetWorld(scene, "omit", schema::WordList{"none"});
  for (const char* detector : {"simple", "sap32", "dbvt"}) {
    SetWorld(scene, "detector", Word(detector));
    Recorded run = RunHere(scene);
    for (const std::int32_t pairs : run.recording.Ints("pairs")) EXPECT_EQ(pairs, 600) << detector;
    EXPECT_EQ(run.recording.Ints("contacts").back(), 0);
  }
  SetWorld(scene, "world.walls", Word("none"));
  EXPECT_EQ(RunHere(scene).recording.Ints("pairs").back(), 0);
}

TEST(Series, BoxesAreTheSameWhoeverFindsThePairs) {
  plan::Scene scene = DenseScene();
  Record(scene, {"boxes"});
  SetWorld(scene, "pair_order", Word("sorted"));
  SetWorld(scene, "sleeping", false);
  SetWorld(scene, "cycles", std::uint64_t{20});
  SetWorld(scene, "omit", schema::WordList{"none"});
  Recorded first = RunHere(scene);
  ASSERT_TRUE(first.done()) << first.message();
  const auto expected = first.recording.Reals("boxes");
  EXPECT_LT(expected[0], expected[3]);
  for (const char* detector : {"simple", "sap32", "auto", "octree"}) {
    SetWorld(scene, "detector", Word(detector));
    Recorded other = RunHere(scene);
    ASSERT_TRUE(other.done()) << other.message();
    EXPECT_TRUE(std::ranges::equal(other.recording.Reals("boxes"), expected)) << detector;
  }
}

TEST(Series, EnergyIsKeptInFreeFlight) {
  plan::Scene scene = EngineScene(20, 2000);
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "cycles", std::uint64_t{300});
  SetGroup(scene, "linear_velocity", Normal(0.0, 30.0));
  SetGroup(scene, "mass", Uniform(1.0, 5.0));
  Record(scene, {"energy"});
  Recorded run = RunHere(scene);
  const auto energy = run.recording.Reals("energy");
  // In single precision, positions of 1000 m have errors of 1000 kEpsilon a cycle, velocities of
  // 100 m/s have errors of 100 kEpsilon: each changes the energy of 20 objects of up to 5 kg, 100
  // kg in all, by 100 (9.8 * 1000 + 100 * 100) kEpsilon a cycle.
  for (const double e : energy) EXPECT_NEAR(e, energy[0], 300 * 100 * 2e4 * kEpsilon);
  const auto kinetic = run.recording.Reals("kinetic_energy");
  EXPECT_GT(kinetic.back(), kinetic[0]);
}

TEST(Series, KineticEnergyOfAKnownObject) {
  plan::Scene scene = EngineScene(1, 500);
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(scene, "cycles", std::uint64_t{1});
  SetGroup(scene, "mass", 3.0);
  SetGroup(scene, "linear_velocity", Vector3d(2, 0, 0));
  SetGroup(scene, "angular_velocity", Vector3d(0, 0.1, 0));
  Record(scene, {"energy", "stability"});
  protocol::Recording recording = RunOne(scene, {0, 0, 0});
  // m v^2/2 + (2/5) m r^2 w^2/2
  const double expected = 3 * 4 / 2.0 + 0.4 * 3 * 625 * 0.01 / 2;
  EXPECT_NEAR(recording.Reals("kinetic_energy")[0], expected, 64 * kEpsilon * expected);
  EXPECT_NEAR(recording.Reals("energy")[0], expected, 64 * kEpsilon * expected);
  EXPECT_NEAR(recording.Reals("max_speed")[0], 2, 8 * kEpsilon);
}

TEST(Series, PosesAreWhereTheObjectsAre) {
  plan::Scene scene = DenseScene();
  Record(scene, {"poses"});
  Recorded run = RunHere(scene);
  const auto poses = run.recording.Reals("poses");
  for (std::size_t i = 0; i < 60; ++i) {
    const auto pose = poses.subspan((119 * 60 + i) * protocol::kPoseSize);
    const Vector3d at(pose[0], pose[1], pose[2]);
    EXPECT_EQ(at, Position(*run.engine, i));
    const Eigen::Quaterniond turn(pose[6], pose[3], pose[4], pose[5]);
    EXPECT_NEAR(turn.norm(), 1, 64 * kEpsilon);
  }
}

TEST(Series, MotionRatioIsOneWhereNothingIsInTheWay) {
  plan::Scene scene = EngineScene(1, 500);
  SetWorld(scene, "cycles", std::uint64_t{60});
  protocol::Recording recording = RunOne(scene, {0, 0, 0});
  // Positions below 5 m are rounded once a cycle. The ratio is undefined below a hundredth of a
  // side, which the object has travelled after half a metre, in the eighteenth cycle.
  const auto ratios = recording.Reals("motion_ratio");
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    EXPECT_EQ(std::isnan(ratios[i]), i < 18) << i;
    if (i < 18) continue;
    EXPECT_NEAR(ratios[i], 1, 60 * 5 * kEpsilon / 0.5);
    EXPECT_NEAR(recording.Reals("fall_ratio")[i], 1, 1e-5);
  }
}

TEST(Series, MotionRatioShowsWhatPrecisionFreezes) {
  // At 1e7 m, single precision moves in steps of 1 m, so that 0.1 m a cycle is lost.
  plan::Scene scene = EngineScene(1, 1e8);
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetGroup(scene, "linear_velocity", Vector3d(6, 0, 0));
  protocol::Recording recording = RunOne(scene, {1e7, 0, 0});
  const bool is_single = sizeof(btScalar) == 4;
  EXPECT_NEAR(recording.Reals("motion_ratio")[9], is_single ? 0 : 1, 1e-6);
  EXPECT_EQ(recording.Ints("frozen")[9], is_single ? 1 : 0);
  // Relative to objects of 50 m.
  EXPECT_NEAR(recording.Reals("lost_way")[9], is_single ? 10 * 0.1 / 50 : 0, 1e-6);
}

TEST(Series, SmallLossesOfLargeObjectsFreezeNothing) {
  // Adjacent numbers are 8 mm apart, and the fall of the first cycle is 3 mm.
  plan::Scene scene = EngineScene(1, 3e5);
  SetWorld(scene, "cycles", std::uint64_t{60});
  protocol::Recording recording = RunOne(scene, {0, 1.25e5, 0});
  EXPECT_THAT(recording.Ints("frozen"), testing::Each(0));
  const double lost = recording.Reals("lost_way")[0];
  EXPECT_NEAR(lost, sizeof(btScalar) == 4 ? 9.8 / 3600 / 50 : 0, 1e-6);
}

TEST(Series, EscapedCountsCentresBeyondStandingWalls) {
  const auto escaped = [](const char* walls, const Vector3d& at) {
    plan::Scene scene = EngineScene(1, 500);
    SetWorld(scene, "world.walls", Word(walls));
    SetWorld(scene, "cycles", std::uint64_t{1});
    return RunOne(scene, at).Ints("escaped")[0];
  };
  EXPECT_EQ(escaped("all", {0, 0, 0}), 0);
  EXPECT_EQ(escaped("all", {400, 0, 0}), 1);
  EXPECT_EQ(escaped("floor", {400, 0, 0}), 0);
  EXPECT_EQ(escaped("floor", {0, -400, 0}), 1);
  EXPECT_EQ(escaped("none", {0, -400, 0}), 0);
}

TEST(Series, RemovedAndNonFinite) {
  plan::Scene scene = EngineScene(1, 500);
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetGroup(scene, "linear_velocity", Vector3d(1e9, 0, 0));
  // If the box, including the movement of a cycle, is longer than 1e6 m, Bullet removes the object
  // from its simulation.
  protocol::Recording removed = RunOne(scene, {0, 0, 0});
  EXPECT_EQ(removed.Ints("removed").back(), 1);
  SetWorld(scene, "acceleration", Vector3d(1e38, 0, 0));
  SetWorld(scene, "timestep", 1e3);
  SetGroup(scene, "linear_velocity", Vector3d(1, 0, 0));
  if (sizeof(btScalar) == 4) {  // 1e41 m/s is not representable in single precision
    protocol::Recording broken = RunOne(scene, {0, 0, 0});
    EXPECT_EQ(broken.Ints("non_finite").back(), 1);
  }
}

TEST(Series, FixedObjectsStayAndAreNotAsleep) {
  plan::Scene scene = DenseScene();
  SetGroup(scene, "mass",
           schema::Distribution{schema::DistributionKind::kAny, {Word("fixed"), 2.0}, {1, 1}});
  SetGroup(scene, "linear_velocity", Vector3d(1, 2, 3));
  Recorded run = RunHere(scene);
  ASSERT_TRUE(run.done());
  int fixed = 0;
  for (std::size_t i = 0; i < 60; ++i) {
    const layouts::ObjectState& object = run.engine->initial_state().objects[i];
    const bool moved = (Position(*run.engine, i) - object.pose.position).norm() > 400 * kEpsilon;
    EXPECT_EQ(moved, !object.IsFixed());
    fixed += object.IsFixed();
  }
  EXPECT_GT(fixed, 10);
  EXPECT_EQ(run.recording.Ints("asleep")[0], 0);
}

TEST(Series, AsleepCountsWhatRests) {
  plan::Scene scene = EngineScene(1, 500);
  SetWorld(scene, "cycles", std::uint64_t{300});
  EXPECT_EQ(RunOne(scene, {0, -225, 0}).Ints("asleep").back(), 1);
  SetWorld(scene, "sleeping", false);
  EXPECT_EQ(RunOne(scene, {0, -225, 0}).Ints("asleep").back(), 0);
}

TEST(Walls, KeepTheObjectsIn) {
  for (const char* shape : {"plane", "box"}) {
    plan::Scene scene = DenseScene();
    SetWorld(scene, "world.wall_shape", Word(shape));
    SetWorld(scene, "acceleration", Vector3d(40, -60, 30));
    SetWorld(scene, "cycles", std::uint64_t{400});
    Recorded run = RunHere(scene);
    const auto escaped = run.recording.Ints("escaped");
    EXPECT_EQ(std::accumulate(escaped.begin(), escaped.end(), 0), 0) << shape;
    EXPECT_GT(run.recording.Ints("contacts").back(), 60) << shape;
  }
}

TEST(Walls, OnlyTheFloorOrNone) {
  plan::Scene scene = EngineScene(1, 500);
  SetWorld(scene, "acceleration", Vector3d(50, -50, 0));
  SetWorld(scene, "cycles", std::uint64_t{400});
  Record(scene, {"poses"});
  const auto last = [&](const char* walls) {
    SetWorld(scene, "world.walls", Word(walls));
    protocol::Recording recording = RunOne(scene, {0, 0, 0});
    const auto pose = recording.Reals("poses").last(protocol::kPoseSize);
    return Vector3d(pose[0], pose[1], pose[2]);
  };
  EXPECT_NEAR(last("floor").y(), -225, 1);
  EXPECT_GT(last("floor").x(), 250);
  EXPECT_LT(last("none").y(), -500);
  EXPECT_NEAR(last("all").x(), 225, 1);
}

TEST(Contacts, StreamIsWhatTheSeriesCount) {
  plan::Scene scene = DenseScene();
  Record(scene, {"contacts", "stability"});
  const int file = memfd_create("contacts", 0);
  Recorded run = RunHere(scene, {.contacts_fd = file});
  ASSERT_TRUE(run.done()) << run.message();
  const auto counts = run.recording.Ints("contacts");
  const int total = std::accumulate(counts.begin(), counts.end(), 0);
  std::vector<protocol::ContactRecord> records(static_cast<std::size_t>(total) + 1);
  const ssize_t bytes = pread(file, records.data(), records.size() * sizeof(records[0]), 0);
  close(file);
  ASSERT_EQ(bytes, static_cast<ssize_t>(total * sizeof(records[0])));
  ASSERT_GT(total, 1000);
  records.pop_back();
  std::size_t at = 0;
  const auto deepest = run.recording.Reals("max_penetration");
  for (std::size_t cycle = 0; cycle < counts.size(); ++cycle) {
    double most = 0;
    for (std::int32_t i = 0; i < counts[cycle]; ++i, ++at) {
      const protocol::ContactRecord& record = records[at];
      EXPECT_NEAR(Eigen::Map<const Vector3d>(record.normal).norm(), 1, 1e-4);
      EXPECT_NE(record.body_a, record.body_b);
      EXPECT_LT(std::max(record.body_a, record.body_b), 66);
      EXPECT_LT(std::min(record.body_a, record.body_b), 60);
      most = std::max(most, -record.distance);
    }
    EXPECT_EQ(deepest[cycle], most);
  }
}

TEST(Contacts, AFileThatCannotBeWrittenFailsTheRun) {
  plan::Scene scene = DenseScene();
  Record(scene, {"contacts"});
  const Recorded run = RunHere(scene, {});
  EXPECT_FALSE(run.done());
  EXPECT_NE(run.message().find("cannot write the contacts"), std::string::npos) << run.message();
}

TEST(Detectors, TakeAsManyBodiesAsTheySay) {
  // The arrays have room for exactly the objects and the six walls; sanitizers detect one more.
  for (const char* detector : {"simple", "sap", "sap32"}) {
    for (const std::uint64_t objects : {1, 2, 63}) {
      plan::Scene scene = EngineScene(objects, 1000);
      SetWorld(scene, "detector", Word(detector));
      EXPECT_TRUE(RunHere(scene).done()) << detector << " " << objects;
    }
  }
}

TEST(Detectors, RefuseMoreThanTheyTake) {
  const btVector3 corner(1000, 1000, 1000);
  const auto make = [&](std::string_view detector, std::size_t bodies) {
    return detection::MakeBroadPhase(
        {.detector = detector, .bodies = bodies, .lower = -corner, .upper = corner});
  };
  EXPECT_THROW(make("sap", 16385), library::SceneError);
  EXPECT_NO_THROW(make("sap", 16384));
  EXPECT_THROW(make("none such", 1), library::SceneError);
}

TEST(Range, WhatPrecisionCannotHoldIsRefusedByName) {
  const auto message = [](auto change) {
    plan::Scene scene = EngineScene(1, 500);
    change(scene);
    const Recorded run = RunHere(scene);
    return run.done() ? std::string() : run.message();
  };
  const double tiny = sizeof(btScalar) == 4 ? 1e-42 : 1e-320;
  EXPECT_NE(message([&](auto& s) { SetGroup(s, "mass", tiny); }).find("the mass of object 1"),
            std::string::npos);
  if (sizeof(btScalar) == 4) {
    EXPECT_NE(message([&](auto& s) { SetGroup(s, "mass", 1e39); }).find("the mass of object 1"),
              std::string::npos);
    EXPECT_NE(message([&](auto& s) {
                SetGroup(s, "linear_velocity", Vector3d(1e39, 0, 0));
              }).find("linear velocity"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace cdb::tests
