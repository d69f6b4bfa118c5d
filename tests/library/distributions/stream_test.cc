#include "library/distributions/stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace cdb::tests {
namespace {

constexpr int kDraws = 200000;

/// The Kolmogorov-Smirnov distance: the largest distance between the samples' distribution and
/// `cdf`, times the root of their number. Above kKs by chance once in 10^4.
constexpr double kKs = 2.23;
double KsStatistic(std::vector<double> samples, auto cdf) {
  std::ranges::sort(samples);
  const double n = static_cast<double>(samples.size());
  double most = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double p = cdf(samples[i]);
    most = std::max({most, std::abs(p - static_cast<double>(i) / n),
                     std::abs(p - static_cast<double>(i + 1) / n)});
  }
  return most * std::sqrt(n);
}

std::vector<double> Draws(auto draw) {
  distributions::Stream stream(7);
  std::vector<double> samples;
  for (int i = 0; i < kDraws; ++i) samples.push_back(draw(stream));
  return samples;
}

// Computed independently of this code: mt19937_64 written from its definition, the inverse normal
// distribution from another implementation of AS 241. Changing a value here would change every
// existing result.
TEST(Stream, FirstValuesAreFrozen) {
  distributions::Stream uniform(0xAAAAAAAAAA);
  for (const double expected :
       {0x1.7efc3c6e727d4p-2, 0x1.ac1082c653cd3p-1, 0x1.6b9a37a609e22p-1, 0x1.85f4bf3de2a48p-3})
    EXPECT_EQ(uniform.Uniform(), expected);
  distributions::Stream normal(0xAAAAAAAAAA);
  for (const double expected :
       {-0.32125367605479466, 0.9784070058131119, 0.5538550065988858, -0.8763929523417203})
    EXPECT_DOUBLE_EQ(normal.Normal(), expected);
  distributions::Stream logarithmic(0xAAAAAAAAAA);
  for (const double expected :
       {20.439453600381565, 361.02744404924573, 165.09469776147301, 6.530344331125505})
    EXPECT_NEAR(logarithmic.LogUniform(2, 1000), expected, 1e-14 * expected);
}

TEST(Stream, InverseNormalAtKnownPoints) {
  EXPECT_EQ(distributions::InverseNormal(0.5), 0);
  EXPECT_NEAR(distributions::InverseNormal(0.975), 1.9599639845400542, 1e-15 * 4);
  EXPECT_NEAR(distributions::InverseNormal(0.001), -3.090232306167813, 1e-15 * 4);
  EXPECT_NEAR(distributions::InverseNormal(1e-10), -6.361340902404056, 1e-15 * 8);
  EXPECT_NEAR(distributions::InverseNormal(0x1p-54), -8.292361075813595, 1e-15 * 16);
  EXPECT_TRUE(std::isfinite(distributions::InverseNormal(1)));
}

TEST(Stream, InverseNormalInvertsTheDistribution) {
  for (double p = 1e-12; p < 0.5; p = p * 1.3 + 1e-9) {
    const double x = distributions::InverseNormal(p);
    // d Phi = phi dx; a relative error of 4e-16 in x moves Phi by x phi 4e-16, and erfc has its
    // own.
    const double phi = std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi);
    EXPECT_NEAR(0.5 * std::erfc(-x / std::numbers::sqrt2), p,
                4e-16 * std::abs(x) * phi + 1e-14 * p);
    EXPECT_NEAR(distributions::InverseNormal(1 - p), -distributions::InverseNormal(1 - (1 - p)),
                1e-14 * std::abs(x) + 1e-15);
  }
}

TEST(Stream, LogAndExpAgreeWithTheStandards) {
  distributions::Stream stream(3);
  for (int i = 0; i < 100000; ++i) {
    const double x =
        std::ldexp(0.5 + stream.Uniform() / 2, static_cast<int>(stream.Uniform(-1000, 1000)));
    EXPECT_NEAR(distributions::Log(x), std::log(x), 4e-16 * std::abs(std::log(x)) + 1e-17);
    const double y = stream.Uniform(-700, 700);
    EXPECT_NEAR(distributions::Exp(y), std::exp(y), 6e-16 * std::exp(y));
  }
  EXPECT_EQ(distributions::Log(1), 0);
  EXPECT_EQ(distributions::Exp(0), 1);
}

TEST(Stream, UniformIsUniform) {
  EXPECT_LT(KsStatistic(Draws([](distributions::Stream& s) { return s.Uniform(-3, 5); }),
                        [](double x) { return (x + 3) / 8; }),
            kKs);
  // 1/(12 n) is the variance of a mean of n; five standard deviations.
  double sum = 0;
  for (const double x : Draws([](distributions::Stream& s) { return s.Uniform(); })) sum += x;
  EXPECT_NEAR(sum / kDraws, 0.5, 5 / std::sqrt(12.0 * kDraws));
}

TEST(Stream, NormalIsNormal) {
  const auto samples = Draws([](distributions::Stream& s) { return s.Normal(); });
  EXPECT_LT(
      KsStatistic(samples, [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }),
      kKs);
  // Of n draws, the moments 1 to 4 have the variances 1, 2, 15 and 96 over n.
  double moments[5] = {};
  for (const double x : samples)
    for (int k = 1; k <= 4; ++k) moments[k] += std::pow(x, k) / kDraws;
  EXPECT_NEAR(moments[1], 0, 5 * std::sqrt(1.0 / kDraws));
  EXPECT_NEAR(moments[2], 1, 5 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(moments[3], 0, 5 * std::sqrt(15.0 / kDraws));
  EXPECT_NEAR(moments[4], 3, 5 * std::sqrt(96.0 / kDraws));
}

TEST(Stream, LogUniformIsUniformInTheLogarithm) {
  EXPECT_LT(KsStatistic(Draws([](distributions::Stream& s) { return s.LogUniform(2, 1000); }),
                        [](double x) { return std::log(x / 2) / std::log(500.0); }),
            kKs);
}

TEST(Stream, TurnsAreUniform) {
  // The angle of a random rotation has the density (1 - cos a)/pi on [0, pi] (R. E. Miles, 1965),
  // and its axis is uniform on the sphere, so that each coordinate is uniform (Archimedes).
  std::vector<double> angles, heights;
  distributions::Stream stream(9);
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Quaterniond q = stream.Turn();
    EXPECT_NEAR(q.norm(), 1, 1e-14);
    angles.push_back(2 * std::acos(std::min(1.0, std::abs(q.w()))));
    heights.push_back(q.vec().normalized().y());
  }
  EXPECT_LT(KsStatistic(angles, [](double a) { return (a - std::sin(a)) / std::numbers::pi; }),
            kKs);
  EXPECT_LT(KsStatistic(heights, [](double y) { return (y + 1) / 2; }), kKs);
}

}  // namespace
}  // namespace cdb::tests
