// Queries of scenes in Bullet: they change no motion, cdb's tree answers them exactly, and the
// referee finds what Bullet gets wrong.
#include "runtime/engine/scene_queries/queries.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using schema::QueryType;

/// 60 objects of every shape that has a closed form, which fly through a small cube and collide.
plan::Scene Room(schema::WordList record, std::uint64_t cycles = 12) {
  plan::Scene scene = EngineScene(60, 20);
  SetWorld(scene, "cycles", cycles);
  SetWorld(scene, "record", std::move(record));
  schema::Distribution types{schema::DistributionKind::kAny, {}, {}};
  for (const char* type : {"sphere", "cuboid", "cylinder", "cone", "capsule", "tetrahedron"}) {
    types.arguments.push_back(Word(type));
    types.weights.push_back(1);
  }
  SetGroup(scene, "type", types);
  SetGroup(scene, "size", 1.5);
  SetGroup(scene, "orientation", Word("random"));
  SetGroup(scene, "linear_velocity",
           Uniform(Vector3d(Vector3d::Constant(-20)), Vector3d(Vector3d::Constant(20))));
  SeedStreams(scene);
  return scene;
}

plan::GroupSettings& Add(plan::Scene& scene, const char* name, const char* type,
                         const char* implementation, std::uint64_t count = 200) {
  plan::GroupSettings& settings = scene.queries.emplace_back(plan::Queries{name, {}}).settings;
  settings.Set("queries.type", Word(type));
  settings.Set("queries.implementation", Word(implementation));
  settings.Set("queries.count", count);
  SeedStreams(scene);
  return settings;
}

/// The values of one type of queries.
template <typename T>
std::span<const T> OfType(std::span<const T> values, QueryType type) {
  const std::size_t cycles = values.size() / protocol::kQueryTypeCount;
  return values.subspan(static_cast<std::size_t>(type) * cycles, cycles);
}
std::int64_t TotalOf(std::span<const std::int32_t> values) {
  return std::accumulate(values.begin(), values.end(), std::int64_t{0});
}
double Largest(std::span<const double> values) {
  double largest = 0;
  for (const double value : values) largest = std::fmax(largest, value);
  return largest;
}

constexpr const char* kTypes[] = {"ray", "sweep", "overlap", "nearest"};

TEST(Queries, ChangeNoMotion) {
  for (const char* detector : {"dbvt", "sap", "simple", "auto"}) {
    plan::Scene scene = Room({"timing", "counts", "stability"});
    SetWorld(scene, "detector", Word(detector));
    SetWorld(scene, "pair_order", Word("sorted"));
    const Recorded without = RunHere(scene);
    ASSERT_TRUE(without.done()) << without.message();
    for (const char* type : kTypes) {
      if (std::string_view(type) != "nearest") Add(scene, type, type, "bullet", 50);
      Add(scene, (std::string(type) + "_by_tree").c_str(), type, "tree", 50);
    }
    const Recorded with = RunHere(scene);
    ASSERT_TRUE(with.done()) << with.message();
    EXPECT_EQ(with.hash(), without.hash()) << detector;
    EXPECT_GT(TotalOf(with.recording.Ints("query_hits")), 100);
    for (const double time : with.recording.Reals("query_time")) EXPECT_GT(time, 0);
  }
}

TEST(Queries, AreAnsweredExactlyByTheTree) {
  for (const char* walls : {"plane", "box"})
    for (const char* hits : {"closest", "any", "all"}) {
      plan::Scene scene = Room({"query_errors", "counts"});
      SetWorld(scene, "world.wall_shape", Word(walls));
      for (const char* type : kTypes) {
        plan::GroupSettings& block = Add(scene, type, type, "tree");
        if (std::string_view(type) != "nearest") block.Set("queries.hits", Word(hits));
      }
      const Recorded recorded = RunHere(scene);
      ASSERT_TRUE(recorded.done()) << recorded.message();
      for (std::size_t i = 0; i < protocol::kQueryTypeCount; ++i) {
        const auto type = static_cast<QueryType>(i);
        const auto counts = [&](schema::IntSeries series) {
          return TotalOf(OfType(std::as_const(recorded.recording).Ints(series), type));
        };
        EXPECT_GT(counts("query_hits"), 50) << kTypes[i];
        EXPECT_GT(counts("compared_queries"), 1000) << kTypes[i];
        EXPECT_EQ(counts("missed_hits"), 0) << kTypes[i] << " " << hits << " " << walls;
        EXPECT_EQ(counts("false_hits"), 0) << kTypes[i] << " " << hits << " " << walls;
        const double error =
            Largest(OfType(std::as_const(recorded.recording).Reals("hit_error"), type));
        EXPECT_LT(error, kIsSingle ? 1e-2 : 1e-9) << kTypes[i] << " " << hits << " " << walls;
      }
    }
}

TEST(Queries, AreRepeatableToTheBit) {
  plan::Scene scene = Room({"queries"});
  for (const char* type : kTypes) Add(scene, type, type, "tree", 100);
  Add(scene, "other", "ray", "bullet", 100);
  const Recorded one = RunHere(scene), other = RunHere(scene);
  ASSERT_TRUE(one.done() && other.done()) << one.message();
  const auto a = one.recording.Reals("answers"), b = other.recording.Reals("answers");
  ASSERT_EQ(a.size(), 12 * 500 * protocol::kAnswerSize);
  std::size_t found = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_TRUE(a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i])));
    found += !std::isnan(a[i]);
  }
  EXPECT_GT(found, a.size() / 10);
}

TEST(Queries, AreAskedInEveryNthCycle) {
  plan::Scene scene = Room({"counts", "queries"}, 7);
  Add(scene, "seldom", "ray", "tree", 30).Set("queries.every", std::uint64_t{3});
  const Recorded recorded = RunHere(scene);
  ASSERT_TRUE(recorded.done()) << recorded.message();
  const auto counts =
      OfType(std::as_const(recorded.recording).Ints("query_count"), QueryType::kRay);
  EXPECT_EQ(std::vector(counts.begin(), counts.end()), (std::vector{30, 0, 0, 30, 0, 0, 30}));
}

/// Objects at rest, whose boxes are those of their poses.
plan::Scene AtRest(schema::WordList record) {
  plan::Scene scene = Room(std::move(record), 3);
  SetGroup(scene, "linear_velocity", Vector3d(Vector3d::Zero()));
  SetWorld(scene, "acceleration", Vector3d(Vector3d::Zero()));
  return scene;
}

TEST(Queries, AreAnsweredByBulletAboutAsExactly) {
  plan::Scene scene = AtRest({"query_errors"});
  for (const char* type : {"ray", "sweep", "overlap"}) Add(scene, type, type, "bullet", 500);
  const Recorded recorded = RunHere(scene);
  ASSERT_TRUE(recorded.done()) << recorded.message();
  for (const QueryType type : {QueryType::kRay, QueryType::kSweep, QueryType::kOverlap}) {
    const auto counts = [&](schema::IntSeries series) {
      return TotalOf(OfType(std::as_const(recorded.recording).Ints(series), type));
    };
    const char* name = kTypes[static_cast<std::size_t>(type)];
    EXPECT_GT(counts("compared_queries"), 1200) << name;
    EXPECT_LT(counts("missed_hits"), 40) << name;
    EXPECT_LT(counts("false_hits"), 40) << name;
    // In sizes of 1.5 m: btSubsimplexConvexCast is inexact.
    EXPECT_LT(Largest(OfType(std::as_const(recorded.recording).Reals("hit_error"), type)), 0.5)
        << name;
  }
}

/// Bullet's boxes are of the start of the step, but reach to the poses that it predicts for the
/// end.
TEST(Queries, FindFastBodiesWhereBulletPredictsThem) {
  plan::Scene scene = Room({"query_errors"}, 4);
  SetGroup(scene, "linear_velocity", Vector3d(100, 0, 0));
  Add(scene, "sight", "ray", "bullet", 1000);
  const auto missed_by = [&](const char* detector) {
    SetWorld(scene, "detector", Word(detector));
    const Recorded recorded = RunHere(scene);
    EXPECT_TRUE(recorded.done()) << recorded.message();
    return TotalOf(recorded.recording.Ints("missed_hits"));
  };
  const std::int64_t by_all = missed_by("simple");
  EXPECT_LT(by_all, 20) << "it asks every body, whatever its box";
  for (const char* detector : {"dbvt", "sap", "auto"})
    EXPECT_LE(missed_by(detector), by_all + 10) << detector;
}

TEST(Queries, KeepTheTreeOfSweepAndPrune) {
  plan::Scene scene = AtRest({"counts"});
  SetWorld(scene, "detector", Word("sap32"));
  const auto hits_of = [](const Recorded& recorded) {
    const auto hits = recorded.recording.Ints("query_hits");
    return std::vector(hits.begin(), hits.end());
  };
  using schema::Component;
  Add(scene, "sight", "ray", "tree");
  const Recorded by_tree = RunHere(scene);
  ASSERT_TRUE(by_tree.done()) << by_tree.message();
  EXPECT_TRUE(by_tree.engine->omissions().Omits(Component::kRaycastTree));
  EXPECT_FALSE(by_tree.engine->omissions().Omits(Component::kWalls));
  scene.queries.clear();
  Add(scene, "sight", "ray", "bullet");
  const Recorded by_sap = RunHere(scene);
  ASSERT_TRUE(by_sap.done()) << by_sap.message();
  EXPECT_FALSE(by_sap.engine->omissions().Omits(Component::kRaycastTree));
  SetWorld(scene, "detector", Word("dbvt"));
  EXPECT_EQ(hits_of(by_sap), hits_of(RunHere(scene)));
}

TEST(Queries, FindCompounds) {
  plan::Scene scene = AtRest({"query_errors", "counts"});
  SetGroup(scene, "type", Word("bunny"));
  SetGroup(scene, "quantity", std::uint64_t{10});
  SetGroup(scene, "size", 3.0);
  for (const char* type : kTypes) Add(scene, type, type, "tree");
  const Recorded recorded = RunHere(scene);
  if (recorded.message().find("is not on this machine") != std::string::npos)
    GTEST_SKIP() << recorded.message();
  ASSERT_TRUE(recorded.done()) << recorded.message();
  EXPECT_EQ(TotalOf(recorded.recording.Ints("missed_hits")), 0);
  EXPECT_EQ(TotalOf(recorded.recording.Ints("false_hits")), 0);
  EXPECT_GT(TotalOf(recorded.recording.Ints("query_hits")), 500);
}

}  // namespace
}  // namespace cdb::tests
