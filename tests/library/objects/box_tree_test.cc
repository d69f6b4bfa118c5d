#include "library/objects/compound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace cdb::tests {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

AlignedBox3d RandomBox(std::mt19937& random, double most) {
  std::uniform_real_distribution<double> place(-1, 1), size(0, most);
  const Vector3d lower(place(random), place(random), place(random));
  return {lower, lower + Vector3d(size(random), size(random), size(random))};
}

TEST(BoxTree, FindsTheBoxesThatMeet) {
  std::mt19937 random(1);
  for (const int count : {0, 1, 4, 5, 300}) {
    std::vector<AlignedBox3d> boxes;
    for (int i = 0; i < count; ++i) boxes.push_back(RandomBox(random, 0.2));
    const objects::BoxTree tree(boxes);
    for (int i = 0; i < 50; ++i) {
      const AlignedBox3d box = RandomBox(random, 0.5);
      std::vector<std::size_t> expected, found;
      for (std::size_t j = 0; j < boxes.size(); ++j)
        if (boxes[j].intersects(box)) expected.push_back(j);
      EXPECT_FALSE(tree.AnyOf(box, [&](std::size_t j) {
        found.push_back(j);
        return false;
      }));
      std::ranges::sort(found);
      EXPECT_EQ(found, expected);
    }
  }
}

TEST(BoxTree, StopsAtTheFirstThatWillDo) {
  const objects::BoxTree tree(std::vector<AlignedBox3d>(20, {Vector3d::Zero(), Vector3d::Ones()}));
  int visits = 0;
  EXPECT_TRUE(
      tree.AnyOf({Vector3d::Ones(), Vector3d::Ones()}, [&](std::size_t) { return ++visits == 3; }));
  EXPECT_EQ(visits, 3);
}

}  // namespace
}  // namespace cdb::tests
