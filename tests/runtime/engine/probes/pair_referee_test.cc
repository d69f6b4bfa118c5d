// The faults that `record pairs` finds in Bullet's detectors; recording them changes no motion.
#include "runtime/engine/probes/pair_referee.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>

#include "compiler/plan/input_file.h"
#include "tests/library/exact/oracle.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/detector_names.h"
#include "tests/support/files.h"
#include "tests/support/sanitizers.h"

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
  plan::Scene scene = EngineScene(1, 100);
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
  EXPECT_EQ(recorded.recording.Ints("bullet_contacts")[0], 1);
  EXPECT_EQ(recorded.recording.Ints("bullet_missed_contacts")[0], 1);
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
  EXPECT_EQ(recorded.recording.Ints("bullet_uncompared_contacts")[0], 1);
  EXPECT_EQ(recorded.recording.Ints("missed_contacts")[0], 0);
}

/// What the referee says of the first step of an engine.
struct FirstStep {
  probes::ExactContacts exact;
  probes::NarrowPhaseErrors errors;
  FirstStep(world::Engine& engine, std::uint64_t draw = 0,
            std::size_t most = protocol::kMostComparedContacts) {
    exact = probes::ExactOverlaps(engine, probes::WithWalls(engine, probes::ExactPairs(engine)),
                                  draw, most);
    engine.Step();
    errors = probes::CompareContacts(engine, exact);
  }
};

/// A narrow phase that makes no contact.
class Blind final : public Detector {
 public:
  void FindContacts(const cdb::Scene&, std::span<const Pair>,
                    std::vector<Contact>& found) override {
    found.clear();
  }
  /// Leaves pairs with this body to Bullet.
  explicit Blind(std::optional<Id> left) : left_(left) {}
  bool Handles(const cdb::Scene&, Id a, Id b) const override { return left_ != a && left_ != b; }

 private:
  const std::optional<Id> left_;
};

TEST(PairReferee, TellsWhoMissedAContact) {
  const plan::Scene scene = TwoObjects("cuboid", 1, {0.2, 0.9, 0.1}, "cuboid", 1);
  const auto errors_of = [&](std::shared_ptr<Detector> broad, std::shared_ptr<Detector> narrow) {
    detection::Detectors detectors;
    if (broad != nullptr) detectors.broad = {"broad", cdb::kBroad, 0, broad};
    if (narrow != nullptr) detectors.narrow = {"narrow", cdb::kNarrow, 0, narrow};
    world::Engine engine(scene, layouts::MakeInitialState(scene), omissions::KeepEverything(scene),
                         detectors);
    const FirstStep step(engine);
    EXPECT_EQ(step.exact.overlaps.size(), 1u);
    return step.errors;
  };
  const auto found = errors_of(std::make_shared<Twice>(), nullptr);
  EXPECT_EQ(found.missed, 0);
  EXPECT_EQ(found.bullet, 1) << "a detector without a narrow phase";
  const auto blind = errors_of(std::make_shared<Twice>(), std::make_shared<Blind>(std::nullopt));
  EXPECT_EQ(blind.missed, 1);
  EXPECT_EQ(blind.bullet + blind.unlisted, 0);
  const auto left = errors_of(std::make_shared<Twice>(), std::make_shared<Blind>(0));
  EXPECT_EQ(left.missed, 0);
  EXPECT_EQ(left.bullet, 1) << "the detector leaves the pair to Bullet";
  const auto unlisted = errors_of(std::make_shared<Detector>(), nullptr);
  EXPECT_EQ(unlisted.missed, 1);
  EXPECT_EQ(unlisted.unlisted, 1) << "no narrow phase was asked";
  EXPECT_EQ(unlisted.bullet, 0);
}

TEST(PairReferee, DrawsSomeOfManyOverlaps) {
  plan::Scene scene = EngineScene(60, 100);
  SetWorld(scene, "world.walls", Word("none"));
  SetGroup(scene, "overlap", true);
  SetGroup(scene, "size", 4.0);
  SetGroup(scene, "location", Layout("grid", {{"spacing", 3.0}}));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const auto bodies_of = [&](std::uint64_t draw, std::size_t most, std::size_t& uncompared) {
    world::Engine engine = WholeEngine(scene, state);
    const FirstStep step(engine, draw, most);
    uncompared = step.exact.uncompared.size();
    std::set<probes::BodyPair> bodies;
    for (const auto& overlap : step.exact.overlaps) bodies.insert(overlap.bodies);
    return bodies;
  };
  std::size_t rest = 0;
  const auto all = bodies_of(1, protocol::kMostComparedContacts, rest);
  ASSERT_GT(all.size(), 100u);
  EXPECT_EQ(rest, 0u);
  const auto some = bodies_of(1, 50, rest);
  EXPECT_EQ(some.size(), 50u);
  EXPECT_EQ(rest, all.size() - 50);
  EXPECT_TRUE(std::ranges::includes(all, some));
  EXPECT_EQ(bodies_of(1, 50, rest), some);
  EXPECT_NE(bodies_of(2, 50, rest), some);
}

/// Every type of object; the last two are fixed.
std::vector<schema::Value> Types(const TemporaryFolder& folder) {
  std::vector<schema::Value> types;
  for (const char* type :
       {"sphere", "cuboid", "cylinder", "cone", "capsule", "tetrahedron", "torus"})
    types.push_back(Word(type));
  const std::string hill =
      "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1 0\nf 5 2 1\nf 5 3 2\n"
      "f 5 4 3\nf 5 1 4\n";
  const std::string heights = "0,0,0\n0,1,0\n0,0,0\n";
  WriteFile(folder / "hill.obj", hill);
  WriteFile(folder / "hill.csv", heights);
  types.push_back(Layout("surface", {{"file", schema::Text{(folder / "hill.obj").string()}},
                                     {"sha256", schema::Text{plan::Sha256Hex(hill)}}}));
  types.push_back(Layout("heights", {{"file", schema::Text{(folder / "hill.csv").string()}},
                                     {"sha256", schema::Text{plan::Sha256Hex(heights)}}}));
  return types;
}

TEST(PairReferee, ComparesEveryPairOfTypes) {
  const TemporaryFolder folder;
  const std::vector<schema::Value> types = Types(folder);
  distributions::Stream stream(11);
  for (std::size_t i = 0; i < 7; ++i) {
    for (std::size_t j = i; j < types.size(); ++j) {
      SCOPED_TRACE(testing::Message() << "types " << i << " and " << j);
      plan::Scene scene = TwoObjects("sphere", 1, {0, 9, 0}, "sphere", 1);
      SetGroup(scene, "type", types[i]);
      SetGroup(scene, "type", types[j], 1);
      SetGroup(scene, "size", 2.0, 1);
      SetGroup(scene, "aspect", schema::Ratio{Vector3d(1, 1.3, 0.7)});
      if (j >= 7) SetGroup(scene, "mass", Word("fixed"), 1);
      layouts::InitialState state = layouts::MakeInitialState(scene);
      auto &a = state.objects[0], &b = state.objects[1];
      a.pose.orientation = stream.Turn();
      if (j < 7) b.pose.orientation = stream.Turn();
      // Down onto the other, until the first overlaps it by one to five hundredths.
      const Vector3d side(stream.Uniform(-0.2, 0.2), 0, stream.Uniform(0.2, 0.4));
      const auto gap_at = [&](double height) {
        a.pose.position = b.pose.position + side + Vector3d(0, height, 0);
        return exact::DistanceOf(a.solid, a.pose, b.solid, b.pose).lower;
      };
      double height = 4;
      for (double gap = gap_at(height); gap > -0.01; gap = gap_at(height))
        height -= std::max(gap, 0.02);
      for (const bool is_apart : {false, true}) {
        if (is_apart) gap_at(height + 0.2);
        world::Engine engine = WholeEngine(scene, state);
        const objects::Pose poses[] = {{Position(engine, 0), Orientation(engine, 0)},
                                       {Position(engine, 1), Orientation(engine, 1)}};
        const auto overlaps = FirstStep(engine).exact.overlaps;
        ASSERT_EQ(overlaps.size(), is_apart ? 0u : 1u);
        // The search is code of the tests; between the many pieces of tori, sanitizers take
        // minutes.
        if (kAddressSanitizer && (i == 6 || j == 6)) continue;
        const OracleGap exact = SearchedGap(a.solid, poses[0], b.solid, poses[1]);
        ASSERT_EQ(exact.gap > 0, is_apart);
        if (is_apart) continue;
        const double wide = 1e-6 + 10 * kEpsilon;
        EXPECT_NEAR(overlaps[0].depth, -exact.gap, wide);
        double along = INFINITY;  // of the pieces that it is the normal of
        for (std::size_t k = 0; k < a.solid.PieceCount(); ++k)
          for (std::size_t l = 0; l < b.solid.PieceCount(); ++l) {
            const double gap =
                GapAlong({a.solid, poses[0], k}, {b.solid, poses[1], l}, overlaps[0].normal);
            if (std::fabs(gap - exact.gap) < std::fabs(along - exact.gap)) along = gap;
          }
        EXPECT_NEAR(along, exact.gap, wide);
      }
    }
  }
}

TEST(PairReferee, ComparesEveryTypeWithWalls) {
  const TemporaryFolder folder;
  distributions::Stream stream(12);
  constexpr double kDepth = 0.03;
  for (const char* wall_shape : {"plane", "box"}) {
    for (const schema::Value& type : Types(folder)) {
      plan::Scene scene = EngineScene(1, 20);
      SetWorld(scene, "world.wall_shape", Word(wall_shape));
      SetWorld(scene, "record", schema::WordList{"pairs"});
      SetGroup(scene, "type", type);
      SetGroup(scene, "size", 2.0);
      SetGroup(scene, "location", Layout("at", {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}}));
      if (!std::holds_alternative<schema::Word>(type))
        continue;  // surfaces are fixed, as walls are
      SCOPED_TRACE(testing::Message() << std::get<schema::Word>(type).text << ' ' << wall_shape);
      layouts::InitialState state = layouts::MakeInitialState(scene);
      layouts::ObjectState& object = state.objects[0];
      object.pose.orientation = stream.Turn();
      double below = 0;  // the lowest point, from the centre
      for (std::size_t piece = 0; piece < object.solid.PieceCount(); ++piece)
        below = std::max(
            below, HeightOf(object.solid, piece, object.pose.orientation, -Vector3d::UnitY()));
      for (const double depth : {kDepth, -kDepth}) {
        object.pose.position = {1, -10 + below - depth, 2};
        world::Engine engine = WholeEngine(scene, state);
        const auto overlaps = FirstStep(engine).exact.overlaps;
        ASSERT_EQ(overlaps.size(), depth > 0 ? 1u : 0u);
        if (depth < 0) continue;
        EXPECT_NEAR(overlaps[0].depth, depth, 1e-9 + 20 * kEpsilon * 10);
        EXPECT_NEAR((overlaps[0].normal - Vector3d::UnitY()).norm(), 0, 1e-6);
        EXPECT_EQ(overlaps[0].bodies.first, 0u);
      }
    }
  }
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
