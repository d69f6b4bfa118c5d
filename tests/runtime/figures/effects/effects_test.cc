#include "runtime/figures/effects/effects.h"

#include <gtest/gtest.h>

#include <cmath>

#include "compiler/evaluate/samples.h"
#include "library/distributions/stream.h"
#include "runtime/figures/bootstrap.h"

namespace cdb::tests {
namespace {

using effects::FitEffects;

std::vector<plan::Coordinates> Parameters(std::size_t count, std::size_t points) {
  std::vector<plan::Coordinates> parameters;
  for (std::size_t i = 0; i < count; ++i) {
    plan::Coordinates of{
        "p" + std::to_string(i), i == 0 ? 1.0 : 2.0, i == 0 ? 100.0 : 6.0, i == 0, {}};
    for (const double part : evaluate::SobolCoordinates(i, points))
      of.values.push_back(of.is_log ? std::pow(100, part) : 2 + 4 * part);
    parameters.push_back(std::move(of));
  }
  return parameters;
}

/// p0^0.5 exp(0.3 x + 0.6 (u - 1/2)(x - 1/2)) with u and x the places in the ranges of p0 and p1:
/// the variances of the three terms are (ln 10)^2 / 12, 0.09 / 12 and 0.36 / 144.
TEST(Effects, OfAClosedFormAreFound) {
  const auto parameters = Parameters(3, 64);
  std::vector<double> figures;
  for (std::size_t i = 0; i < 64; ++i) {
    const double u = std::log(parameters[0].values[i]) / std::log(100),
                 x = (parameters[1].values[i] - 2) / 4;
    figures.push_back(std::exp(std::log(10) * u + 0.3 * x + 0.6 * (u - 0.5) * (x - 0.5)));
  }
  const auto fit = FitEffects(parameters, figures);
  ASSERT_TRUE(fit);
  const double first = std::log(10) * std::log(10) / 12, second = 0.09 / 12, both = 0.36 / 144;
  const double all = first + second + both;
  EXPECT_EQ(fit->mains[0].parameter, 0u);
  EXPECT_NEAR(std::exp(fit->mains[0].log_ratio), 10, 1e-9);
  EXPECT_NEAR(fit->mains[0].share, first / all, 1e-9);
  EXPECT_EQ(fit->mains[1].parameter, 1u);
  EXPECT_NEAR(std::exp(fit->mains[1].log_ratio), std::exp(0.3), 1e-9);
  EXPECT_NEAR(fit->mains[1].share, second / all, 1e-9);
  EXPECT_NEAR(std::exp(fit->mains[2].log_ratio), 1, 1e-9);
  ASSERT_TRUE(fit->has_interactions);
  EXPECT_EQ(fit->interactions[0].a, 0u);
  EXPECT_EQ(fit->interactions[0].b, 1u);
  EXPECT_NEAR(fit->interactions[0].share, both / all, 1e-9);
  EXPECT_NEAR(fit->unexplained, 0, 1e-9);
}

TEST(Effects, OfSquaresHaveNoRatioButAShare) {
  const auto parameters = Parameters(2, 32);
  std::vector<double> figures;
  for (const double value : parameters[1].values)
    figures.push_back(std::exp((value - 4) * (value - 4)));
  const auto fit = FitEffects(parameters, figures);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->mains[0].parameter, 1u);
  EXPECT_NEAR(std::exp(fit->mains[0].log_ratio), 1, 1e-9);
  EXPECT_NEAR(fit->mains[0].share, 1, 1e-9);
}

TEST(Effects, HaveIntervalsThatCoverTheTruth) {
  const auto parameters = Parameters(3, 64);
  constexpr int kCases = 1000;
  int covered = 0;
  distributions::Stream random(7);
  for (int i = 0; i < kCases; ++i) {
    std::vector<double> figures;
    for (std::size_t point = 0; point < 64; ++point) {
      figures.push_back(std::exp((parameters[1].values[point] - 2) / 4 + 0.1 * random.Normal()));
    }
    const auto fit = FitEffects(parameters, figures);
    const auto& main = fit->mains[0];
    covered += std::abs(main.log_ratio - 1) <= figures::StudentQuantile(fit->freedom) * main.error;
  }
  EXPECT_NEAR(covered, 950, 25);
}

TEST(Effects, NeedEnoughPointsThatVary) {
  const auto parameters = Parameters(3, 16);
  std::vector<double> figures(16, 1.0);
  EXPECT_FALSE(FitEffects(parameters, figures));
  for (std::size_t i = 0; i < 16; ++i) figures[i] = parameters[1].values[i];
  const auto fit = FitEffects(parameters, figures);
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->has_interactions);
  for (std::size_t i = 0; i < 9; ++i) figures[i] = figures::kNone;
  EXPECT_FALSE(FitEffects(parameters, figures));
}

}  // namespace
}  // namespace cdb::tests
