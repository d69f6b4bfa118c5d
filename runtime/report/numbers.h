// What the figures of a report have in common.
#pragma once

#include <limits>
#include <vector>

namespace cdb::report {

/// Stands for a number that there is not.
inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

inline void Append(std::vector<double>& to, const std::vector<double>& values) {
  to.insert(to.end(), values.begin(), values.end());
}

}  // namespace cdb::report
