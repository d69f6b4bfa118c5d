#include "runtime/figures/bootstrap.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cdb::tests {
namespace {

double PowerOf(const figures::PowerGroup& points) { return figures::FitPower({points}).p; }

TEST(FitPower, FitsTheLogarithms) {
  EXPECT_NEAR(PowerOf({{10, 5}, {100, 500}, {1000, 50000}}), 2, 1e-12);
  EXPECT_NEAR(PowerOf({{1, 7}, {2, 7}, {4, 7}}), 0, 1e-12);
  EXPECT_TRUE(std::isnan(PowerOf({{10, 5}, {100, 500}})));
  EXPECT_TRUE(std::isnan(PowerOf({{10, 5}, {10, 6}, {100, 500}})));
  EXPECT_TRUE(std::isnan(PowerOf({{0, 5}, {10, 6}, {100, 500}})));
  EXPECT_TRUE(std::isnan(PowerOf({{1, 5}, {10, NAN}, {100, 500}})));
}

TEST(FitPower, HasTheIntervalOfARegression) {
  const figures::PowerFit exact = figures::FitPower({{{10, 5}, {100, 500}, {1000, 50000}}});
  EXPECT_NEAR(exact.interval.low, 2, 1e-6);
  EXPECT_NEAR(exact.interval.high, 2, 1e-6);
  // Slopes of 0 and 2 over decades: the residuals are 1/3, -2/3, 1/3 decades, the standard error
  // is sqrt(2/3 / 2), and t(0.975, 1) is 12.706.
  const figures::PowerFit bent = figures::FitPower({{{1, 1}, {10, 1}, {100, 100}}});
  EXPECT_NEAR(bent.p, 1, 1e-12);
  EXPECT_NEAR(bent.interval.high - 1, 12.706 * std::sqrt(1.0 / 3), 1e-3);
}

TEST(FitPower, SharesAPowerAmongGroups) {
  const figures::PowerGroup one = {{1, 1}, {10, 10}, {100, 100}},
                            other = {{1, 70}, {10, 700}, {100, 7000}};
  const figures::PowerFit both = figures::FitPower({one, other, {{1, 1}, {2, 9}}});
  EXPECT_NEAR(both.p, 1, 1e-12);
  EXPECT_NEAR(both.interval.high, 1, 1e-6);
  EXPECT_TRUE(std::isnan(figures::FitPower({}).p));
}

}  // namespace
}  // namespace cdb::tests
