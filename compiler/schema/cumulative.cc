#include "compiler/schema/cumulative.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "dsl/text/check.h"

namespace cdb::schema {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
/// The part of a normal distribution beyond three deviations, on one side.
constexpr double kBeyondThree = 1.3498980316300945e-3;

double ArgumentOf(const Distribution& distribution, std::size_t i) {
  const Number* number = AsNumber(distribution.arguments.at(i));
  CDB_CHECK(number != nullptr);
  return number->AsReal();
}

double NormalAt(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

/// The fraction, by weight, of the choices that are at most x, or below it.
double PartOf(const Distribution& choices, double x, bool or_equal) {
  double sum = 0, all = 0;
  for (std::size_t i = 0; i < choices.arguments.size(); ++i) {
    const double value = ArgumentOf(choices, i);
    const double weight = choices.weights.empty() ? 1 : choices.weights[i];
    all += weight;
    if (value < x || (or_equal && value == x)) sum += weight;
  }
  return sum / all;
}

double GammaSeries(double a, double x) {
  double term = 1 / a, sum = term;
  for (double n = a + 1; term > sum * 1e-17; ++n) {
    term *= x / n;
    sum += term;
  }
  return sum * std::exp(a * std::log(x) - x - std::lgamma(a));
}

/// Lentz's method; gives 1 - P.
double GammaFraction(double a, double x) {
  constexpr double kTiny = 1e-300;
  constexpr int kMost = 10000;
  double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, h = d;
  for (int i = 1; i < kMost; ++i) {
    const double an = -i * (i - a);
    b += 2;
    d = an * d + b;
    if (std::fabs(d) < kTiny) d = kTiny;
    c = b + an / c;
    if (std::fabs(c) < kTiny) c = kTiny;
    d = 1 / d;
    h *= d * c;
    if (std::fabs(d * c - 1) < 1e-16) break;
  }
  return h * std::exp(a * std::log(x) - x - std::lgamma(a));
}

/// A gamma distribution with scale 1 at three deviations to the side of `sign`, by the cube of
/// Wilson and Hilferty (1931), which is normal to within a few per cent.
double UsualGamma(double shape, double sign) {
  const double root = 1 - 1 / (9 * shape) + sign * 3 / (3 * std::sqrt(shape));
  return root > 0 ? shape * root * root * root : 0;
}

/// The value, if only one can be drawn.
std::optional<double> ConstantOf(const Distribution& d) {
  const bool is_pair =
      d.kind == DistributionKind::kUniform || d.kind == DistributionKind::kLogUniform;
  if (is_pair && ArgumentOf(d, 0) == ArgumentOf(d, 1)) return ArgumentOf(d, 0);
  const bool is_normal =
      d.kind == DistributionKind::kNormal || d.kind == DistributionKind::kLognormal;
  if (!is_normal || ArgumentOf(d, 1) != 0) return std::nullopt;
  return d.kind == DistributionKind::kNormal ? ArgumentOf(d, 0) : std::exp(ArgumentOf(d, 0));
}

Limits RangeOf(const Distribution& d) {
  const auto argument = [&](std::size_t i) { return ArgumentOf(d, i); };
  switch (d.kind) {
    case DistributionKind::kUniform:
    case DistributionKind::kLogUniform:
      return {argument(0), argument(1)};
    case DistributionKind::kNormal:
      return {argument(0) - 3 * argument(1), argument(0) + 3 * argument(1)};
    case DistributionKind::kLognormal:
      return {std::exp(argument(0) - 3 * argument(1)), std::exp(argument(0) + 3 * argument(1))};
    case DistributionKind::kExponential:
      return {argument(0) * kBeyondThree, -argument(0) * std::log(kBeyondThree)};
    case DistributionKind::kGamma:
      return {argument(1) * UsualGamma(argument(0), -1), argument(1) * UsualGamma(argument(0), 1)};
    case DistributionKind::kWeibull:
      return {argument(1) * std::pow(kBeyondThree, 1 / argument(0)),
              argument(1) * std::pow(-std::log(kBeyondThree), 1 / argument(0))};
    case DistributionKind::kEmpirical:
    case DistributionKind::kAny:
      break;
  }
  Limits range{kInfinite, -kInfinite};
  for (std::size_t i = 0; i < d.arguments.size(); ++i) {
    range.least = std::min(range.least, argument(i));
    range.most = std::max(range.most, argument(i));
  }
  return range;
}

}  // namespace

double IncompleteGamma(double a, double x) {
  if (x <= 0) return 0;
  if (x == kInfinite) return 1;
  return x < a + 1 ? GammaSeries(a, x) : 1 - GammaFraction(a, x);
}

double CumulativeAt(const Distribution& d, double x) {
  const auto argument = [&](std::size_t i) { return ArgumentOf(d, i); };
  const auto ramp = [](double at, double low, double high) {
    return std::clamp((at - low) / (high - low), 0.0, 1.0);
  };
  if (const auto constant = ConstantOf(d)) return x >= *constant ? 1 : 0;
  switch (d.kind) {
    case DistributionKind::kUniform:
      return ramp(x, argument(0), argument(1));
    case DistributionKind::kNormal:
      return NormalAt((x - argument(0)) / argument(1));
    case DistributionKind::kLogUniform:
      return x <= 0 ? 0 : ramp(std::log(x), std::log(argument(0)), std::log(argument(1)));
    case DistributionKind::kLognormal:
      return x <= 0 ? 0 : NormalAt((std::log(x) - argument(0)) / argument(1));
    case DistributionKind::kExponential:
      return x <= 0 ? 0 : -std::expm1(-x / argument(0));
    case DistributionKind::kGamma:
      return x <= 0 ? 0 : IncompleteGamma(argument(0), x / argument(1));
    case DistributionKind::kWeibull:
      return x <= 0 ? 0 : -std::expm1(-std::pow(x / argument(1), argument(0)));
    case DistributionKind::kEmpirical:
    case DistributionKind::kAny:
      break;
  }
  return PartOf(d, x, true);
}

double ChanceWithin(const Distribution& d, double low, double high) {
  if (!(low <= high)) return 0;
  const bool is_discrete =
      d.kind == DistributionKind::kEmpirical || d.kind == DistributionKind::kAny;
  if (is_discrete) return PartOf(d, high, true) - PartOf(d, low, false);
  if (const auto constant = ConstantOf(d)) return *constant >= low && *constant <= high ? 1 : 0;
  return CumulativeAt(d, high) - CumulativeAt(d, low);
}

Limits UsualRange(const Distribution& distribution) {
  Limits range = RangeOf(distribution);
  if (!distribution.limits) return range;
  return {std::max(range.least, distribution.limits->least),
          std::min(range.most, distribution.limits->most)};
}

}  // namespace cdb::schema
