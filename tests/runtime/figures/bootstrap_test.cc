#include "runtime/figures/bootstrap.h"

#include <gtest/gtest.h>

#include <cmath>

#include "library/distributions/stream.h"

namespace cdb::tests {
namespace {

using figures::Bootstrap;
using figures::Estimate;
using figures::Interval;
using figures::IntervalKind;

TEST(Bootstrap, HasAllDrawsOfAFewAndSomeOfMore) {
  for (const auto& [n, draws] :
       {std::pair<std::size_t, std::size_t>{0, 0}, {1, 0}, {2, 3}, {5, 126}, {6, 462}}) {
    EXPECT_EQ(Bootstrap(n).draws().size(), draws) << n;
  }
  for (const std::size_t n : {2, 5, 9}) {
    double weight = 0;
    const Bootstrap bootstrap(n);
    for (const figures::Draw& draw : bootstrap.draws()) {
      weight += draw.weight;
      std::size_t total = 0;
      for (const std::uint32_t count : draw.counts) total += count;
      EXPECT_EQ(total, n);
    }
    EXPECT_NEAR(weight, 1, 1e-12) << n;
  }
  EXPECT_EQ(Bootstrap(9).draws()[7].counts, Bootstrap(9).draws()[7].counts);
}

TEST(Bootstrap, CallsARangeWhatIsOfTooFew) {
  EXPECT_EQ(Bootstrap(1).kind(), IntervalKind::kAbsent);
  EXPECT_EQ(Bootstrap(4).kind(), IntervalKind::kRange);
  EXPECT_EQ(Bootstrap(5).kind(), IntervalKind::kInterval);
  const auto interval_of = [](const std::vector<double>& values) {
    const Bootstrap bootstrap(values.size());
    return bootstrap.IntervalOf(bootstrap.MeanEstimate(values));
  };
  EXPECT_TRUE(std::isnan(interval_of({3}).low));
  const Interval range = interval_of({3, 1, 2});
  EXPECT_EQ(range.low, 1);
  EXPECT_EQ(range.high, 3);
  const Interval interval = interval_of({3, 1, 2, 5, 4});
  EXPECT_GT(interval.low, 1);
  EXPECT_LT(interval.low, 2);
  EXPECT_LT(interval.high, 5);
  EXPECT_NEAR(interval.low + interval.high, 6, 1e-9);
}

TEST(Bootstrap, HasNoIntervalWhereThingsAreMissing) {
  const Bootstrap bootstrap(5);
  Estimate estimate = bootstrap.MeanEstimate({1, 2, 3, 4, 5});
  estimate.things = 4;
  EXPECT_TRUE(std::isnan(bootstrap.IntervalOf(estimate).low));
}

TEST(Bootstrap, HasTheFigureInItsInterval) {
  const Bootstrap bootstrap(5);
  Estimate estimate = bootstrap.MeanEstimate({1, 2, 3, 4, 5});
  estimate.value = 0.5;
  EXPECT_EQ(bootstrap.IntervalOf(estimate).low, 0.5);
}

TEST(Bootstrap, CoversTheTruthAboutAsOftenAsItSays) {
  distributions::Stream stream(1);
  for (const std::size_t n : {5, 8, 20}) {
    const Bootstrap bootstrap(n);
    constexpr int kSamples = 400;
    int covered = 0;
    for (int i = 0; i < kSamples; ++i) {
      std::vector<double> values;
      for (std::size_t k = 0; k < n; ++k) values.push_back(stream.Normal());
      const Interval interval = bootstrap.IntervalOf(bootstrap.MeanEstimate(values));
      covered += interval.low <= 0 && 0 <= interval.high ? 1 : 0;
    }
    EXPECT_GT(covered, 0.91 * kSamples) << n;
    EXPECT_LT(covered, 0.985 * kSamples) << n;
  }
}

TEST(Bootstrap, PairsRatiosByTheirThings) {
  // The third repeat was slow for both; the ratio is 2 in each repeat.
  const Bootstrap bootstrap(5);
  const Estimate above = bootstrap.MeanEstimate({2, 2.2, 20, 2.4, 2}),
                 below = bootstrap.MeanEstimate({1, 1.1, 10, 1.2, 1});
  const Interval ratio = bootstrap.IntervalOf(figures::RatioOf(above, below));
  EXPECT_NEAR(ratio.low, 2, 1e-12);
  EXPECT_NEAR(ratio.high, 2, 1e-12);
  EXPECT_GT(bootstrap.IntervalOf(below).high, 5);
  EXPECT_NEAR(figures::GeometricMeanOf({above, below}).value, std::sqrt(above.value * below.value),
              1e-12);
  EXPECT_NEAR(figures::Scaled(above, 3).drawn[5], 3 * above.drawn[5], 1e-12);
}

}  // namespace
}  // namespace cdb::tests
