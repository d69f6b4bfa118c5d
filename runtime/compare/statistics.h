// Tests whether a figure differs between two results files: interval, test, and correction for many
// tests (`cdb compare`).
//
// The repeats of two files are independent, because they ran on two occasions. The variance of the
// logarithm of a ratio b / a is therefore the sum of both files' variances, each by the bootstrap
// over whole repeats of its file (bootstrap.h). The interval uses Student's t with the degrees of
// freedom of Welch 1947 (The generalization of 'Student's' problem when several different
// population variances are involved, Biometrika 34).
//
// The test is of a minimum effect: p is the probability of a change at least as large if the true
// change were kNegligible (Murphy and Myors 1999, Testing the hypothesis that treatments have
// negligible effects, Journal of Applied Psychology 84). A new build moves code and data in memory,
// which alone changes times by about that much (Mytkowicz et al. 2009, Producing wrong data without
// doing anything obviously wrong, ASPLOS).
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "runtime/figures/bootstrap.h"
#include "runtime/figures/numbers.h"

namespace cdb::compare {

/// A ratio closer to 1 than this counts as no change.
inline constexpr double kNegligible = 0.01;
/// The accepted probability of a false alarm, or the accepted false discovery rate.
inline constexpr double kSignificance = 0.05;

/// A figure of file b over that of file a.
struct Change {
  figures::Estimate over_a;  ///< for each draw of the repeats of a
  figures::Estimate over_b;  ///< for each draw of the repeats of b
  double ratio() const { return over_a.value; }
};
Change ChangeOf(const figures::Estimate& a, const figures::Estimate& b);
/// `parts` belong to the same two files, and are not empty.
Change GeometricMeanOf(const std::vector<Change>& parts);
Change MedianOf(const std::vector<Change>& parts);
Change RatioOf(const Change& above, const Change& below);

struct TestedChange {
  double ratio = figures::kNone;
  figures::Interval interval = {figures::kNone,
                                figures::kNone};  ///< of 95 %; NaN where there is none
  double p = figures::kNone;                      ///< NaN without an interval
  bool IsTested() const { return !std::isnan(p); }
  /// The largest distance of the ratio from 1, in either direction: 0.02 for an interval of 0.99 ..
  /// 1.02.
  double Bound() const { return std::fmax(interval.high - 1, 1 - interval.low); }
};

/// Tests changes between two files.
class ChangeTest {
 public:
  ChangeTest(const figures::Bootstrap& a, const figures::Bootstrap& b) : a_(a), b_(b) {}
  /// True if both files have enough repeats for an interval.
  bool HasIntervals() const;
  TestedChange Of(const Change& change) const;

 private:
  const figures::Bootstrap &a_, &b_;
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

}  // namespace cdb::compare
