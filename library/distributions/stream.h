// Random streams that are identical to the bit with every standard library.
//
// The engine is std::mt19937_64, which the standard specifies; the transforms are ours, because the
// standard's distributions differ between libraries. They use +, -, *, / and sqrt alone, which
// IEEE 754 rounds in one way (built with -ffp-contract=off):
//   Uniform       k / 2^53 with k the engine's upper 53 bits: [0, 1)
//   Normal        the inverse of the normal distribution at (k + 1/2) / 2^53 (Wichura 1988, AS 241)
//   LogUniform    exp(log a + (log b - log a) * Uniform), with Log and Exp below
//   Lognormal     exp(mu + sigma * Normal)
//   Exponential   -mean * log u with u = (k + 1/2) / 2^53
//   Weibull       scale * exp(log(-log u) / shape)
//   Gamma         Marsaglia and Tsang 2000, from Normal and u by rejection; shapes below 1 from the
//                 one above, times u^(1/shape)
//   Turn          Marsaglia 1972: two points in the unit disc, each by rejection
// Each draw takes one number of the engine, except for those by rejection.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <random>

namespace cdb::distributions {

/// One stream. Copies continue identically. Not thread-safe.
class Stream {
 public:
  explicit Stream(std::uint64_t seed) : engine_(seed) {}

  /// [0, 1).
  double Uniform();
  /// [minimum, maximum), or `minimum` if both are equal.
  double Uniform(double minimum, double maximum) {
    return minimum + (maximum - minimum) * Uniform();
  }
  /// Mean 0, standard deviation 1; never beyond 8.3.
  double Normal();
  /// minimum, maximum > 0.
  double LogUniform(double minimum, double maximum);
  /// The logarithm has mean mu and standard deviation sigma; |mu| + 9 sigma <= 700.
  double Lognormal(double mu, double sigma);
  double Exponential(double mean);
  /// Requires 0.01 <= shape, scale > 0; Weibull too.
  double Gamma(double shape, double scale);
  double Weibull(double shape, double scale);
  /// Uniform over all rotations; a unit quaternion.
  Eigen::Quaterniond Turn();

 private:
  /// In the open interval (0, 1).
  double Open();
  std::uint64_t Bits53() { return engine_() >> 11; }
  std::mt19937_64 engine_;
};

/// The quantile of the normal distribution (mean 0, standard deviation 1) at p, 0 < p < 1. Relative
/// error about 1e-16. M. J. Wichura, Algorithm AS 241, Applied Statistics 37 (1988).
double InverseNormal(double p);

/// Natural logarithm of x > 0 (normal) and its inverse, within 2 units in the last place, from
/// basic arithmetic only.
double Log(double x);
double Exp(double x);

}  // namespace cdb::distributions
