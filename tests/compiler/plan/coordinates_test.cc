#include "compiler/plan/plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace cdb::tests {
namespace {

std::string LabelsOf(std::vector<plan::Coordinate> values) {
  const plan::Axis axis{"x", "", "", std::move(values)};
  std::string labels;
  for (std::size_t i = 0; i < axis.values.size(); ++i)
    labels += (i > 0 ? " " : "") + plan::CoordinateLabel(axis, i);
  return labels;
}

TEST(CoordinateLabel, WrittenNumbersStayAndCalculatedOnesAreShort) {
  EXPECT_EQ(LabelsOf({0.0125, 12.345, 0.123467, 1e-9}), "0.0125 12.345 0.123467 1e-09");
  EXPECT_EQ(LabelsOf({5.0, 5 + 3 * (100 - 5) / 7.0, 47.857142857142854}), "5 45.71 47.86");
  EXPECT_EQ(LabelsOf({1.0 / 60, 1.0 / 120}), "0.01667 0.008333");
  EXPECT_EQ(LabelsOf({0.1 + 0.2, 0.1}), "0.3 0.1");
  EXPECT_EQ(LabelsOf({16384.0, 1234567.0, 1e22}), "16384 1234567 1e+22");
  EXPECT_EQ(LabelsOf({12345.6789}), "12346");
  EXPECT_EQ(LabelsOf({-1.0 / 3, "none"}), "-0.3333 none");
}

TEST(CoordinateLabel, NeighboursHaveEnoughDigits) {
  EXPECT_EQ(LabelsOf({0.3, 0.1 + 0.2}), "0.3 0.30000000000000004");
  EXPECT_EQ(LabelsOf({16384.0, 16384.333333333333}), "16384 16384.3");
  EXPECT_EQ(LabelsOf({1.0 / 3, 1.0 / 3 + 1e-7}), "0.3333333 0.3333334");
}

TEST(CoordinateLabel, DifferentValuesNeverShareOne) {
  std::mt19937_64 engine(1);
  for (int round = 0; round < 300; ++round) {
    plan::Axis axis{"x", "", "", {}};
    std::set<double> values;
    const double base = std::ldexp(1.0 + static_cast<double>(engine() % 1000) / 999,
                                   static_cast<int>(engine() % 40) - 20);
    const double step = base * std::pow(10.0, -static_cast<double>(engine() % 17));
    for (int i = 0; i < 40; ++i)
      values.insert(base + step * std::floor(static_cast<double>(engine() % 60) / 2) / 3);
    std::set<std::string> labels;
    for (const double value : values) axis.values.emplace_back(value);
    for (std::size_t i = 0; i < axis.values.size(); ++i)
      labels.insert(plan::CoordinateLabel(axis, i));
    EXPECT_EQ(labels.size(), values.size()) << base << " " << step;
    const std::vector<std::string> all = plan::CoordinateLabels(axis);
    EXPECT_EQ(std::set<std::string>(all.begin(), all.end()), labels);
  }
}

}  // namespace
}  // namespace cdb::tests
