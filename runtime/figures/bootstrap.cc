#include "runtime/figures/bootstrap.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "runtime/figures/numbers.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

constexpr std::size_t kMostEnumerated = 6, kDrawn = 1000;

/// The 97.5 % quantile of Student's t, by the expansion in powers of 1 / nu about that of the
/// normal distribution; within 0.3 % from nu = 4 on (Abramowitz and Stegun 26.7.5).
double StudentQuantile(double nu) {
  const double z = 1.959964, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
  return z + (z3 + z) / (4 * nu) + (5 * z5 + 16 * z3 + 3 * z) / (96 * nu * nu) +
         (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * nu * nu * nu);
}

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

}  // namespace cdb::figures
