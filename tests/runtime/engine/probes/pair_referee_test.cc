// The faults that `record pairs` finds in Bullet's detectors; recording them changes no motion.
#include "runtime/engine/probes/pair_referee.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/detector_names.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

/// A gas of 40 balls in a small cube, which approach each other and separate again.
plan::Scene Gas(const char* detector, schema::WordList record) {
  plan::Scene scene = EngineScene(40, 300);
  SetWorld(scene, "cycles", std::uint64_t{40});
  SetWorld(scene, "detector", Word(detector));
  SetWorld(scene, "record", std::move(record));
  SetGroup(scene, "linear_velocity",
           Uniform(Vector3d(Vector3d::Constant(-300)), Vector3d(Vector3d::Constant(300))));
  SeedStreams(scene);
  return scene;
}

std::int64_t Sum(std::span<const std::int32_t> values) {
  return std::accumulate(values.begin(), values.end(), std::int64_t{0});
}

TEST(PairReferee, FindsNothingMissedByBullet) {
  for (const char* detector : {"simple", "sap", "sap32", "dbvt"}) {
    for (const char* walls : {"plane", "box"}) {
      plan::Scene scene = Gas(detector, {"pairs", "counts"});
      SetWorld(scene, "world.wall_shape", Word(walls));
      const Recorded recorded = RunHere(scene);
      ASSERT_TRUE(recorded.done()) << recorded.message();
      const protocol::Recording& got = recorded.recording;
      const auto exact = got.Ints("exact_pairs"), phantom = got.Ints("phantom_pairs"),
                 listed = got.Ints("pairs");
      EXPECT_GT(Sum(exact), 40) << detector << " " << walls << ": nothing to find";
      EXPECT_EQ(Sum(got.Ints("missed_pairs")), 0) << detector << " " << walls;
      EXPECT_EQ(Sum(got.Ints("duplicate_pairs")), 0) << detector << " " << walls;
      EXPECT_EQ(Sum(got.Ints("missed_contacts")), 0) << detector << " " << walls;
      for (std::size_t i = 0; i < exact.size(); ++i)
        EXPECT_EQ(listed[i], exact[i] + phantom[i]) << detector << " in cycle " << i;
      if (scene.world.WordOr("detector") == "simple") {
        EXPECT_EQ(Sum(phantom), 0);
      }
    }
  }
}

TEST(PairReferee, CountsThePhantomsOfATree) {
  const Recorded recorded = RunHere(Gas("dbvt", {"pairs"}));
  ASSERT_TRUE(recorded.done()) << recorded.message();
  EXPECT_GT(Sum(recorded.recording.Ints("phantom_pairs")), 0) << "its boxes are fattened";
}

TEST(PairReferee, SeesAPairThatIsNotThere) {
  plan::Scene scene = Gas("simple", {"pairs"});
  protocol::Recording recording = protocol::Recording::Create(scene);
  world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  probes::PairReferee referee(engine, recording);
  referee.BeforeStep();
  engine.Step();
  referee.AfterStep(0);
  btOverlappingPairCache& cache = *engine.world().getPairCache();
  const btBroadphasePair first = cache.getOverlappingPairArray()[0];
  cache.removeOverlappingPair(first.m_pProxy0, first.m_pProxy1, engine.world().getDispatcher());
  referee.AfterStep(1);
  EXPECT_EQ(recording.Ints("missed_pairs")[0], 0);
  EXPECT_EQ(recording.Ints("missed_pairs")[1], 1);
  EXPECT_EQ(recording.Ints("exact_pairs")[1], recording.Ints("exact_pairs")[0]);
  EXPECT_EQ(recording.Ints("missed_pairs")[2], -1) << "that cycle did not run";
}

/// Lists every pair, and again in reverse.
class Twice final : public Detector {
 public:
  void FindPairs(const cdb::Scene& scene, std::vector<Pair>& pairs) override {
    pairs = detectors::ExactPairs(scene);
    const std::size_t count = pairs.size();
    for (std::size_t i = 0; i < count; ++i) pairs.push_back({pairs[i].b, pairs[i].a});
  }
};

TEST(PairReferee, TakesADetectorsListAsItIs) {
  plan::Scene scene = Gas("dbvt", {"pairs"});
  layouts::InitialState state = layouts::MakeInitialState(scene);
  for (const bool finds : {true, false}) {
    protocol::Recording recording = protocol::Recording::Create(scene);
    detection::Detectors detectors;
    detectors.broad = {
        .name = "test",
        .phases = cdb::kBroad,
        .max_bodies = 0,
        .detector = finds ? std::shared_ptr<Detector>(new Twice) : std::make_shared<Detector>()};
    world::Engine engine(scene, state, omissions::KeepEverything(scene), detectors);
    probes::PairReferee referee(engine, recording);
    for (std::uint64_t cycle = 0; cycle < 40; ++cycle) {
      referee.BeforeStep();
      engine.Step();
      referee.AfterStep(cycle);
    }
    const auto exact = recording.Ints("exact_pairs");
    EXPECT_GT(Sum(exact), 6 * 40 * 40 - 1) << "six planes are met by every ball";
    EXPECT_EQ(Sum(recording.Ints("missed_pairs")), finds ? 0 : Sum(exact));
    EXPECT_EQ(Sum(recording.Ints("duplicate_pairs")), finds ? Sum(exact) : 0);
    EXPECT_EQ(Sum(recording.Ints("phantom_pairs")), 0);
    EXPECT_EQ(Sum(recording.Ints("missed_contacts")) > 0, !finds);
  }
}

TEST(PairReferee, FindsNothingMissedByOurs) {
  for (const std::string& detector : BroadPhases(/*only_own=*/true)) {
    const Recorded recorded = RunHere(Gas(detector.c_str(), {"pairs"}));
    ASSERT_TRUE(recorded.done()) << recorded.message();
    const protocol::Recording& got = recorded.recording;
    EXPECT_GT(Sum(got.Ints("exact_pairs")), 40) << detector;
    for (const schema::IntSeries fault : std::initializer_list<schema::IntSeries>{
             "missed_pairs", "phantom_pairs", "duplicate_pairs"})
      EXPECT_EQ(Sum(got.Ints(fault)), 0) << detector << " " << fault.name();
  }
}

TEST(PairReferee, ComparesContactsWithExactOnes) {
  plan::Scene scene = EngineScene(1, 100);
  SetWorld(scene, "cycles", std::uint64_t{30});
  SetWorld(scene, "record", schema::WordList{"pairs"});
  SetGroup(scene, "linear_velocity", Vector3d(0, -200, 0));
  SetGroup(scene, "size", 10.0);
  SetGroup(scene, "location", Layout("at", {{"x", 0.0}, {"y", -44.0}, {"z", 0.0}}));
  const Recorded recorded = RunHere(scene);
  ASSERT_TRUE(recorded.done()) << recorded.message();
  const auto depth = recorded.recording.Reals("depth_error"),
             normal = recorded.recording.Reals("normal_error");
  EXPECT_EQ(Sum(recorded.recording.Ints("missed_contacts")), 0);
  EXPECT_TRUE(std::isnan(depth[0])) << "it has not landed yet";
  EXPECT_GT(std::ranges::count_if(depth, [](double error) { return error < 1e-5; }), 0);
  EXPECT_GT(std::ranges::count_if(normal, [](double error) { return error < 1e-3; }), 0);
}

/// Two objects without walls, forces or motion, for one cycle: `upper` at `place`, `lower` at the
/// origin.
plan::Scene TwoObjects(const char* upper, double upper_size, const Vector3d& place,
                       const char* lower, double lower_size) {
  plan::Scene scene = EngineScene(1, 10);
  SetWorld(scene, "cycles", std::uint64_t{1});
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(scene, "record", schema::WordList{"pairs"});
  SetGroup(scene, "overlap", true);
  scene.groups.push_back(scene.groups[0]);
  scene.groups[1].name = "lower";
  SetGroup(scene, "type", Word(upper));
  SetGroup(scene, "size", upper_size);
  SetGroup(scene, "location", Layout("at", {{"x", place.x()}, {"y", place.y()}, {"z", place.z()}}));
  SetGroup(scene, "type", Word(lower), 1);
  SetGroup(scene, "size", lower_size, 1);
  SetGroup(scene, "location", Layout("at", {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}}), 1);
  return scene;
}

TEST(PairReferee, SeesTheContactThatBulletMissesAtTheRimOfACylinder) {
  // Bullet rounds the rim by its margin. The ball overlaps it by .061 mm, along the diagonal.
  const double at = 0.135 + (0.05 - 0.061e-3) / std::sqrt(2.0);
  const Recorded recorded = RunHere(TwoObjects("sphere", 0.1, {at, at, 0}, "cylinder", 0.27));
  ASSERT_TRUE(recorded.done()) << recorded.message();
  EXPECT_EQ(recorded.recording.Ints("exact_contacts")[0], 1);
  EXPECT_EQ(recorded.recording.Ints("missed_contacts")[0], 1);
  EXPECT_EQ(recorded.recording.Ints("uncompared_contacts")[0], 0);
}

TEST(PairReferee, CountsWhatItCannotCompare) {
  // Two cylinders about one axis: the depth is equal along every direction of a plane.
  plan::Scene scene = TwoObjects("cylinder", 1, {0, 0, 0}, "cylinder", 1);
  for (std::size_t group : {0, 1})
    SetGroup(scene, "aspect", schema::Ratio{Vector3d(1, 3, 1)}, group);
  const Recorded recorded = RunHere(scene);
  ASSERT_TRUE(recorded.done()) << recorded.message();
  EXPECT_EQ(recorded.recording.Ints("exact_contacts")[0], 0);
  EXPECT_EQ(recorded.recording.Ints("uncompared_contacts")[0], 1);
  EXPECT_EQ(recorded.recording.Ints("missed_contacts")[0], 0);
}

TEST(PairReferee, LooksInAPassOfItsOwnWhereTimesAreTaken) {
  const Recorded timed = RunHere(Gas("dbvt", {"timing", "counts"}));
  const Recorded both = RunHere(Gas("dbvt", {"timing", "counts", "memory", "pairs"}));
  const Recorded untimed = RunHere(Gas("dbvt", {"counts", "pairs"}));
  for (const Recorded* run : {&timed, &both, &untimed}) ASSERT_TRUE(run->done()) << run->message();
  EXPECT_EQ(timed.hash(), both.hash());
  EXPECT_EQ(timed.hash(), untimed.hash());
  EXPECT_TRUE(timed.recording.Ints("exact_pairs").empty());
  for (const schema::IntSeries series : std::initializer_list<schema::IntSeries>{
           "pairs", "exact_pairs", "missed_pairs", "phantom_pairs"})
    EXPECT_TRUE(std::ranges::equal(both.recording.Ints(series), untimed.recording.Ints(series)))
        << series.name();
}

TEST(PairReferee, KeepsDetectionAndIsSilentWithoutIt) {
  plan::Scene scene = EngineScene(2, 1000);
  SetWorld(scene, "cycles", std::uint64_t{5});
  SetWorld(scene, "record", schema::WordList{"pairs"});
  EXPECT_EQ(RunHere(scene).recording.Ints("exact_pairs")[4] >= 0, true);
  SetWorld(scene, "omit", schema::WordList{"detection"});
  SetWorld(scene, "world.walls", Word("none"));
  SetGroup(scene, "location", Layout("line", {{"gap", 50.0}}));
  const Recorded without = RunHere(scene);
  ASSERT_TRUE(without.done()) << without.message();
  EXPECT_EQ(without.recording.Ints("exact_pairs")[4], -1);
}

}  // namespace
}  // namespace cdb::tests
