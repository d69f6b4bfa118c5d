#include "library/detectors/exact_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/library/detectors/box_scenes.h"

namespace cdb::tests {
namespace {

TEST(ExactPairs, IsBruteForceOnEveryScene) {
  for (const std::string_view name : kBoxScenes) {
    for (const bool walls : {false, true}) {
      BoxScene scene(name, 300, walls);
      for (int cycle = 0; cycle < 5; ++cycle, scene.Move())
        EXPECT_EQ(detectors::ExactPairs(scene.View()), BruteForce(scene.View())) << name;
    }
  }
}

TEST(ExactPairs, BoxesThatAreNotNumbersOverlapNothing) {
  const double nan = NAN;
  const std::vector<Box> boxes = {
      {{0, 0, 0}, {1, 1, 1}}, {{nan, 0, 0}, {1, 1, 1}}, {{1, 1, 1}, {2, 2, 2}}};
  const std::vector<Filter> filters(3);
  const Scene scene = {
      .size = 3, .boxes = boxes, .filters = filters, .poses = {}, .shapes = {}, .is_asleep = {}};
  EXPECT_EQ(detectors::ExactPairs(scene), (std::vector<Pair>{{0, 2}}));
}

TEST(ComparePairs, CountsEachFaultByItself) {
  BoxScene moving("dense", 200);
  const Scene scene = moving.View();
  std::vector<Pair> found = detectors::ExactPairs(scene);
  ASSERT_GT(found.size(), 3u);
  EXPECT_EQ(detectors::ComparePairs(scene, found), (detectors::PairFaults{.exact = found.size()}));
  const std::size_t exact = found.size();
  Pair stranger = {0, 1};
  while (Overlap(scene.boxes[stranger.a], scene.boxes[stranger.b])) ++stranger.b;
  const Pair missed = found.front();
  found.front() = stranger;       // one pair missed, one false positive,
  found.push_back(found.back());  // and one pair listed twice
  found.push_back(stranger);
  EXPECT_EQ(detectors::ComparePairs(scene, found), (detectors::PairFaults{.exact = exact,
                                                                          .missed = 1,
                                                                          .false_positives = 1,
                                                                          .duplicate = 2,
                                                                          .first_missed = missed}));
}

TEST(ComparePairs, DropsPairsThatAreNotAskedFor) {
  BoxScene moving("dense", 200);
  const Scene scene = moving.View();
  const std::vector<Pair> all = detectors::ExactPairs(scene);
  const detectors::PairFilter asked = [](const Pair& pair) { return (pair.a + pair.b) % 2 == 0; };
  std::vector<Pair> even = all;
  std::erase_if(even, [&](const Pair& pair) { return !asked(pair); });
  ASSERT_GT(even.size(), 3u);
  ASSERT_LT(even.size(), all.size());
  EXPECT_EQ(detectors::ExactPairs(scene, asked), even);
  EXPECT_EQ(detectors::ComparePairs(scene, all, asked),
            (detectors::PairFaults{.exact = even.size()}));
}

TEST(OverlapText, NamesBothBoxesAndTheirOverlap) {
  const std::vector<Box> boxes = {{{0, 0, 0}, {1, 1, 1}}, {{0.75, -1, 0.5}, {2, 1, INFINITY}}};
  Scene scene;
  scene.size = 2;
  scene.boxes = boxes;
  EXPECT_EQ(detectors::OverlapText(scene, {0, 1}),
            "bodies 0 and 1, whose boxes (0, 0, 0) to (1, 1, 1) and (0.75, -1, 0.5) to (2, 1, inf) "
            "overlap by 0.25 x 1 x 0.5 m");
}

}  // namespace
}  // namespace cdb::tests
