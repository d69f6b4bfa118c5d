// The difference between two successive lists of pairs; its cost depends on the number of changes.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "library/detectors/detector.h"

namespace cdb::detection {

/// Keeps the last list. Pairs may be listed in any order, with either body first, and repeatedly.
///
/// If most pairs are at the same index as in the last list, only the others are compared; otherwise
/// both lists are sorted. Not thread-safe.
class PairChanges {
 public:
  /// Compares `found` with the list of the previous call (initially empty) and keeps it. `is_kept`:
  /// whether a pair was added before and not removed. Returns false if nothing has changed. Throws
  /// std::invalid_argument for a pair of a body with itself or with an unknown body, without any
  /// change.
  bool Update(const Scene& scene, std::vector<Pair>& found,
              const std::function<bool(const Pair&)>& is_kept);

  /// Changes of the last Update: in order, a < b, each once, without pairs that may not collide.
  std::span<const Pair> came() const { return came_; }
  std::span<const Pair> went() const { return went_; }

 private:
  bool CompareByPlace(const Scene& scene, const std::vector<Pair>& found,
                      const std::function<bool(const Pair&)>& is_kept);
  void CompareSorted(const Scene& scene, std::vector<Pair>& found);

  std::vector<Pair> listed_;  ///< the last list, each pair once
  std::vector<Pair> sorted_;  ///< the same in order, a < b, if known
  bool is_sorted_known_ = true;
  std::vector<Pair> came_, went_, new_places_, old_places_, sorting_;
  std::vector<std::uint32_t> begins_;  ///< of the pairs of a body, while they are sorted
};

}  // namespace cdb::detection
