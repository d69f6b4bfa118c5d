#include "runtime/omissions/trajectory.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <utility>

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

std::vector<omissions::SweptBox> RandomBoxes(std::mt19937& random, std::size_t count,
                                             double length) {
  std::uniform_real_distribution<double> place(0, 1);
  std::vector<omissions::SweptBox> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d low(place(random), place(random), place(random));
    const Vector3d size(place(random), place(random), place(random));
    boxes.push_back({{low, low + length * size},
                     static_cast<std::uint32_t>(i),
                     static_cast<std::uint8_t>(i % 3)});
  }
  return boxes;
}

TEST(SweptBoxes, FindsWhatTestingAllFinds) {
  std::mt19937 random(1);
  constexpr omissions::SweepPartners kAllButZeros = {0b110, 0b111, 0b111, 0};
  std::size_t found = 0;
  for (int round = 0; round < 200; ++round) {
    const std::vector<omissions::SweptBox> boxes =
        RandomBoxes(random, 60, round % 2 == 0 ? 0.3 : 0.8);
    std::set<std::pair<std::uint32_t, std::uint32_t>> expected, reported;
    for (const omissions::SweptBox& a : boxes)
      for (const omissions::SweptBox& b : boxes)
        if (a.object < b.object && a.kind + b.kind > 0 && a.box.intersects(b.box))
          expected.emplace(a.object, b.object);
    std::uint64_t tests = 1'000'000;
    ASSERT_TRUE(omissions::Sweep(boxes, kAllButZeros, tests, [&](std::uint32_t a, std::uint32_t b) {
      EXPECT_TRUE(reported.emplace(std::min(a, b), std::max(a, b)).second) << "reported twice";
    }));
    ASSERT_EQ(reported, expected);
    found += expected.size();
  }
  EXPECT_GT(found, 10'000u);
}

TEST(SweptBoxes, TouchingBoxesOverlap) {
  const omissions::Box first(Vector3d::Zero(), Vector3d::Ones());
  for (int axis = 0; axis < 3; ++axis) {
    const omissions::Box second(Vector3d::Unit(axis), Vector3d::Unit(axis) + Vector3d::Ones());
    std::uint64_t tests = 10;
    int count = 0;
    EXPECT_TRUE(omissions::Sweep({{first, 0, 0}, {second, 1, 0}}, {1, 0, 0, 0}, tests,
                                 [&](std::uint32_t, std::uint32_t) { ++count; }));
    EXPECT_EQ(count, 1);
  }
}

TEST(SweptBoxes, StopsWhenOutOfTests) {
  const std::vector<omissions::SweptBox> boxes(50, {{Vector3d::Zero(), Vector3d::Ones()}, 0, 1});
  constexpr std::uint64_t kPairs = 50 * 49 / 2;
  constexpr omissions::SweepPartners kAll = {7, 7, 7, 0};
  std::uint64_t enough = kPairs, too_few = kPairs - 1;
  std::uint64_t reported = 0;
  const auto count = [&](std::uint32_t, std::uint32_t) { ++reported; };
  EXPECT_TRUE(omissions::Sweep(boxes, kAll, enough, count));
  EXPECT_EQ(reported, kPairs);
  EXPECT_EQ(enough, 0u);
  EXPECT_FALSE(omissions::Sweep(boxes, kAll, too_few, count));
}

TEST(SweptBoxes, TakesTheAxisThatSeparatesMost) {
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<omissions::SweptBox> boxes;
    Vector3d size = Vector3d::Constant(10);
    size[axis] = 1;
    for (int i = 0; i < 20; ++i) {
      const Vector3d low = Vector3d::Constant(i);
      boxes.push_back({{low, low + size}, static_cast<std::uint32_t>(i), 0});
    }
    EXPECT_EQ(omissions::BestSweepAxis(boxes), axis);
  }
}

TEST(SortedBoxes, FindsAllThatOverlap) {
  std::mt19937 random(3);
  const std::vector<omissions::SweptBox> boxes = RandomBoxes(random, 200, 0.3);
  const omissions::SortedBoxes sorted(boxes);
  std::size_t found = 0;
  for (const omissions::SweptBox& query : RandomBoxes(random, 100, 0.1)) {
    std::set<std::uint32_t> expected, reported;
    for (const omissions::SweptBox& swept : boxes)
      if (swept.box.intersects(query.box)) expected.insert(swept.object);
    for (const omissions::SweptBox& swept : sorted.Near(query.box))
      if (swept.box.intersects(query.box)) reported.insert(swept.object);
    EXPECT_EQ(reported, expected);
    found += sorted.Near(query.box).size();
  }
  EXPECT_LT(found, 100u * 200u);
}

}  // namespace
}  // namespace cdb::tests
