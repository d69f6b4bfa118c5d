#include "runtime/report/cycle_times.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cdb::tests {
namespace {

using report::Bootstrap;
using report::PhaseTimes;
using report::TimesOver;

TEST(CycleTimes, AreMediansOverTheRepeatsAndMeansOverTheCycles) {
  const PhaseTimes times = TimesOver({{1, 10}, {3, 30}, {2, 20}}, Bootstrap(3));
  EXPECT_EQ(times.cycles, (std::vector<double>{2, 20}));
  EXPECT_DOUBLE_EQ(times.mean.value, 11);
  EXPECT_EQ(TimesOver({{1, 10}, {3, 30}}, Bootstrap(2)).cycles, (std::vector<double>{2, 20}));
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
  // Each run is fast or slow as a whole. Drawn cycle by cycle, 300 of them would average out.
  std::vector<std::vector<double>> repeats;
  for (const double ns : {10, 11, 12, 13, 14}) repeats.emplace_back(300, ns);
  const Bootstrap bootstrap(5);
  const report::Interval interval = bootstrap.IntervalOf(TimesOver(repeats, bootstrap).mean);
  EXPECT_LE(interval.low, 10.5);
  EXPECT_GE(interval.high, 13.5);
}

/// `stalls` of 100 cycles in each of 5 repeats take `ns` more; else repeats differ by 1 %.
report::Interval IntervalWith(std::size_t stalls, double ns) {
  std::vector<std::vector<double>> repeats;
  for (std::size_t r = 0; r < 5; ++r) {
    repeats.emplace_back(100, 1000 + 10 * static_cast<double>(r));
    for (std::size_t i = 0; i < stalls; ++i) repeats[r][(7 * i + 20 * r) % 100] += ns;
  }
  const Bootstrap bootstrap(5);
  return bootstrap.IntervalOf(TimesOver(repeats, bootstrap).mean);
}

TEST(CycleTimes, StallsOfADrawnRepeatDoNotOutvoteTheOthers) {
  const report::Interval quiet = IntervalWith(0, 0), stalled = IntervalWith(3, 1e6);
  EXPECT_GT(quiet.high, 1030);
  EXPECT_LE(quiet.high, 1040);
  EXPECT_NEAR(stalled.low, quiet.low, 5);
  EXPECT_NEAR(stalled.high, quiet.high, 5);
  // Where stalls are the rule, the interval says so.
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
