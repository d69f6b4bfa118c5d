// Whether a figure of one results file differs from that of another: interval, test, correction for
// many tests (`cdb compare`).
//
// The repeats of two files are independent: they ran on two occasions. So the logarithm of a ratio
// b / a has the variance of both, each by the bootstrap over whole repeats of its own file
// (bootstrap.h), and Student's t with the degrees of freedom of Welch 1947 (The generalization of
// 'Student's' problem when several different population variances are involved, Biometrika 34).
//
// The test is of a minimum effect: p is the probability of a change at least as large if the true
// one were kNegligible (Murphy and Myors 1999, Testing the hypothesis that treatments have
// negligible effects, Journal of Applied Psychology 84). Another build moves code and data in
// memory, which alone changes times by about that much (Mytkowicz et al. 2009, Producing wrong data
// without doing anything obviously wrong, ASPLOS).
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "runtime/statistics/bootstrap.h"
#include "runtime/terminal/numbers.h"

namespace cdb::compare {

/// A ratio nearer to 1 than this is no change.
inline constexpr double kNegligible = 0.01;
/// The chance of a false alarm, or the expected part of them, that is accepted.
inline constexpr double kSignificance = 0.05;

/// A figure of file b over that of file a.
struct Change {
  statistics::Estimate over_a;  ///< with each draw of the repeats of a
  statistics::Estimate over_b;  ///< with each draw of those of b
  double ratio() const { return over_a.value; }
};
Change ChangeOf(const statistics::Estimate& a, const statistics::Estimate& b);
/// `parts` are of the same two files, and not empty.
Change GeometricMeanOf(const std::vector<Change>& parts);
Change MedianOf(const std::vector<Change>& parts);
Change RatioOf(const Change& above, const Change& below);

struct TestedChange {
  double ratio = terminal::kNone;
  statistics::Interval interval = {terminal::kNone,
                                   terminal::kNone};  ///< of 95 %; NaN where there is none
  double p = terminal::kNone;                         ///< NaN without an interval
  bool IsTested() const { return !std::isnan(p); }
  /// The farthest that the ratio may be from 1, both ways: 0.02 for an interval of 0.99 .. 1.02.
  double Bound() const { return std::fmax(interval.high - 1, 1 - interval.low); }
};

/// Tests changes between two files.
class ChangeTest {
 public:
  ChangeTest(const statistics::Bootstrap& a, const statistics::Bootstrap& b) : a_(a), b_(b) {}
  /// Both files have the repeats that an interval takes.
  bool HasIntervals() const;
  TestedChange Of(const Change& change) const;

 private:
  const statistics::Bootstrap &a_, &b_;
};

/// Adjusted p-values: an effect is significant if its own is at most kSignificance. NaN stays NaN,
/// and is no test.
/// Holm 1979, A simple sequentially rejective multiple test procedure, Scandinavian Journal of
/// Statistics 6: the chance of any false alarm is bounded, however the tests depend on each other.
std::vector<double> HolmAdjusted(const std::vector<double>& p);
/// Benjamini and Hochberg 1995, Controlling the false discovery rate, Journal of the Royal
/// Statistical Society B 57: the expected part of false ones among those found is bounded, also if
/// tests depend on each other positively, as phases and points of one file do.
std::vector<double> BenjaminiHochbergAdjusted(const std::vector<double>& p);

enum class ChangeVerdict {
  kCannotTell,  ///< no interval, or a wide one that has 1 in it
  kSame,        ///< the interval is within the margin
  kFaster,
  kSlower,
};
/// `margin`: how far from 1 the interval of two that are the same may reach.
ChangeVerdict JudgeChange(const TestedChange& change, double adjusted_p, double margin);

}  // namespace cdb::compare
