#include "runtime/compare/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unsupported/Eigen/SpecialFunctions>

namespace cdb::compare {
namespace {

/// The probability that Student's t with `nu` degrees of freedom exceeds `t` (Abramowitz and Stegun
/// 26.7.1).
double UpperTail(double t, double nu) {
  if (std::isinf(t)) return t > 0 ? 0 : 1;
  const double tail = Eigen::numext::betainc(nu / 2, 0.5, nu / (nu + t * t)) / 2;
  return t < 0 ? 1 - tail : tail;
}

/// The t that is exceeded with the probability `tail`, which is below 1 / 2; by bisection.
double ExceededWith(double tail, double nu) {
  double low = 0, high = 1;
  while (UpperTail(high, nu) > tail) high *= 2;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (UpperTail(middle, nu) > tail ? low : high) = middle;
  }
  return high;
}

/// Applies `combine` to the estimates over the draws of each file.
template <typename Combine>
Change CombinedChanges(const std::vector<Change>& parts, Combine combine) {
  std::vector<figures::Estimate> over_a, over_b;
  for (const Change& part : parts) {
    over_a.push_back(part.over_a);
    over_b.push_back(part.over_b);
  }
  return {combine(over_a), combine(over_b)};
}

/// The indices of the tests in `p`, the least p first.
std::vector<std::size_t> SortedTests(const std::vector<double>& p) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (!std::isnan(p[i])) order.push_back(i);
  std::ranges::stable_sort(order, {}, [&p](std::size_t i) { return p[i]; });
  return order;
}

}  // namespace

Change ChangeOf(const figures::Estimate& a, const figures::Estimate& b) {
  Change change = {{b.value / a.value, {}, a.things}, {b.value / a.value, {}, b.things}};
  for (const double drawn : a.drawn) change.over_a.drawn.push_back(b.value / drawn);
  for (const double drawn : b.drawn) change.over_b.drawn.push_back(drawn / a.value);
  return change;
}

Change GeometricMeanOf(const std::vector<Change>& parts) {
  return CombinedChanges(parts, [](const auto& of) { return GeometricMeanOf(of); });
}

Change MedianOf(const std::vector<Change>& parts) {
  return CombinedChanges(parts, [](const auto& of) { return MedianOf(of); });
}

Change RatioOf(const Change& above, const Change& below) {
  return {RatioOf(above.over_a, below.over_a), RatioOf(above.over_b, below.over_b)};
}

bool ChangeTest::HasIntervals() const {
  return a_.kind() == figures::IntervalKind::kInterval &&
         b_.kind() == figures::IntervalKind::kInterval;
}

TestedChange ChangeTest::Of(const Change& change) const {
  TestedChange tested = {.ratio = change.ratio()};
  if (!HasIntervals()) return tested;
  const double of_a = a_.LogVariance(change.over_a), of_b = b_.LogVariance(change.over_b);
  const double error = std::sqrt(of_a + of_b), log = std::log(change.ratio());
  if (!std::isfinite(error) || !std::isfinite(log)) return tested;
  const double negligible = std::log1p(kNegligible), size = std::fabs(log);
  if (error == 0) {
    tested.interval = {tested.ratio, tested.ratio};
    tested.p = size > negligible ? 0 : 1;
    return tested;
  }
  const double nu = (of_a + of_b) * (of_a + of_b) /
                    (of_a * of_a / static_cast<double>(a_.size() - 1) +
                     of_b * of_b / static_cast<double>(b_.size() - 1));
  const double reach = ExceededWith(0.025, nu) * error;
  tested.interval = {std::exp(log - reach), std::exp(log + reach)};
  tested.p = std::fmin(
      1, UpperTail((size - negligible) / error, nu) + UpperTail((size + negligible) / error, nu));
  return tested;
}

std::vector<double> HolmAdjusted(const std::vector<double>& p) {
  const std::vector<std::size_t> order = SortedTests(p);
  std::vector<double> adjusted = p;
  double most = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    most = std::fmax(most, static_cast<double>(order.size() - k) * p[order[k]]);
    adjusted[order[k]] = std::fmin(1, most);
  }
  return adjusted;
}

std::vector<double> BenjaminiHochbergAdjusted(const std::vector<double>& p) {
  const std::vector<std::size_t> order = SortedTests(p);
  std::vector<double> adjusted = p;
  double least = 1;
  for (std::size_t k = order.size(); k-- > 0;) {
    const double rank = static_cast<double>(k) + 1;
    least = std::fmin(least, static_cast<double>(order.size()) / rank * p[order[k]]);
    adjusted[order[k]] = least;
  }
  return adjusted;
}

ChangeVerdict JudgeChange(const TestedChange& change, double adjusted_p, double margin) {
  if (!change.IsTested()) return ChangeVerdict::kCannotTell;
  if (adjusted_p <= kSignificance)
    return change.ratio > 1 ? ChangeVerdict::kSlower : ChangeVerdict::kFaster;
  return change.Bound() <= margin ? ChangeVerdict::kSame : ChangeVerdict::kCannotTell;
}

}  // namespace cdb::compare
