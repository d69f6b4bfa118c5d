// The median of measured values, which a few slow cycles do not move.
#pragma once

#include <algorithm>
#include <vector>

namespace cdb::bench {

/// Of an even number, the upper of the two in the middle. `values` may not be empty.
inline double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace cdb::bench
