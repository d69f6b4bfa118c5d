// Where the states of points change along an axis of numbers, in sentences: verdicts, and whether a
// configuration stays within a budget.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "runtime/figures/points.h"
#include "runtime/results/store.h"

namespace cdb::figures {

struct BoundaryWords {
  std::string good;  ///< the state whose limits are given if there are many different lines
  /// A state that holds for all values of the axis, if it is not `state everywhere`.
  std::map<std::string, std::string> everywhere = {};
  std::size_t most_lines = 2;  ///< limit of different lines that are given in full
};

/// ` Along quantity, detector dbvt: stable up to 90, tunnelled from 120.`: one sentence for the
/// axis along which the states change most. `states`: by points on all axes. Empty if they change
/// along no axis of numbers. Throws StoreError.
std::string BoundaryText(const results::ResultFile& file,
                         const std::map<Point, std::string>& states, const BoundaryWords& words);

}  // namespace cdb::figures
