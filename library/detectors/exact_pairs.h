// Exact pairs, computed by brute force, and the comparison of a list of pairs with them.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "library/detectors/detector.h"

namespace cdb::detectors {

/// Pairs that are asked for, of those that may collide; all if it is empty.
using PairFilter = std::function<bool(const Pair&)>;

/// All pairs of bodies that may collide and whose boxes overlap, in order. Boxes are compared
/// unchanged, in double; they are sorted along one axis, and every pair that overlaps on it is
/// tested. Boxes with a NaN overlap nothing. Threads: any.
std::vector<Pair> ExactPairs(const Scene& scene, const PairFilter& asked = {});

/// The errors of a list of pairs.
struct PairFaults {
  std::size_t exact = 0;            ///< number of exact pairs
  std::size_t missed = 0;           ///< exact pairs that are not in the list
  std::size_t false_positives = 0;  ///< listed without an overlap, each counted once
  std::size_t duplicate = 0;        ///< listed more than once
  std::optional<Pair> first_missed = {};
  bool operator==(const PairFaults&) const = default;
};

/// `found` may be in any order; pairs that may not collide or are not asked for are dropped first,
/// as by the engine.
/// Every id must be a body of the scene, and a < b.
PairFaults ComparePairs(const Scene& scene, std::vector<Pair> found, const PairFilter& asked = {});
/// The same with pairs of ExactPairs.
PairFaults ComparePairs(const std::vector<Pair>& exact, std::vector<Pair> found);

/// For messages: `bodies 12 and 47, whose boxes (…) to (…) and (…) to (…) overlap by 1 x 2 x 0.3
/// m`.
std::string OverlapText(const Scene& scene, const Pair& pair);

}  // namespace cdb::detectors
