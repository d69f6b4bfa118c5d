// Changes of a figure over the commits of a project: steps and drifts.
//
// Steps are found as by Hunter (Fleming et al. 2023, Hunter: Using Change Point Detection to Hunt
// for Performance Regressions, ICPE), now Apache Otava: a segment is split where the energy
// statistic of E-divisive (Matteson and James 2014, A nonparametric approach for multiple change
// point analysis of multivariate data, Journal of the American Statistical Association 109) is
// largest, the split is accepted by a t test, and both parts are searched in turn. Differences:
// - The difference is tested over the larger one of Welch's standard error and that of the pooled
//   variance, corrected for the positions of a split and for the series that are searched. Welch's
//   alone accepts three values that are close to each other by chance, the pooled one a short
//   segment that is noisier than the rest.
// - A change and its revert, which no single split shows, are found as a short segment that differs
//   from all others.
// - Values are limited to 3 robust standard deviations from the median of five, so that a single
//   outlier is no change.
//
// A slope looks like a few steps of one direction. Such steps are a drift if a ramp between two
// levels explains the values with less loss and fewer parameters (Schwarz 1978, Estimating the
// Dimension of a Model, The Annals of Statistics 6). A segment without steps has a drift if its
// regression on the position is significant, and better than a single step.
//
// `cdb doc history` states the rates of false alarms and of changes that are found. Threads: any.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace cdb::history {

/// The limits of a search.
struct SearchLimits {
  /// Changes of a ratio below this are not reported.
  double least_effect = 0.01;
  /// The accepted probability of any false alarm in all series together.
  double significance = 0.001;
  std::size_t series = 1;  ///< number of series that are searched
};

/// The least number of commits before and after a step, and of a drift.
inline constexpr std::size_t kLeastSegment = 3, kLeastDrift = 8;

struct Change {
  bool is_drift;
  /// Indices: of a step, the last commit before it and the first after it, which are adjacent; of a
  /// drift, those between which it adds up.
  std::size_t from, to;
  double log_ratio;  ///< of the level after it to that before it
  double low, high;  ///< its 95 % interval, by Student's t
  double p;          ///< adjusted
};

/// `logs`: the logarithm of the figure at each commit, all finite. The changes are in order.
std::vector<Change> FindChanges(std::span<const double> logs, const SearchLimits& limits);

/// The values limited to 3 robust standard deviations from the median of the five around each;
/// unchanged if there are fewer than kLeastForOutliers, whose deviation is too uncertain.
inline constexpr std::size_t kLeastForOutliers = 12;
std::vector<double> WithoutOutliers(std::span<const double> values);

/// The two sides of a split, by the t test.
struct SplitTest {
  double difference;  ///< of the mean after it to that before it
  double p;           ///< two-sided, by the larger one of Welch's error and the pooled one
  double error;       ///< Welch's standard error of the difference
  double freedom;     ///< Welch's degrees of freedom
};
SplitTest TestSplit(std::span<const double> before, std::span<const double> after);

/// The index at which E-divisive splits the values, with at least kLeastSegment on each side; 0 if
/// there are fewer than twice as many.
std::size_t EnergySplit(std::span<const double> values);

/// Least squares of a line over the indices 0, 1, ….
struct LineFit {
  double slope, error;  ///< standard error
  double level;         ///< at index 0
  double loss;          ///< the sum of squared residuals
};
/// `values`: three or more.
LineFit FitLine(std::span<const double> values);

}  // namespace cdb::history
