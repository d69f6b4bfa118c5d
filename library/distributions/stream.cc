#include "library/distributions/stream.h"

#include <cmath>

namespace cdb::distributions {
namespace {

constexpr double kTwoToMinus53 = 0x1p-53;
// ln 2 in two parts; multiples of the first up to 2^11 are exact.
constexpr double kLn2High = 6.93147180369123816490e-01;
constexpr double kLn2Low = 1.90821492927058770002e-10;

template <std::size_t n>
double Polynomial(const double (&coefficients)[n], double x) {
  double value = coefficients[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) value = value * x + coefficients[i];
  return value;
}

}  // namespace

double Stream::Uniform() { return static_cast<double>(Bits53()) * kTwoToMinus53; }

double Stream::Normal() {
  return InverseNormal((static_cast<double>(Bits53()) + 0.5) * kTwoToMinus53);
}

double Stream::LogUniform(double minimum, double maximum) {
  const double low = Log(minimum);
  return Exp(low + (Log(maximum) - low) * Uniform());
}

double Stream::Open() {
  // (k + 1/2) / 2^53 rounds to 1 for the largest k.
  const double u = (static_cast<double>(Bits53()) + 0.5) * kTwoToMinus53;
  return u < 1 ? u : 1 - kTwoToMinus53;
}

double Stream::Lognormal(double mu, double sigma) { return Exp(mu + sigma * Normal()); }

double Stream::Exponential(double mean) { return -mean * Log(Open()); }

double Stream::Weibull(double shape, double scale) {
  return scale * Exp(Log(-Log(Open())) / shape);
}

double Stream::Gamma(double shape, double scale) {
  if (shape < 1) {
    const double above = Gamma(shape + 1, scale);
    return above * Exp(Log(Open()) / shape);
  }
  const double d = shape - 1.0 / 3, c = 1 / std::sqrt(9 * d);
  while (true) {
    const double x = Normal();
    const double root = 1 + c * x;
    if (root <= 0) continue;
    const double v = root * root * root;
    if (Log(Open()) < x * x / 2 + d - d * v + d * Log(v)) return scale * d * v;
  }
}

Eigen::Quaterniond Stream::Turn() {
  double x[2], y[2], s[2];
  for (int i = 0; i < 2; ++i) {
    do {
      x[i] = Uniform(-1, 1);
      y[i] = Uniform(-1, 1);
      s[i] = x[i] * x[i] + y[i] * y[i];
    } while (s[i] >= 1 || s[i] == 0);
  }
  const double scale = std::sqrt((1 - s[0]) / s[1]);
  return {x[0], y[0], x[1] * scale, y[1] * scale};
}

double InverseNormal(double p) {
  // (k + 1/2) / 2^53 rounds to 1 for the largest k.
  if (p >= 1) p = 1 - kTwoToMinus53;
  constexpr double kA[] = {3.3871328727963666080e0,  1.3314166789178437745e+2,
                           1.9715909503065514427e+3, 1.3731693765509461125e+4,
                           4.5921953931549871457e+4, 6.7265770927008700853e+4,
                           3.3430575583588128105e+4, 2.5090809287301226727e+3};
  constexpr double kB[] = {1.0,
                           4.2313330701600911252e+1,
                           6.8718700749205790830e+2,
                           5.3941960214247511077e+3,
                           2.1213794301586595867e+4,
                           3.9307895800092710610e+4,
                           2.8729085735721942674e+4,
                           5.2264952788528545610e+3};
  constexpr double kC[] = {1.42343711074968357734e0,  4.63033784615654529590e0,
                           5.76949722146069140550e0,  3.64784832476320460504e0,
                           1.27045825245236838258e0,  2.41780725177450611770e-1,
                           2.27238449892691845833e-2, 7.74545014278341407640e-4};
  constexpr double kD[] = {1.0,
                           2.05319162663775882187e0,
                           1.67638483018380384940e0,
                           6.89767334985100004550e-1,
                           1.48103976427480074590e-1,
                           1.51986665636164571966e-2,
                           5.47593808499534494600e-4,
                           1.05075007164441684324e-9};
  constexpr double kE[] = {6.65790464350110377720e0,  5.46378491116411436990e0,
                           1.78482653991729133580e0,  2.96560571828504891230e-1,
                           2.65321895265761230930e-2, 1.24266094738807843860e-3,
                           2.71155556874348757815e-5, 2.01033439929228813265e-7};
  constexpr double kF[] = {1.0,
                           5.99832206555887937690e-1,
                           1.36929880922735805310e-1,
                           1.48753612908506148525e-2,
                           7.86869131145613259100e-4,
                           1.84631831751005468180e-5,
                           1.42151175831644588870e-7,
                           2.04426310338993978564e-15};
  const double q = p - 0.5;
  if (std::fabs(q) <= 0.425) {
    const double r = 0.180625 - q * q;
    return q * Polynomial(kA, r) / Polynomial(kB, r);
  }
  const double r = std::sqrt(-Log(q < 0 ? p : 1 - p));
  const double x = r <= 5 ? Polynomial(kC, r - 1.6) / Polynomial(kD, r - 1.6)
                          : Polynomial(kE, r - 5) / Polynomial(kF, r - 5);
  return q < 0 ? -x : x;
}

double Log(double x) {
  int exponent = 0;
  double m = std::frexp(x, &exponent);  // exact
  if (m < 0.70710678118654752440) {
    m *= 2;
    --exponent;
  }
  // log m = 2 artanh s; |s| < 0.172, so that the 12th term is below 1e-18 of the first.
  const double s = (m - 1) / (m + 1);
  const double z = s * s;
  double sum = 0;
  for (int n = 25; n >= 3; n -= 2) sum = (sum + 1.0 / n) * z;
  return exponent * kLn2High + (2 * s + (2 * s * sum + exponent * kLn2Low));
}

double Exp(double x) {
  const double k = std::floor(x / (kLn2High + kLn2Low) + 0.5);
  const double r = (x - k * kLn2High) - k * kLn2Low;
  // |r| <= 0.347: the 15th term is below 1e-18.
  double sum = 1;
  for (int n = 15; n >= 1; --n) sum = 1 + sum * r / n;
  return std::ldexp(sum, static_cast<int>(k));  // exact, but below the normal numbers
}

}  // namespace cdb::distributions
