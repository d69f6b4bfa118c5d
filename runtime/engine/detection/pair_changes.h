// The difference between two successive lists of pairs; its cost depends on the number of changes.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "library/detectors/detector.h"

namespace cdb::detection {

/// Keeps the last list. Pairs may be listed in any order, either way round and more than once.
///
/// Where a detector lists most pairs in the place that they had before, only the others are looked
/// at; else both lists are sorted. Not for several threads.
class PairChanges {
 public:
  /// Compares `found` with the list of the call before (the first: with none) and keeps it.
  /// `is_kept`: a pair came before and has not gone. False where nothing has changed. Throws
  /// std::invalid_argument for a pair of a body with itself or of one that there is not; then
  /// nothing has changed either.
  bool Update(const Scene& scene, std::vector<Pair>& found,
              const std::function<bool(const Pair&)>& is_kept);

  /// Of the last Update: in order, a < b, each once, none that may not collide.
  std::span<const Pair> came() const { return came_; }
  std::span<const Pair> went() const { return went_; }

 private:
  bool CompareByPlace(const Scene& scene, const std::vector<Pair>& found,
                      const std::function<bool(const Pair&)>& is_kept);
  void CompareSorted(const Scene& scene, std::vector<Pair>& found);

  std::vector<Pair> listed_;  ///< the last list, each pair once
  std::vector<Pair> sorted_;  ///< the same in order, a < b; where it is known
  bool is_sorted_known_ = true;
  std::vector<Pair> came_, went_, new_places_, old_places_, sorting_;
  std::vector<std::uint32_t> begins_;  ///< of the pairs of a body, while they are sorted
};

}  // namespace cdb::detection
