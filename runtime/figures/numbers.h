// Numbers of figures: the value that stands for a missing one, means, percentiles.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
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

}  // namespace cdb::figures
