// Intervals of a figure over a few repeats, or over a few seeds, by the bootstrap.
//
// n things are drawn n at a time with replacement, a figure is computed from each draw, and the
// interval lies between two percentiles of these figures (Efron and Tibshirani 1993, An
// Introduction to the Bootstrap, chapter 13). For few things, the 2.5 % and 97.5 % percentiles are
// too close: for the mean of five, they cover about 85 %. The percentiles are therefore widened to
//   Phi(-+ sqrt(n / (n - 1)) t(0.975, n - 1))
// (the expanded percentile interval of Hesterberg 2015, What Teachers Should Know About the
// Bootstrap, The American Statistician 69). The interval is extended to include the figure itself,
// because all draws may lie on one side of it, as they do for fewer unlike things. For 2 to 4
// things, these percentiles are beyond all draws: the result is the range of the draws, which is
// not a 95 % interval.
//
// The draws are the same in each execution. Figures over the same things use the same draws, so
// ratios and means of figures are paired.
//
// Between two results files (`cdb compare`), a figure is compared by interval, test, and correction
// for many tests.
//
// The repeats of two files are independent, because they ran on two occasions. The variance of the
// logarithm of a ratio b / a is therefore the sum of both files' variances, each by the bootstrap
// over whole repeats of its file. The interval uses Student's t with the degrees of
// freedom of Welch 1947 (The generalization of 'Student's' problem when several different
// population variances are involved, Biometrika 34).
//
// The test is of a minimum effect: p is the probability of a change at least as large if the true
// change were kNegligible (Murphy and Myors 1999, Testing the hypothesis that treatments have
// negligible effects, Journal of Applied Psychology 84). A new build moves code and data in memory,
// which alone changes times by about that much (Mytkowicz et al. 2009, Producing wrong data without
// doing anything obviously wrong, ASPLOS).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cdb::figures {

/// A missing number.
inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// NaN if there are no values.
inline double Mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// The exponential of the mean of the logarithms; NaN if there are no values.
inline double GeometricMean(const std::vector<double>& values) {
  double log = 0;
  for (const double value : values) log += std::log(value);
  return std::exp(log / static_cast<double>(values.size()));
}

/// The largest; missing numbers do not count.
inline double Largest(const std::vector<double>& values) {
  double largest = kNone;
  for (const double value : values) largest = std::fmax(largest, value);
  return largest;
}

/// The value below which a fraction `p` of the sorted values lies, interpolated linearly; NaN if
/// there are none.
inline double Percentile(const std::vector<double>& sorted, double p) {
  if (sorted.empty()) return kNone;
  const double place = p * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(place);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return std::lerp(sorted[low], sorted[high], place - static_cast<double>(low));
}

inline double Median(std::vector<double> values) {
  std::ranges::sort(values);
  return Percentile(values, 0.5);
}

/// The ends of an interval or a range; NaN if there is none.
struct Interval {
  double low, high;
  /// Ends that are NaN overlap nothing.
  bool Overlaps(const Interval& other) const { return low <= other.high && other.low <= high; }
};

/// A figure, and its values for all draws.
struct Estimate {
  double value;
  std::vector<double> drawn;  ///< one for each draw; empty without draws
  std::size_t things = 0;     ///< number of things; for a combination, the least of its parts
};
/// Computed for each draw. `parts` is not empty, and all parts belong to the same Bootstrap.
Estimate MeanOf(const std::vector<Estimate>& parts);
Estimate MeanOf(const std::vector<const Estimate*>& parts);
Estimate GeometricMeanOf(const std::vector<Estimate>& parts);
Estimate MedianOf(const std::vector<Estimate>& parts);
Estimate RatioOf(const Estimate& above, const Estimate& below);
Estimate Scaled(Estimate estimate, double factor);

enum class IntervalKind {
  kAbsent,    ///< a single thing
  kRange,     ///< too few things for an interval
  kInterval,  ///< a 95 % interval
};

/// `95 % interval`, `range`; empty for kAbsent.
std::string_view NameOf(IntervalKind kind);

/// One draw.
struct Draw {
  std::vector<std::uint32_t> counts;  ///< how often it contains each thing; the sum is n
  double weight;                      ///< its probability
};

class Bootstrap {
 public:
  static constexpr std::size_t kLeastForInterval = 5;

  /// All possible draws for up to 6 things, else 1000 of them; none for fewer than 2.
  explicit Bootstrap(std::size_t n);

  std::size_t size() const { return n_; }
  const std::vector<Draw>& draws() const { return draws_; }
  IntervalKind kind() const;
  /// The mean of `values`, one for each thing.
  Estimate MeanEstimate(const std::vector<double>& values) const;
  /// NaN for a figure over fewer than `size()` things, or over one.
  Interval IntervalOf(const Estimate& estimate) const;
  /// The variance of the logarithm of the figure over the draws, times n / (n - 1), because draws
  /// vary less than samples (Hesterberg 2015). NaN if IntervalOf has none.
  double LogVariance(const Estimate& estimate) const;

 private:
  void AddDraws(std::size_t thing, std::size_t left, Draw& draw);

  std::size_t n_;
  std::vector<Draw> draws_;
};

/// `1.19 .. 1.24`; `-` if there is none.
std::string IntervalText(const Interval& interval);

/// A ratio closer to 1 than this counts as no change.
inline constexpr double kNegligible = 0.01;
/// The accepted probability of a false alarm, or the accepted false discovery rate.
inline constexpr double kSignificance = 0.05;

/// A figure of file b over that of file a.
struct Change {
  Estimate over_a;  ///< for each draw of the repeats of a
  Estimate over_b;  ///< for each draw of the repeats of b
  double ratio() const { return over_a.value; }
};
Change ChangeOf(const Estimate& a, const Estimate& b);
/// `parts` belong to the same two files, and are not empty.
Change GeometricMeanOf(const std::vector<Change>& parts);
Change MedianOf(const std::vector<Change>& parts);
Change RatioOf(const Change& above, const Change& below);

struct TestedChange {
  double ratio = kNone;
  Interval interval = {kNone, kNone};  ///< of 95 %; NaN where there is none
  double p = kNone;                    ///< NaN without an interval
  bool IsTested() const { return !std::isnan(p); }
  /// The largest distance of the ratio from 1, in either direction: 0.02 for an interval of 0.99 ..
  /// 1.02.
  double Bound() const { return std::fmax(interval.high - 1, 1 - interval.low); }
};

/// The number of instructions of a run, counted again by the same build, differs by less than this
/// fraction (cdb doc compare). A larger change is one of the code.
inline constexpr double kCountNoise = 0.0005;

/// Tests changes between two files.
class ChangeTest {
 public:
  /// `noise`: of figures that are counted, and not measured: the interval is the ratio within it,
  /// whatever the number of repeats.
  ChangeTest(const Bootstrap& a, const Bootstrap& b, std::optional<double> noise = {})
      : a_(a), b_(b), noise_(noise) {}
  /// True if the figures are counted, or both files have enough repeats for an interval.
  bool HasIntervals() const;
  TestedChange Of(const Change& change) const;

 private:
  const Bootstrap &a_, &b_;
  const std::optional<double> noise_;
};

/// Adjusted p-values: an effect is significant if its value is at most kSignificance. NaN stays
/// NaN, and does not count as a test. Holm 1979, A simple sequentially rejective multiple test
/// procedure, Scandinavian Journal of Statistics 6: bounds the probability of any false alarm,
/// whatever the dependence between the tests.
std::vector<double> HolmAdjusted(const std::vector<double>& p);
/// Benjamini and Hochberg 1995, Controlling the false discovery rate, Journal of the Royal
/// Statistical Society B 57: bounds the expected fraction of false discoveries, also for tests that
/// depend on each other positively, as phases and points of one file do.
std::vector<double> BenjaminiHochbergAdjusted(const std::vector<double>& p);

enum class ChangeVerdict {
  kCannotTell,  ///< no interval, or a wide one that contains 1
  kSame,        ///< the interval is within the margin
  kFaster,
  kSlower,
};
/// `margin`: the largest distance from 1 of an interval that still counts as the same.
ChangeVerdict JudgeChange(const TestedChange& change, double adjusted_p, double margin);

/// The 97.5 % quantile of Student's t, by the expansion in powers of 1 / nu about that of the
/// normal distribution; within 0.3 % from nu = 4 on (Abramowitz and Stegun 26.7.5).
double StudentQuantile(double nu);
/// The probability that Student's t with `nu` degrees of freedom exceeds `t` (Abramowitz and Stegun
/// 26.7.1).
double StudentTail(double t, double nu);
/// The t that is exceeded with the probability `tail`, which is below 1 / 2; by bisection.
double StudentExceeded(double tail, double nu);

/// y ~ x^p, by least squares over the logarithms.
struct PowerFit {
  double p = kNone;
  Interval interval = {kNone, kNone};  ///< of 95 %, by Student's t over the residuals
};
/// Pairs of x and y that share a factor.
using PowerGroup = std::vector<std::pair<double, double>>;
/// One power for all groups, with a factor for each. Groups with fewer than three different x, or
/// with a value that is not positive, are left out; NaN if none is left.
PowerFit FitPower(const std::vector<PowerGroup>& groups);

}  // namespace cdb::figures
