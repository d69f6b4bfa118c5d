// The cost model of `skin`: constants that estimate the work of a cycle.
#pragma once

#include <cstddef>

namespace cdb::builtin {

// In nanoseconds, measured once on one machine; only their ratios matter.
inline constexpr double kGridCost = 38;                   ///< of a body in a cycle of `grid`
inline constexpr double kListCost = 80, kListedCost = 1;  ///< of making a list: a body, a candidate
inline constexpr double kOccupancyCost = 0.1;  ///< of each other body in the cell, or oversized
inline constexpr double kReadCost = 1.4;  ///< of reading a box in a cycle that does nothing else
inline constexpr double kCheckCost = 3, kTestCost = 2.2, kRegrowCost = 250, kUntrackedCost = 100;

/// Cost of a cycle for `escaped` bodies, of which `untracked` are looked up in every cycle.
inline double CostOfEscaped(std::size_t escaped, std::size_t untracked) {
  return kRegrowCost * static_cast<double>(escaped - untracked) +
         kUntrackedCost * static_cast<double>(untracked);
}

}  // namespace cdb::builtin
