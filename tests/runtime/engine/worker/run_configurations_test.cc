// Configurations in the worker: hits against brute force that uses no engine, and repeatability.
#include "runtime/engine/worker/run_configurations.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "library/exact/signed_distance.h"
#include "library/objects/distance.h"
#include "library/robots/kinematic_tree.h"
#include "tests/library/robots/arm_scene.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/detector_names.h"

namespace cdb::tests {
namespace {

Recorded CheckHere(const plan::Scene& scene) {
  plan::Run run;
  run.scene = scene;
  Recorded recorded{protocol::Recording::Create(scene), nullptr};
  worker::RunConfigurations(run, recorded.recording, {});
  return recorded;
}

/// Three links on a fixed foot, which may hit each other, a pillar, rods and a ball. `settings`
/// are those of the benchmark.
std::string Arm(const std::string& settings) {
  return fmt::format(
      "benchmark b {{ precision {}; world.side 6\n{}\n"
      "objects foot {{ type cuboid; size 0.4; mass fixed; location at(0, 0, 0) }}\n"
      "objects upper {{ type capsule; aspect 1 : 6 : 1; size 0.1; overlap on\n"
      "  location relative_to(foot, (0, 0.55, 0)) }}\n"
      "objects fore {{ type cuboid; aspect 1 : 7 : 1; size 0.1; overlap on\n"
      "  location relative_to(upper, (0, 0.7, 0)) }}\n"
      "objects hand {{ type cylinder; aspect 1 : 2 : 1; size 0.2; overlap on\n"
      "  location relative_to(fore, (0, 0.5, 0)) }}\n"
      "joints shoulder {{ parent foot; child upper; at (0, 0.25, 0); axis (1, 0, 0.3)\n"
      "  limits {{ lower -2.2; upper 2.2 }} }}\n"
      "joints elbow {{ parent upper; child fore; at (0, 0.35, 0); axis (0, 0.2, 1)\n"
      "  limits {{ lower -2.9; upper 2.9 }} }}\n"
      "joints wrist {{ parent fore; child hand; at (0, 0.4, 0); axis (1, 0, 0)\n"
      "  limits {{ lower -2.5; upper 2.5 }} }}\n"
      "objects pillar {{ type cuboid; aspect 1 : 5 : 1; size 0.4; mass fixed; location at(1, 0, "
      "0)\n"
      "  orientation (0, 0.4, 0.1) }}\n"
      "objects rods {{ quantity 3; type capsule; aspect 1 : 4 : 1; size 0.2; mass fixed\n"
      "  location at((-0.9, 0.3, 0.5), (0.2, 0.9, -1), (0, 1.7, 0.4)); orientation (0.8, 0, 0.5) "
      "}}\n"
      "objects ball {{ type sphere; size 0.7; mass fixed; location at(-0.5, 1.1, -0.6) }} }}\n",
      world::EnginePrecision(), settings);
}

/// The pairs of objects that may hit in Arm: links that are not joined, and links with the rest.
constexpr std::pair<std::size_t, std::size_t> kSelf[] = {{0, 2}, {0, 3}, {1, 3}};

struct Truth {
  int self = 0, scene = 0;     ///< pairs that overlap by more than `kMargin`
  bool is_open = false;        ///< some pair is closer to touching
  double distance = HUGE_VAL;  ///< the least
};
constexpr double kMargin = 1e-4;

Truth TruthOf(const layouts::InitialState& state, const std::vector<objects::Pose>& poses) {
  Truth truth;
  const auto add = [&](std::size_t a, std::size_t b, int& count) {
    const exact::SignedDistance distance =
        exact::DistanceOf(state.objects[a].solid, poses[a], state.objects[b].solid, poses[b]);
    count += distance.upper < -kMargin;
    truth.is_open = truth.is_open || (distance.upper >= -kMargin && distance.lower <= kMargin);
    truth.distance = std::min(truth.distance, std::max(0.0, distance.gap));
  };
  for (const auto& [a, b] : kSelf) add(a, b, truth.self);
  for (std::size_t a = 1; a <= 3; ++a)
    for (std::size_t b = 4; b < state.objects.size(); ++b) add(a, b, truth.scene);
  return truth;
}

TEST(Configurations, HitWhereBruteForceSaysSo) {
  constexpr std::size_t kCount = 300;
  plan::Scene scene =
      SceneOfText(Arm(fmt::format("configurations.positions uniform; cycles {}", kCount)));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  ASSERT_EQ(state.objects.size(), 9u);
  const robots::KinematicTree tree(scene, state);
  const std::vector<double> positions = robots::PositionsOf(scene);
  std::vector<Truth> truths;
  std::vector<objects::Pose> poses;
  for (std::size_t i = 0; i < kCount; ++i) {
    tree.PosesAt(std::span(positions).subspan(3 * i, 3), poses);
    truths.push_back(TruthOf(state, poses));
  }
  // Bullet misses an overlap now and then.
  for (const auto& [narrow_phase, most_missed] : {std::pair{"batch", 0}, {"own", 4}}) {
    SetWorld(scene, "narrow_phase", Word(narrow_phase));
    const Recorded run = CheckHere(scene);
    ASSERT_TRUE(run.done()) << run.message();
    int hits = 0, with_self = 0, compared = 0, missed = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
      const Truth& truth = truths[i];
      if (truth.is_open) continue;
      ++compared;
      const std::int32_t self = run.recording.Ints("self_hits")[i],
                         of_scene = run.recording.Ints("scene_hits")[i];
      EXPECT_LE(self, truth.self) << i;
      EXPECT_LE(of_scene, truth.scene) << i;
      missed += truth.self - self + truth.scene - of_scene;
      EXPECT_EQ(run.recording.Ints("hit")[i], self + of_scene > 0) << i;
      hits += truth.self + truth.scene > 0;
      with_self += truth.self > 0;
    }
    EXPECT_LE(missed, most_missed) << narrow_phase;
    EXPECT_GT(compared, 290);
    EXPECT_GT(hits, 50);
    EXPECT_LT(hits, 250);
    EXPECT_GT(with_self, 10);
  }
}

TEST(Configurations, AreJudgedByTheReferee) {
  const plan::Scene scene = SceneOfText(
      Arm("configurations { positions uniform; ask distance }; cycles 100; record counts, pairs"));
  const Recorded run = CheckHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const robots::KinematicTree tree(scene, state);
  const std::vector<double> positions = robots::PositionsOf(scene);
  std::vector<objects::Pose> poses;
  int certain = 0;
  for (std::size_t i = 0; i < 100; ++i) {
    tree.PosesAt(std::span(positions).subspan(3 * i, 3), poses);
    const Truth truth = TruthOf(state, poses);
    const std::int32_t exact = run.recording.Ints("exact_hit")[i];
    if (!truth.is_open) {
      EXPECT_EQ(exact, truth.self + truth.scene > 0) << i;
      ++certain;
    }
    EXPECT_NEAR(run.recording.Reals("least_distance")[i], truth.distance, 1e-9) << i;
    EXPECT_LT(run.recording.Reals("distance_error")[i], 1e-9) << i;
    EXPECT_EQ(run.recording.Ints("missed_contacts")[i], 0) << i;
  }
  EXPECT_GT(certain, 95);
}

TEST(Configurations, AreTheSameAgainAndWithEveryDetector) {
  std::string hash;
  for (const std::string& detector : BroadPhases()) {
    plan::Scene scene = SceneOfText(Arm("configurations.positions uniform; cycles 60"));
    SetWorld(scene, "detector", Word(detector));
    for (int again = 0; again < 2; ++again) {
      const Recorded run = CheckHere(scene);
      ASSERT_TRUE(run.done()) << detector << ": " << run.message();
      if (hash.empty()) hash = run.hash();
      EXPECT_EQ(run.hash(), hash) << detector;
    }
  }
}

// Contacts of one configuration must not remain in the next.
TEST(Configurations, DoNotDependOnThoseBefore) {
  const auto hits_of = [](const std::string& settings) {
    const Recorded run = CheckHere(SceneOfText(Arm(settings)));
    EXPECT_TRUE(run.done()) << run.message();
    const auto counts = run.recording.Ints("scene_hits");
    const auto contacts = run.recording.Ints("contacts");
    std::vector<std::int32_t> all(counts.begin(), counts.end());
    all.insert(all.end(), contacts.begin(), contacts.end());
    return all;
  };
  const std::string path = "configurations.positions path; shoulder.goal 2; elbow.goal -2; ";
  const std::vector<std::int32_t> along = hits_of(path + "cycles 101");
  const std::vector<std::int32_t> warm = hits_of(path + "cycles 101; warmup 57");
  EXPECT_EQ(along, warm);
  EXPECT_GT(std::ranges::count_if(along, [](std::int32_t count) { return count > 0; }), 10);
}

TEST(Configurations, ByLanesAreThoseOfBalls) {
  const plan::Scene scene = SceneOfText(
      BallArm(fmt::format("configurations.by lanes; record timing, counts, pairs; cycles 200\n"
                          "precision {}",
                          world::EnginePrecision())));
  const Recorded run = CheckHere(scene);
  ASSERT_TRUE(run.done()) << run.message();
  const auto hits = run.recording.Ints("hit"), exact = run.recording.Ints("exact_hit");
  for (std::size_t i = 0; i < 200; ++i) EXPECT_EQ(hits[i], exact[i]) << i;
  EXPECT_GT(std::ranges::count(hits, 1), 20);
  EXPECT_GT(std::ranges::count(hits, 0), 20);
  const auto duration = run.recording.Reals("duration");
  for (std::size_t i = 0; i < 200; ++i)
    EXPECT_GT(duration[protocol::IndexOf(protocol::Phase::kStep) * 200 + i], 0);
  EXPECT_EQ(CheckHere(scene).hash(), run.hash());
}

}  // namespace
}  // namespace cdb::tests
