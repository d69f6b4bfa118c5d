// A grid with crowds finds the same pairs as testing every pair.
#include "library/detectors/kernels/box_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string_view>
#include <vector>

#include "library/detectors/kernels/pair_buffer.h"
#include "tests/library/detectors/box_scenes.h"

namespace cdb::tests {
namespace {

using kernels::BoxGrid;
using kernels::FatBox;
using kernels::PairBuffer;

std::vector<Pair> Sorted(PairBuffer& found) {
  std::vector<Pair> pairs(found.pairs().begin(), found.pairs().end());
  std::ranges::sort(pairs);
  return pairs;
}

/// Clusters of clusters, so that crowds contain crowds; a box as long as all of them; and some
/// boxes that overlap completely.
std::vector<Box> NestedSwarms(std::size_t count) {
  std::mt19937_64 random(3);
  std::vector<Box> boxes;
  const auto near = [&](double at, double width) {
    return std::uniform_real_distribution<double>(at - width, at + width)(random);
  };
  for (std::size_t i = 0; i < count; ++i) {
    const double swarm = i % 2 == 0 ? 1e6 : -1e6, inner = i % 3 == 0 ? 1e3 : -1e3;
    double at[3];
    for (double& x : at)
      x = i % 50 == 0 ? near(0, 1e6) : i % 7 == 0 ? near(swarm, 1e4) : near(swarm + inner, 4);
    boxes.push_back(Cube(at[0], at[1], at[2], 0.2));
  }
  for (std::size_t i = 0; i < 300; ++i) boxes.push_back(Cube(5e5, 0, 0, 1 + 1e-3 * near(0, 1)));
  boxes.push_back(Cube(0, 0, 0, 2e6));
  for (Box& box : boxes)  // rounds to floats, which the grid uses unchanged
    for (const auto corner : {&Box::lower, &Box::upper})
      for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z})
        (box.*corner).*axis = static_cast<double>(static_cast<float>((box.*corner).*axis));
  return boxes;
}

class CrowdedGrid : public testing::Test {
 protected:
  CrowdedGrid() { EXPECT_TRUE(grid_.Build(boxes_.data(), boxes_.size())); }

  const std::vector<Box> boxes_ = NestedSwarms(12000);
  BoxGrid grid_ = BoxGrid(kernels::BestKernels());
};

TEST_F(CrowdedGrid, SharesFewCells) {
  EXPECT_GT(grid_.Crowding(), 1024);
  EXPECT_LT(grid_.MeanOccupancy(), 64);
}

TEST_F(CrowdedGrid, FindsAllPairsInTheSameOrderInAnyNumberOfRanges) {
  PairBuffer whole;
  grid_.Query(0, grid_.Size(), whole.sink());
  EXPECT_EQ(Sorted(whole), BruteForce(Boxes(boxes_).View()));
  for (const std::size_t ranges : {2u, 3u, 50u, 997u}) {
    PairBuffer parts;
    for (std::size_t i = 0; i < ranges; ++i)
      grid_.Query(grid_.Size() * i / ranges, grid_.Size() * (i + 1) / ranges, parts.sink());
    EXPECT_TRUE(std::ranges::equal(parts.pairs(), whole.pairs())) << ranges;
  }
}

TEST_F(CrowdedGrid, FindsWhatOneBoxOverlapsAlsoAfterBoxesGrew) {
  std::vector<FatBox> boxes;
  for (const Box& box : boxes_) boxes.push_back(kernels::Around(box, kernels::BestKernels()));
  std::mt19937_64 random(5);
  for (int round = 0; round < 100; ++round) {
    const auto grows = static_cast<Id>(random() % boxes.size());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      boxes[grows].lower[axis] -= static_cast<float>(random() % 30);
      boxes[grows].upper[axis] += static_cast<float>(random() % 30);
    }
    ASSERT_TRUE(grid_.Grow(grows, boxes[grows]));
    const auto asks = static_cast<Id>(random() % boxes.size());
    PairBuffer found;
    grid_.QueryOne(boxes[asks], asks, found.sink());
    std::vector<Pair> expected;
    for (Id id = 0; id < boxes.size(); ++id) {
      bool overlap = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
        overlap &= boxes[id].lower[axis] <= boxes[asks].upper[axis] &&
                   boxes[asks].lower[axis] <= boxes[id].upper[axis];
      if (overlap) expected.push_back({asks, id});
    }
    ASSERT_EQ(Sorted(found), expected) << "round " << round;
  }
}

TEST_F(CrowdedGrid, BuiltAgainForOtherBoxesForgetsItsCrowds) {
  BoxScene dense("dense", 3000);
  for (int cycle = 0; cycle < 2; ++cycle) {
    grid_.Build(dense.View().boxes.data(), dense.View().size);
    PairBuffer found;
    grid_.Query(0, grid_.Size(), found.sink());
    EXPECT_EQ(Sorted(found), BruteForce(dense.View()));
    EXPECT_EQ(grid_.Crowding(), grid_.MeanOccupancy());
  }
}

}  // namespace
}  // namespace cdb::tests
