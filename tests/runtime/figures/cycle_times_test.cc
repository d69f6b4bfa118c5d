#include "runtime/figures/times.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cdb::tests {
namespace {

using figures::Bootstrap;
using figures::PhaseTimes;
using figures::TimesOver;

TEST(CycleTimes, AreMediansOverTheRepeatsAndMeansOverTheCycles) {
  const PhaseTimes times = TimesOver({{1, 10}, {3, 30}, {2, 20}}, Bootstrap(3));
  EXPECT_EQ(times.cycles, (std::vector<double>{2, 20}));
  EXPECT_DOUBLE_EQ(times.mean.value, 11);
  EXPECT_EQ(TimesOver({{1, 10}, {3, 30}}, Bootstrap(2)).cycles, (std::vector<double>{2, 20}));
}

/// The time of one cycle.
double CycleOfFastest(std::size_t chosen, const std::vector<double>& repeats) {
  std::vector<std::vector<double>> cycles;
  for (const double ns : repeats) cycles.push_back({ns});
  return TimesOver(cycles, Bootstrap(repeats.size()), figures::CycleStatistic::kMean, chosen)
      .cycles[0];
}

TEST(CycleTimes, AreOfTheFastestRepeatsForComparisons) {
  EXPECT_EQ(CycleOfFastest(1, {7}), 7);
  EXPECT_EQ(CycleOfFastest(4, {5, 3, 9, 4}), 3);
  // Of 1, it is the mean; of 2, the six pairs have 1 three times, 2 twice, and 3 once.
  EXPECT_DOUBLE_EQ(CycleOfFastest(1, {4, 1, 3, 2}), 2.5);
  EXPECT_DOUBLE_EQ(CycleOfFastest(2, {4, 1, 3, 2}), (1 * 3 + 2 * 2 + 3) / 6.0);
  EXPECT_DOUBLE_EQ(CycleOfFastest(3, {4, 1, 3, 2}), (1 * 3 + 2) / 4.0);
}

TEST(CycleTimes, TakeTheFastestOfFew) {
  EXPECT_EQ(figures::FastestOf(1), 1u);
  EXPECT_EQ(figures::FastestOf(3), 3u);
  EXPECT_EQ(figures::FastestOf(9), 6u);
  EXPECT_EQ(figures::FastestOf(45), 13u);
}

TEST(CycleTimes, OfTheFastestDrawLikeTheOthers) {
  // A draw with the repeats 2, 2, 3 counts as 2, 2, 3, not as 2, 3.
  const PhaseTimes times =
      TimesOver({{1}, {2}, {4}}, Bootstrap(3), figures::CycleStatistic::kMean, 2);
  const Bootstrap bootstrap(3);
  for (std::size_t i = 0; i < bootstrap.draws().size(); ++i) {
    const std::vector<std::uint32_t>& counts = bootstrap.draws()[i].counts;
    if (counts == std::vector<std::uint32_t>{0, 2, 1}) {
      EXPECT_DOUBLE_EQ(times.mean.drawn[i], 2);
    } else if (counts == std::vector<std::uint32_t>{0, 1, 2}) {
      EXPECT_DOUBLE_EQ(times.mean.drawn[i], (2 * 2 + 4) / 3.0);
    }
  }
}

TEST(CycleTimes, AStallInOneRepeatDoesNotCount) {
  std::vector<std::vector<double>> repeats(5, std::vector<double>(100, 7));
  for (std::size_t r = 0; r < 5; ++r) repeats[r][10 * r] = 1e6;
  const PhaseTimes times = TimesOver(repeats, Bootstrap(5));
  EXPECT_DOUBLE_EQ(times.mean.value, 7);
  EXPECT_EQ(times.cycles, std::vector<double>(100, 7));
}

TEST(CycleTimes, OfOneRepeatAreThoseOfTheRun) {
  const PhaseTimes times = TimesOver({{1, 2, 9}}, Bootstrap(1));
  EXPECT_DOUBLE_EQ(times.mean.value, 4);
  EXPECT_TRUE(times.mean.drawn.empty());
}

TEST(CycleTimes, DrawWholeRuns) {
  // Each run is fast or slow as a whole. If cycles were drawn separately, 300 of them would average
  // out.
  std::vector<std::vector<double>> repeats;
  for (const double ns : {10, 11, 12, 13, 14}) repeats.emplace_back(300, ns);
  const Bootstrap bootstrap(5);
  const figures::Interval interval = bootstrap.IntervalOf(TimesOver(repeats, bootstrap).mean);
  EXPECT_LE(interval.low, 10.5);
  EXPECT_GE(interval.high, 13.5);
}

/// `stalls` of 100 cycles in each of 5 repeats take `ns` longer; otherwise repeats differ by 1 %.
figures::Interval IntervalWith(std::size_t stalls, double ns) {
  std::vector<std::vector<double>> repeats;
  for (std::size_t r = 0; r < 5; ++r) {
    repeats.emplace_back(100, 1000 + 10 * static_cast<double>(r));
    for (std::size_t i = 0; i < stalls; ++i) repeats[r][(7 * i + 20 * r) % 100] += ns;
  }
  const Bootstrap bootstrap(5);
  return bootstrap.IntervalOf(TimesOver(repeats, bootstrap).mean);
}

TEST(CycleTimes, StallsOfADrawnRepeatDoNotOutvoteTheOthers) {
  const figures::Interval quiet = IntervalWith(0, 0), stalled = IntervalWith(3, 1e6);
  EXPECT_GT(quiet.high, 1030);
  EXPECT_LE(quiet.high, 1040);
  EXPECT_NEAR(stalled.low, quiet.low, 5);
  EXPECT_NEAR(stalled.high, quiet.high, 5);
  // If stalls are frequent, the interval shows it.
  EXPECT_GT(IntervalWith(20, 1e6).high, 10 * quiet.high);
}

TEST(CycleTimes, WithoutARepeatAreOfTheOthers) {
  const Bootstrap bootstrap(3);
  const PhaseTimes times = TimesOver({{1, 2}, {}, {3, 4}}, bootstrap);
  EXPECT_EQ(times.cycles, (std::vector<double>{2, 3}));
  EXPECT_EQ(times.mean.things, 2u);
  EXPECT_TRUE(std::isnan(bootstrap.IntervalOf(times.mean).low));
}

}  // namespace
}  // namespace cdb::tests
