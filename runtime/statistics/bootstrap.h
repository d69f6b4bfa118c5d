// Intervals of a figure over a few repeats, or over a few seeds, by the bootstrap.
//
// n things are drawn n at a time with replacement, a figure is computed anew from each draw, and
// the interval lies between two percentiles of these figures (Efron and Tibshirani 1993, An
// Introduction to the Bootstrap, chapter 13). For few things, 2.5 % and 97.5 % lie too close: for
// the mean of five they cover about 85 %. So the percentiles are widened to
//   Phi(-+ sqrt(n / (n - 1)) t(0.975, n - 1))
// (the expanded percentile interval of Hesterberg 2015, What Teachers Should Know About the
// Bootstrap, The American Statistician 69), and the interval reaches to the figure itself, from
// which all draws may lie on one side, as they are of fewer unlike things. For 2 to 4 things that
// is beyond all draws: there is a range of the draws, which is not an interval of 95 %.
//
// All draws are the same in each execution. Figures that share their things have the same draws,
// so that ratios and means of figures are paired.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cdb::statistics {

/// The ends of an interval or a range; NaN where there is none.
struct Interval {
  double low, high;
  /// Ends that are NaN overlap nothing.
  bool Overlaps(const Interval& other) const { return low <= other.high && other.low <= high; }
};

/// A figure, and the same from each draw.
struct Estimate {
  double value;
  std::vector<double> drawn;  ///< one for each draw; empty without draws
  std::size_t things = 0;     ///< that it is of; the least where it combines several
};
/// Draw by draw. `parts` is not empty, and all of them are of the same Bootstrap.
Estimate MeanOf(const std::vector<Estimate>& parts);
Estimate GeometricMeanOf(const std::vector<Estimate>& parts);
Estimate MedianOf(const std::vector<Estimate>& parts);
Estimate RatioOf(const Estimate& above, const Estimate& below);
Estimate Scaled(Estimate estimate, double factor);

enum class IntervalKind {
  kAbsent,    ///< of a single thing
  kRange,     ///< of too few for an interval
  kInterval,  ///< of 95 %
};

/// One draw.
struct Draw {
  std::vector<std::uint32_t> counts;  ///< how often it has each thing; the sum is n
  double weight;                      ///< its probability
};

class Bootstrap {
 public:
  static constexpr std::size_t kLeastForInterval = 5;

  /// All draws that there are for up to 6 things, else 1000 of them; none for fewer than 2.
  explicit Bootstrap(std::size_t n);

  std::size_t size() const { return n_; }
  const std::vector<Draw>& draws() const { return draws_; }
  IntervalKind kind() const;
  /// The mean of `values`, one for each thing.
  Estimate MeanEstimate(const std::vector<double>& values) const;
  /// NaN for a figure that is of fewer than `size()` things, or of one.
  Interval IntervalOf(const Estimate& estimate) const;
  /// Of the logarithm of the figure: the variance over the draws, times n / (n - 1), as draws vary
  /// less than samples do (Hesterberg 2015). NaN where IntervalOf has none.
  double LogVariance(const Estimate& estimate) const;

 private:
  void AddDraws(std::size_t thing, std::size_t left, Draw& draw);

  std::size_t n_;
  std::vector<Draw> draws_;
};

/// `1.19 .. 1.24`; `-` where there is none.
std::string IntervalText(const Interval& interval);

}  // namespace cdb::statistics
