// The value that stands for a missing number, and means.
#pragma once

#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace cdb::statistics {

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

inline void Append(std::vector<double>& to, const std::vector<double>& values) {
  to.insert(to.end(), values.begin(), values.end());
}

}  // namespace cdb::statistics
