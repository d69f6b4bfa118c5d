// The work of skin in a cycle, counted in boxes and pairs that were read.
#include "library/detectors/builtin/skin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <string_view>
#include <vector>

#include "library/detectors/exact_pairs.h"
#include "tests/library/detectors/box_scenes.h"

namespace cdb::tests {
namespace {

/// The work of each cycle except the first, which has to build a list.
std::vector<double> WorkOf(std::string_view scene, std::size_t bodies, int cycles) {
  BoxScene moving(scene, bodies);
  builtin::Skin skin({});
  std::vector<double> work;
  for (int cycle = 0; cycle < cycles; ++cycle, moving.Move()) {
    Listed(skin, moving.View());
    if (cycle > 0) work.push_back(skin.Work());
  }
  std::ranges::sort(work);
  return work;
}

TEST(SkinWork, IsSpreadOverCyclesSoThatNoneTakesMuchLongerThanOthers) {
  for (const std::string_view scene : kBoxScenes) {
    if (scene == "asleep") continue;  // no work at all
    for (const std::size_t bodies : {1000u, 3000u}) {
      const std::vector<double> work = WorkOf(scene, bodies, 400);
      EXPECT_LE(work.back(), 3.9 * work[work.size() / 2]) << scene << ", " << bodies;
      EXPECT_LE(work[work.size() * 99 / 100], 3.4 * work[work.size() / 2])
          << scene << ", " << bodies;
    }
  }
}

TEST(SkinWork, GrowsWithTheBodies) {
  const auto grows = [](std::string_view scene, std::size_t from, std::size_t to) {
    const auto sum = [&](std::size_t bodies) {
      const std::vector<double> work = WorkOf(scene, bodies, 60);
      return std::accumulate(work.begin(), work.end(), 0.);
    };
    const double factor = static_cast<double>(to) / static_cast<double>(from);
    EXPECT_LE(std::log(sum(to) / sum(from)) / std::log(factor), 1.05) << scene;
  };
  for (const std::string_view scene : {"sparse", "dense", "cluster"}) grows(scene, 1000, 16000);
  grows("swarms", 16000, 64000);  // from the size at which cells become crowds
}

/// A probe that circles over a layer of 1000 bodies at rest.
class Probed {
 public:
  explicit Probed(bool are_fixed) : is_asleep_(kBodies + 1, 1) {
    for (std::size_t i = 0; i < kBodies; ++i)
      boxes_.Add(Cube(double(i % 32), double(i / 32), 0, 0.6), {.is_fixed = are_fixed});
    boxes_.Add(Cube(0, 0, 0, 1));
    is_asleep_.back() = 0;
  }
  void Move(int cycle) {
    boxes_.boxes.back() = Cube(16 + 10 * std::cos(0.02 * cycle), 16 + 10 * std::sin(0.02 * cycle),
                               std::sin(0.1 * cycle), 1);
  }
  Scene View() const {
    Scene scene = boxes_.View();
    scene.is_asleep = is_asleep_;
    return scene;
  }
  static constexpr Id kBodies = 1000;

 private:
  Boxes boxes_;
  std::vector<std::uint8_t> is_asleep_;
};

TEST(SkinWork, IsSpreadWhereOneBodyMovesAmongAThousand) {
  for (const bool are_fixed : {true, false}) {
    Probed probed(are_fixed);
    builtin::Skin skin({});
    std::set<Pair> pairs;
    std::vector<double> work;
    for (int cycle = 0; cycle < 3000; ++cycle) {
      probed.Move(cycle);
      std::vector<Pair> came, went;
      if (!skin.FindChanges(probed.View(), came, went)) pairs.clear();
      for (const Pair& pair : went) pairs.erase(pair);
      pairs.insert(came.begin(), came.end());
      ASSERT_EQ(std::vector(pairs.begin(), pairs.end()), detectors::ExactPairs(probed.View()))
          << "cycle " << cycle;
      if (cycle > 1) work.push_back(skin.Work());
    }
    std::ranges::sort(work);
    EXPECT_LE(work.back(), work.front() + 1.0 * Probed::kBodies) << "fixed: " << are_fixed;
  }
}

}  // namespace
}  // namespace cdb::tests
