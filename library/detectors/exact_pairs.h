// The pairs that a broad phase has to list, found without any cleverness: the referee.
#pragma once

#include <vector>

#include "library/detectors/detector.h"

namespace cdb::detectors {

/// All pairs of bodies that may collide and whose boxes overlap, in order. Boxes are compared as
/// they are, in double; sorted along one axis, every pair that overlaps there is tested. Boxes that
/// are not numbers overlap nothing. Threads: any.
std::vector<Pair> ExactPairs(const Scene& scene);

/// What is wrong with a list of pairs.
struct PairFaults {
  std::size_t exact = 0;      ///< pairs that there are
  std::size_t missed = 0;     ///< of them not in the list
  std::size_t phantom = 0;    ///< in the list without an overlap, each counted once
  std::size_t duplicate = 0;  ///< listed again
  bool operator==(const PairFaults&) const = default;
};

/// `found` in any order; pairs that may not collide are dropped from it first, as the engine does.
/// Every id must be a body of the scene, and a < b.
PairFaults ComparePairs(const Scene& scene, std::vector<Pair> found);

}  // namespace cdb::detectors
