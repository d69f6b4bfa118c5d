#include "runtime/figures/detectors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cdb::tests {
namespace {

TEST(GrowthExponent, FitsTheLogarithms) {
  EXPECT_NEAR(figures::GrowthExponent({{10, 5}, {100, 500}, {1000, 50000}}), 2, 1e-12);
  EXPECT_NEAR(figures::GrowthExponent({{1, 7}, {2, 7}, {4, 7}}), 0, 1e-12);
  EXPECT_TRUE(std::isnan(figures::GrowthExponent({{10, 5}, {100, 500}})));
  EXPECT_TRUE(std::isnan(figures::GrowthExponent({{10, 5}, {10, 6}, {100, 500}})));
  EXPECT_TRUE(std::isnan(figures::GrowthExponent({{0, 5}, {10, 6}, {100, 500}})));
  EXPECT_TRUE(std::isnan(figures::GrowthExponent({{1, 5}, {10, NAN}, {100, 500}})));
}

}  // namespace
}  // namespace cdb::tests
