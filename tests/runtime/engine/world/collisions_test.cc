// Groups that may not collide: exact pairs by every detector, and the results of the probes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "library/scene_error.h"
#include "runtime/engine/probes/pair_referee.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/runtime/engine/paired_run.h"
#include "tests/support/detector_names.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using BodyPairs = std::set<probes::BodyPair>;

schema::Value PointsOf(const std::vector<Vector3d>& points) {
  return schema::Call{"at", {points.begin(), points.end()}};
}

/// Two balls of each group, all of them overlapping; `posts` are fixed.
///   a collides with itself and walls, b with a and posts, c only with walls
plan::Scene Heap(const char* detector) {
  plan::Scene scene = EngineScene(2, 100);
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(scene, "detector", Word(detector));
  SetWorld(scene, "cycles", std::uint64_t{5});
  SetWorld(scene, "record", schema::WordList{"pairs", "stability"});
  SetGroup(scene, "size", 10.0);
  SetGroup(scene, "overlap", true);
  const char* names[] = {"a", "b", "c", "posts"};
  const schema::WordList masks[] = {{"a", "b", "walls"}, {"a", "posts"}, {"walls"}, {"all"}};
  scene.groups.resize(4, scene.groups[0]);
  for (std::size_t i = 0; i < 4; ++i) {
    const double x = static_cast<double>(i);
    scene.groups[i].name = names[i];
    SetGroup(scene, "collides_with", masks[i], i);
    SetGroup(scene, "location", PointsOf({{x, 0, 0}, {x, 1, 0}}), i);
  }
  SetGroup(scene, "mass", Word("fixed"), 3);
  SeedStreams(scene);
  return scene;
}

/// Objects 0 and 1 are of group a, 2 and 3 of b, 4 and 5 of c, 6 and 7 are posts.
const BodyPairs kExpected = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3},
                             {2, 6}, {2, 7}, {3, 6}, {3, 7}};

BodyPairs PairsWithinObjects(world::Engine& engine) {
  BodyPairs pairs;
  btOverlappingPairCache& cache = *engine.world().getPairCache();
  for (int i = 0; i < cache.getNumOverlappingPairs(); ++i) {
    const btBroadphasePair& pair = cache.getOverlappingPairArray()[i];
    const auto index = [](const btBroadphaseProxy* proxy) {
      return static_cast<std::uint32_t>(
          static_cast<const btCollisionObject*>(proxy->m_clientObject)->getUserIndex());
    };
    const auto [a, b] = std::minmax({index(pair.m_pProxy0), index(pair.m_pProxy1)});
    if (b < 8) pairs.insert({a, b});
  }
  return pairs;
}

class CollidesWith : public testing::TestWithParam<std::string> {};

TEST_P(CollidesWith, LeavesExactlyThePairsThatMayTouch) {
  const plan::Scene scene = Heap(GetParam().c_str());
  world::Engine engine = WholeEngine(scene, layouts::MakeInitialState(scene));
  const std::vector<probes::BodyPair> exact = probes::ExactPairs(engine);
  EXPECT_EQ(BodyPairs(exact.begin(), exact.end()), kExpected);
  for (const probes::ExactOverlap& overlap : probes::ExactOverlaps(engine, exact).overlaps)
    EXPECT_TRUE(kExpected.contains(overlap.bodies));
  engine.Step();
  EXPECT_EQ(PairsWithinObjects(engine), kExpected);
}

TEST_P(CollidesWith, IsNoFaultOfTheDetector) {
  const Recorded recorded = RunHere(Heap(GetParam().c_str()));
  ASSERT_TRUE(recorded.done()) << recorded.message();
  for (const schema::IntSeries fault : std::initializer_list<schema::IntSeries>{
           "missed_pairs", "duplicate_pairs", "missed_contacts", "passed"})
    EXPECT_THAT(recorded.recording.Ints(fault), testing::Each(0)) << fault.name();
  // The nine pairs of objects; and pairs of planes with a and c, but not with b.
  EXPECT_GE(recorded.recording.Ints("exact_pairs")[0], 9);
}

INSTANTIATE_TEST_SUITE_P(Detectors, CollidesWith, testing::ValuesIn(BroadPhases()));

TEST(CollidesWithWalls, LetsOthersFallThrough) {
  plan::Scene scene = EngineScene(1, 20);
  SetWorld(scene, "cycles", std::uint64_t{200});
  SetWorld(scene, "record", schema::WordList{"counts", "stability"});
  SetGroup(scene, "size", 2.0);
  SetGroup(scene, "location", PointsOf({{-5, 0, 0}}));
  scene.groups.push_back(scene.groups[0]);
  scene.groups[1].name = "ghosts";
  SetGroup(scene, "location", PointsOf({{5, 0, 0}}), 1);
  SetGroup(scene, "collides_with", schema::WordList{"objects"}, 1);
  SeedStreams(scene);
  for (const char* omit : {"auto", "none"}) {
    SetWorld(scene, "omit", schema::WordList{omit});
    const Recorded recorded = RunHere(scene);
    ASSERT_TRUE(recorded.done()) << recorded.message();
    EXPECT_NEAR(Position(*recorded.engine, 0).y(), -9, 0.01) << omit;
    EXPECT_LT(Position(*recorded.engine, 1).y(), -50) << omit;
    // No wall was supposed to stop it.
    EXPECT_EQ(recorded.recording.Ints("escaped").back(), 0) << omit;
  }
}

TEST(CollidesWithOmissions, MoveAlike) {
  for (const char* detector : {"dbvt", "sap", "grid"}) {
    plan::Scene scene = Heap(detector);
    SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
    SetWorld(scene, "cycles", std::uint64_t{120});
    RunPaired(scene);
    // Far apart, so that many components can be omitted.
    for (std::size_t i = 0; i < 4; ++i) {
      const double x = 12 * static_cast<double>(i);
      SetGroup(scene, "location", PointsOf({{x, 0, 0}, {x, 20, 0}}), i);
      SetGroup(scene, "overlap", false, i);
    }
    SetWorld(scene, "cycles", std::uint64_t{30});
    RunPaired(scene);
  }
}

TEST(CollidesWithLayouts, OverlapOfThoseThatNeverTouchIsNone) {
  plan::Scene scene = Heap("dbvt");
  for (std::size_t i = 0; i < 4; ++i) SetGroup(scene, "overlap", false, i);
  EXPECT_THROW(layouts::MakeInitialState(scene), library::SceneError);
  for (std::size_t i = 0; i < 4; ++i) {
    SetGroup(scene, "quantity", std::uint64_t{1}, i);
    SetGroup(scene, "location", PointsOf({{static_cast<double>(i), 0, 0}}), i);
    SetGroup(scene, "collides_with", schema::WordList{"walls"}, i);
  }
  EXPECT_NO_THROW(layouts::MakeInitialState(scene));
}

}  // namespace
}  // namespace cdb::tests
