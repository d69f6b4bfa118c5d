#include "runtime/figures/bootstrap.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <unsupported/Eigen/SpecialFunctions>
#include <utility>

#include "runtime/terminal/table.h"

namespace cdb::figures {

double StudentQuantile(double nu) {
  const double z = 1.959964, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
  return z + (z3 + z) / (4 * nu) + (5 * z5 + 16 * z3 + 3 * z) / (96 * nu * nu) +
         (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * nu * nu * nu);
}

double StudentTail(double t, double nu) {
  if (std::isinf(t)) return t > 0 ? 0 : 1;
  const double tail = Eigen::numext::betainc(nu / 2, 0.5, nu / (nu + t * t)) / 2;
  return t < 0 ? 1 - tail : tail;
}

double StudentExceeded(double tail, double nu) {
  double low = 0, high = 1;
  while (StudentTail(high, nu) > tail) high *= 2;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (StudentTail(middle, nu) > tail ? low : high) = middle;
  }
  return high;
}

namespace {

constexpr std::size_t kMostEnumerated = 6, kDrawn = 1000;

/// The fraction of the draws beyond each end of the interval.
double TailOf(std::size_t n) {
  const auto count = static_cast<double>(n);
  return std::erfc(std::sqrt(count / (count - 1)) * StudentQuantile(count - 1) / std::sqrt(2)) / 2;
}

/// Applies `combine` to all parts, for each draw.
template <typename Combine>
Estimate Combined(const std::vector<const Estimate*>& parts, Combine combine) {
  std::vector<double> values(parts.size());
  const auto of = [&](auto value_of) {
    std::ranges::transform(parts, values.begin(),
                           [&](const Estimate* part) { return value_of(*part); });
    return combine(values);
  };
  Estimate all = {of([](const Estimate& part) { return part.value; }), {}, parts[0]->things};
  for (const Estimate* part : parts) all.things = std::min(all.things, part->things);
  for (std::size_t i = 0; i < parts[0]->drawn.size(); ++i)
    all.drawn.push_back(of([i](const Estimate& part) { return part.drawn[i]; }));
  return all;
}

std::vector<const Estimate*> PointersTo(const std::vector<Estimate>& parts) {
  std::vector<const Estimate*> pointers;
  for (const Estimate& part : parts) pointers.push_back(&part);
  return pointers;
}

/// Applies `combine` to the estimates over the draws of each file.
template <typename Combine>
Change CombinedChanges(const std::vector<Change>& parts, Combine combine) {
  std::vector<Estimate> over_a, over_b;
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

Estimate MeanOf(const std::vector<const Estimate*>& parts) { return Combined(parts, Mean); }

Estimate MeanOf(const std::vector<Estimate>& parts) { return MeanOf(PointersTo(parts)); }

Estimate GeometricMeanOf(const std::vector<Estimate>& parts) {
  return Combined(PointersTo(parts), GeometricMean);
}

Estimate MedianOf(const std::vector<Estimate>& parts) {
  return Combined(PointersTo(parts), Median);
}

Estimate RatioOf(const Estimate& above, const Estimate& below) {
  return Combined({&above, &below}, [](const auto& pair) { return pair[0] / pair[1]; });
}

Estimate Scaled(Estimate estimate, double factor) {
  estimate.value *= factor;
  for (double& value : estimate.drawn) value *= factor;
  return estimate;
}

Bootstrap::Bootstrap(std::size_t n) : n_(n) {
  if (n < 2) return;
  if (n <= kMostEnumerated) {
    Draw draw = {std::vector<std::uint32_t>(n), 1};
    AddDraws(0, n, draw);
    return;
  }
  std::mt19937_64 random(20090423);
  std::map<std::vector<std::uint32_t>, double> weights;
  for (std::size_t i = 0; i < kDrawn; ++i) {
    std::vector<std::uint32_t> counts(n);
    for (std::size_t k = 0; k < n; ++k) ++counts[random() % n];
    weights[counts] += 1.0 / kDrawn;
  }
  for (const auto& [counts, weight] : weights) draws_.push_back({counts, weight});
}

/// All ways to draw `left` times from the things from `thing` on. The weight is n! / (prod of
/// counts!) / n^n.
void Bootstrap::AddDraws(std::size_t thing, std::size_t left, Draw& draw) {
  const auto n = static_cast<double>(n_);
  if (thing + 1 == n_) {
    draw.counts[thing] = static_cast<std::uint32_t>(left);
    double weight = std::tgamma(n + 1) / std::pow(n, n);
    for (const std::uint32_t count : draw.counts) weight /= std::tgamma(count + 1.0);
    draws_.push_back({draw.counts, weight});
    return;
  }
  for (std::size_t count = 0; count <= left; ++count) {
    draw.counts[thing] = static_cast<std::uint32_t>(count);
    AddDraws(thing + 1, left - count, draw);
  }
}

std::string_view NameOf(IntervalKind kind) {
  constexpr std::string_view kNames[] = {"", "range", "95 % interval"};
  return kNames[static_cast<std::size_t>(kind)];
}

IntervalKind Bootstrap::kind() const {
  if (n_ < 2) return IntervalKind::kAbsent;
  return n_ < kLeastForInterval ? IntervalKind::kRange : IntervalKind::kInterval;
}

Estimate Bootstrap::MeanEstimate(const std::vector<double>& values) const {
  Estimate estimate = {Mean(values), {}, values.size()};
  for (const Draw& draw : draws_) {
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i) sum += draw.counts[i] * values[i];
    estimate.drawn.push_back(sum / static_cast<double>(n_));
  }
  return estimate;
}

Interval Bootstrap::IntervalOf(const Estimate& estimate) const {
  if (kind() == IntervalKind::kAbsent || estimate.things < n_) return {kNone, kNone};
  std::vector<std::pair<double, double>> weighted;
  for (std::size_t i = 0; i < draws_.size(); ++i) {
    if (!std::isfinite(estimate.drawn[i])) return {kNone, kNone};
    weighted.emplace_back(estimate.drawn[i], draws_[i].weight);
  }
  std::ranges::sort(weighted);
  const double tail = kind() == IntervalKind::kRange ? 0 : TailOf(n_);
  // The first value at which the summed weights exceed the tail, within rounding.
  const auto reach = [tail](auto from, auto end) {
    double sum = 0;
    while (from + 1 != end && (sum += from->second) <= tail) ++from;
    return from->first;
  };
  return {std::min(estimate.value, reach(weighted.begin(), weighted.end())),
          std::max(estimate.value, reach(weighted.rbegin(), weighted.rend()))};
}

double Bootstrap::LogVariance(const Estimate& estimate) const {
  if (kind() == IntervalKind::kAbsent || estimate.things < n_) return kNone;
  double mean = 0, square = 0;
  for (std::size_t i = 0; i < draws_.size(); ++i)
    mean += draws_[i].weight * std::log(estimate.drawn[i]);
  for (std::size_t i = 0; i < draws_.size(); ++i) {
    const double distance = std::log(estimate.drawn[i]) - mean;
    square += draws_[i].weight * distance * distance;
  }
  const auto n = static_cast<double>(n_);
  return square * n / (n - 1);
}

std::string IntervalText(const Interval& interval) {
  if (std::isnan(interval.low)) return "-";
  return terminal::ShortNumber(interval.low) + " .. " + terminal::ShortNumber(interval.high);
}

Change ChangeOf(const Estimate& a, const Estimate& b) {
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
  return noise_ || (a_.kind() == IntervalKind::kInterval && b_.kind() == IntervalKind::kInterval);
}

TestedChange ChangeTest::Of(const Change& change) const {
  TestedChange tested = {.ratio = change.ratio()};
  if (!HasIntervals()) return tested;
  if (noise_) {
    if (!(tested.ratio > 0) || !std::isfinite(tested.ratio)) return tested;
    tested.interval = {tested.ratio / (1 + *noise_), tested.ratio * (1 + *noise_)};
    tested.p = tested.interval.low > 1 || tested.interval.high < 1 ? 0 : 1;
    return tested;
  }
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
  const double reach = StudentExceeded(0.025, nu) * error;
  tested.interval = {std::exp(log - reach), std::exp(log + reach)};
  tested.p = std::fmin(1, StudentTail((size - negligible) / error, nu) +
                              StudentTail((size + negligible) / error, nu));
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

// Fits of powers.

namespace {

/// Sums of squares of logarithms about their means.
struct Squares {
  double xx = 0, xy = 0, yy = 0, freedom = -1;  ///< one degree of freedom is that of the power

  void Add(const PowerGroup& group) {
    std::vector<double> xs, ys;
    for (const auto& [x, y] : group) {
      if (!(x > 0) || !(y > 0)) return;
      xs.push_back(std::log(x));
      ys.push_back(std::log(y));
    }
    constexpr std::size_t kLeastValues = 3;
    if (std::set<double>(xs.begin(), xs.end()).size() < kLeastValues) return;
    const double middle_x = Mean(xs), middle_y = Mean(ys);
    for (std::size_t i = 0; i < xs.size(); ++i) {
      const double x = xs[i] - middle_x, y = ys[i] - middle_y;
      xx += x * x;
      xy += x * y;
      yy += y * y;
    }
    freedom += static_cast<double>(xs.size() - 1);
  }
};

}  // namespace

PowerFit FitPower(const std::vector<PowerGroup>& groups) {
  Squares sum;
  for (const PowerGroup& group : groups) sum.Add(group);
  if (!(sum.xx > 0)) return {};
  const double p = sum.xy / sum.xx;
  const double residual = std::fmax(sum.yy - p * sum.xy, 0);
  const double half =
      StudentExceeded(kSignificance / 2, sum.freedom) * std::sqrt(residual / sum.freedom / sum.xx);
  return {p, {p - half, p + half}};
}

}  // namespace cdb::figures
