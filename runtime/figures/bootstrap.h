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
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::figures {

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

}  // namespace cdb::figures
