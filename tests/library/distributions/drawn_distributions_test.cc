// Draws compared with closed forms: moments and the Kolmogorov-Smirnov distance, with fixed seeds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "compiler/schema/cumulative.h"
#include "library/distributions/draw.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

using schema::Distribution;
using schema::DistributionKind;

constexpr int kDrawsOfEach = 40000;

std::vector<double> DrawsOf(const Distribution& distribution) {
  plan::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "friction", distribution);
  distributions::Draw draw(scene, scene.groups[0], "friction");
  std::vector<double> draws(kDrawsOfEach);
  for (double& value : draws) value = draw.Real();
  return draws;
}

/// The largest distance between the draws' empirical distribution function and `cumulative`, times
/// the root of their number; above 1.95 with a probability of 0.001.
double Distance(std::vector<double> draws, const std::function<double(double)>& cumulative) {
  std::ranges::sort(draws);
  const auto n = static_cast<double>(draws.size());
  double distance = 0;
  for (std::size_t i = 0; i < draws.size(); ++i) {
    const double at = cumulative(draws[i]);
    distance =
        std::max({distance, at - static_cast<double>(i) / n, static_cast<double>(i + 1) / n - at});
  }
  return distance * std::sqrt(n);
}

void ExpectMoments(const std::vector<double>& draws, double mean, double variance,
                   double fourth_over_square) {
  double sum = 0, squares = 0;
  for (const double draw : draws) {
    sum += draw;
    squares += (draw - mean) * (draw - mean);
  }
  const auto n = static_cast<double>(draws.size());
  EXPECT_NEAR(sum / n, mean, 5 * std::sqrt(variance / n));
  EXPECT_NEAR(squares / n, variance, 5 * variance * std::sqrt((fourth_over_square - 1) / n));
}

double NormalCumulative(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

TEST(DrawnDistributions, Lognormal) {
  const auto draws = DrawsOf({DistributionKind::kLognormal, {0.5, 0.4}, {}});
  EXPECT_LT(Distance(draws, [](double x) { return NormalCumulative((std::log(x) - 0.5) / 0.4); }),
            1.95);
  const double w = std::exp(0.16);
  ExpectMoments(draws, std::exp(0.5 + 0.08), (w - 1) * w * std::exp(1.0),
                w * w * w * w + 2 * w * w * w + 3 * w * w - 3);
}

TEST(DrawnDistributions, Exponential) {
  const auto draws = DrawsOf({DistributionKind::kExponential, {3.0}, {}});
  EXPECT_LT(Distance(draws, [](double x) { return 1 - std::exp(-x / 3); }), 1.95);
  ExpectMoments(draws, 3, 9, 9);
}

TEST(DrawnDistributions, Weibull) {
  const auto draws = DrawsOf({DistributionKind::kWeibull, {1.5, 2.0}, {}});
  EXPECT_LT(Distance(draws, [](double x) { return 1 - std::exp(-std::pow(x / 2, 1.5)); }), 1.95);
  const double first = std::tgamma(1 + 1 / 1.5), second = std::tgamma(1 + 2 / 1.5);
  ExpectMoments(draws, 2 * first, 4 * (second - first * first), 4);
}

// For integer shapes, the closed form is a sum of Poisson terms; for shape 1/2 it is the error
// function.
TEST(DrawnDistributions, Gamma) {
  const auto whole = DrawsOf({DistributionKind::kGamma, {3.0, 2.0}, {}});
  EXPECT_LT(Distance(whole,
                     [](double x) {
                       const double t = x / 2;
                       return 1 - std::exp(-t) * (1 + t + t * t / 2);
                     }),
            1.95);
  ExpectMoments(whole, 6, 12, 5);
  const auto half = DrawsOf({DistributionKind::kGamma, {0.5, 2.0}, {}});
  EXPECT_LT(Distance(half, [](double x) { return std::erf(std::sqrt(x / 2)); }), 1.95);
  ExpectMoments(half, 1, 2, 15);
}

TEST(DrawnDistributions, TruncatedNormal) {
  Distribution limited{DistributionKind::kNormal, {5.0, 2.0}, {}};
  limited.limits = schema::Limits{4, 8};
  const auto draws = DrawsOf(limited);
  const auto [least, most] = std::ranges::minmax(draws);
  EXPECT_GE(least, 4);
  EXPECT_LE(most, 8);
  const double low = NormalCumulative(-0.5), high = NormalCumulative(1.5);
  EXPECT_LT(
      Distance(draws,
               [&](double x) { return (NormalCumulative((x - 5) / 2) - low) / (high - low); }),
      1.95);
}

TEST(DrawnDistributions, TablesDrawTheirValuesByWeight) {
  for (const bool has_weights : {false, true}) {
    Distribution table{DistributionKind::kEmpirical, {1.0, 2.0, 4.0}, {}};
    if (has_weights) table.weights = {1, 2, 5};
    std::map<double, int> counts;
    for (const double draw : DrawsOf(table)) ++counts[draw];
    ASSERT_EQ(counts.size(), 3u);
    const double part = has_weights ? 5.0 / 8 : 1.0 / 3;
    EXPECT_NEAR(counts[4] / (1.0 * kDrawsOfEach), part,
                5 * std::sqrt(part * (1 - part) / kDrawsOfEach));
  }
}

// The first draws of each distribution, which reveal differences between machines and libraries.
TEST(DrawnDistributions, DrawsAreTheSameToTheBit) {
  const std::pair<Distribution, const char*> expected[] = {
      {{DistributionKind::kLognormal, {0.5, 0.4}, {}}, "190.12442188242417"},
      {{DistributionKind::kExponential, {3.0}, {}}, "290.74551508753433"},
      {{DistributionKind::kGamma, {3.0, 2.0}, {}}, "655.8537084411051"},
      {{DistributionKind::kGamma, {0.5, 2.0}, {}}, "72.64605667764731"},
      {{DistributionKind::kWeibull, {1.5, 2.0}, {}}, "173.33992635357404"}};
  for (const auto& [distribution, sum] : expected) {
    double all = 0;
    const std::vector<double> draws = DrawsOf(distribution);
    for (int i = 0; i < 100; ++i) all += draws[static_cast<std::size_t>(i)];
    EXPECT_EQ(schema::FormatReal(all), sum) << schema::ToText(schema::Value(distribution));
  }
}

TEST(Cumulative, AgreesWithClosedForms) {
  EXPECT_NEAR(schema::IncompleteGamma(3, 2), 1 - std::exp(-2.0) * 5, 1e-12);
  EXPECT_NEAR(schema::IncompleteGamma(3, 9), 1 - std::exp(-9.0) * (1 + 9 + 40.5), 1e-12);
  EXPECT_NEAR(schema::IncompleteGamma(0.5, 0.3), std::erf(std::sqrt(0.3)), 1e-12);
  EXPECT_NEAR(schema::IncompleteGamma(100, 100), 0.5132987982791589, 1e-9);
  const Distribution table{DistributionKind::kEmpirical, {1.0, 2.0, 4.0}, {1, 1, 2}};
  EXPECT_EQ(schema::CumulativeAt(table, 2), 0.5);
  EXPECT_EQ(schema::ChanceWithin(table, 2, 3), 0.25);
  for (const Distribution& d : {Distribution{DistributionKind::kGamma, {3.0, 2.0}, {}},
                                Distribution{DistributionKind::kWeibull, {1.5, 2.0}, {}},
                                Distribution{DistributionKind::kLognormal, {0.5, 0.4}, {}},
                                Distribution{DistributionKind::kExponential, {3.0}, {}}}) {
    const schema::Limits range = schema::UsualRange(d);
    EXPECT_NEAR(schema::CumulativeAt(d, range.least), 0.00135, 0.0007);
    EXPECT_NEAR(schema::CumulativeAt(d, range.most), 1 - 0.00135, 0.0007);
  }
}

}  // namespace
}  // namespace cdb::tests
