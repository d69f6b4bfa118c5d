#include "runtime/figures/points.h"

#include <gtest/gtest.h>

namespace cdb::tests {
namespace {

using Indices = std::vector<std::size_t>;

TEST(AxisValues, AreNamedByLabelsNumbersAndRanges) {
  const plan::Axis axis = {"dt", "timestep", "s", {1.0 / 60, 1.0 / 120, 1.0 / 240}};
  const auto find = [&](const char* text) { return figures::FindValues(axis, text).indices; };
  EXPECT_EQ(find("0.016666666666666666"), Indices{0});
  EXPECT_EQ(find("0.008333"), Indices{1});
  EXPECT_EQ(find("0.004..0.01"), (Indices{1, 2}));
  EXPECT_EQ(find("0.008333,0.0167"), Indices{1});
  EXPECT_EQ(figures::FindValues(axis, "0.008333,0.0167").unknown,
            std::vector<std::string>{"0.0167"});
  EXPECT_EQ(figures::FindValues(axis, "").unknown, std::vector<std::string>{""});
}

TEST(AxisValues, MayHaveACommaInALabel) {
  const plan::Axis axis = {"pair", "", "", {std::string("1, 10"), std::string("2, 20")}};
  EXPECT_EQ(figures::FindValues(axis, "2, 20").indices, Indices{1});
  EXPECT_EQ(figures::FindValues(axis, "1, 10,x").unknown,
            (std::vector<std::string>{"1", " 10", "x"}));
  EXPECT_EQ(figures::ValuesText(axis), "1, 10, 2, 20");
}

}  // namespace
}  // namespace cdb::tests
