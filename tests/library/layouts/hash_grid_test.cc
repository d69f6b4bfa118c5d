#include "library/layouts/clearance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "library/distributions/stream.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

TEST(HashGrid, FindsWhatTouches) {
  distributions::Stream stream(3);
  std::vector<objects::Box> boxes;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d half(stream.LogUniform(1e-2, 20), stream.LogUniform(1e-2, 20), 0.1);
    const Vector3d at(stream.Uniform(-50, 50), stream.Uniform(-50, 50), stream.Uniform(-5, 5));
    boxes.push_back({at - half, at + half});
  }
  const auto extent = [](const objects::Box& box) { return (box.upper - box.lower).maxCoeff(); };
  std::ranges::sort(boxes, std::greater<>(), extent);
  layouts::HashGrid grid(boxes.size());
  std::size_t found_in_all = 0, visits = 0;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    std::vector<std::uint32_t> expected, found;
    const auto touch = [&](std::uint32_t j) {
      return (boxes[j].lower.array() <= boxes[i].upper.array()).all() &&
             (boxes[j].upper.array() >= boxes[i].lower.array()).all();
    };
    for (std::uint32_t j = 0; j < i; ++j)
      if (touch(j)) expected.push_back(j);
    grid.AnyOf(boxes[i], [&](std::uint32_t j) {
      ++visits;
      if (touch(j)) found.push_back(j);
      return false;
    });
    std::ranges::sort(found);
    const auto [first, last] = std::ranges::unique(found);
    found.erase(first, last);
    ASSERT_EQ(found, expected);
    found_in_all += found.size();
    grid.Add(i, layouts::HashGrid::LevelOf(extent(boxes[i])), boxes[i]);
  }
  EXPECT_GT(found_in_all, 500u);
  EXPECT_LT(visits, 2000 * 2000 / 2);
}

TEST(HashGrid, WorksFarAway) {
  layouts::HashGrid grid(2);
  const objects::Box far{Vector3d::Constant(1e300), Vector3d::Constant(1e300)};
  grid.Add(0, layouts::HashGrid::LevelOf(1e-3), far);
  EXPECT_TRUE(grid.AnyOf(far, [](std::uint32_t id) { return id == 0; }));
}

}  // namespace
}  // namespace cdb::tests
