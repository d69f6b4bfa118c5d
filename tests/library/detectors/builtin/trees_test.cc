#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "library/detectors/builtin/kd_tree.h"
#include "library/detectors/builtin/octree.h"
#include "tests/library/detectors/box_scenes.h"

namespace cdb::tests {
namespace {

using Make = Detector* (*)(const Options&);

class Trees : public testing::TestWithParam<Make> {};

TEST_P(Trees, FindJustThePairsOfEveryScene) {
  for (const std::string_view name : kBoxScenes) {
    for (const bool walls : {false, true}) {
      BoxScene moving(name, 400, walls);
      const std::unique_ptr<Detector> detector(GetParam()({}));
      detector->Prepare(moving.View());
      for (int cycle = 0; cycle < 10; ++cycle, moving.Move())
        ASSERT_EQ(SortedPairs(*detector, moving.View()), BruteForce(moving.View()))
            << name << " cycle " << cycle;
    }
  }
}

TEST_P(Trees, FindJustThePairsOfBoxesOfAnyKind) {
  std::mt19937_64 random(7);
  const double corners[] = {-1e30, -3, -1, -0.5, 0, 0, 0.5, 1, 1, 3, 1e6, 1e30, INFINITY, NAN};
  std::uniform_int_distribution<std::size_t> pick(0, std::size(corners) - 1);
  for (int round = 0; round < 300; ++round) {
    Boxes bodies(std::vector<Box>(40));
    for (Box& box : bodies.boxes)
      for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
        double a = corners[pick(random)], b = round % 2 == 0 ? a : corners[pick(random)];
        if (b < a) std::swap(a, b);
        box.lower.*axis = a == INFINITY ? -INFINITY : a;
        box.upper.*axis = b;
      }
    for (std::size_t i = 0; i < bodies.filters.size(); i += 5) bodies.filters[i].is_fixed = true;
    const Scene scene = bodies.View();
    const std::unique_ptr<Detector> detector(GetParam()({}));
    detector->Prepare(scene);
    ASSERT_EQ(SortedPairs(*detector, scene), BruteForce(scene)) << "round " << round;
  }
}

INSTANTIATE_TEST_SUITE_P(, Trees, testing::Values(builtin::MakeOctree, builtin::MakeKdTree),
                         [](const auto& tree) { return tree.index == 0 ? "Octree" : "KdTree"; });

}  // namespace
}  // namespace cdb::tests
