// The work of skin in a cycle, counted in boxes and pairs that were read.
#include "library/detectors/builtin/skin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string_view>
#include <vector>

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

}  // namespace
}  // namespace cdb::tests
