// The difference between two successive lists of pairs; its cost depends on the number of changes.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "library/detectors/detector.h"

namespace cdb::detection {

/// Keeps the last list. Pairs may be listed in any order, with either body first, and repeatedly.
///
/// If most pairs are in the order of the last list, with some inserted, dropped or replaced, only
/// those are looked at; otherwise both lists are sorted by body. Not thread-safe.
class PairChanges {
 public:
  /// Compares `found` with the list of the previous call (initially empty) and keeps it. `is_kept`:
  /// whether a pair was added before and not removed; asked only for pairs that seem new. Returns
  /// false if nothing has changed. Throws std::invalid_argument for a pair of a body with itself or
  /// with an unknown body, without any change.
  bool Update(const Scene& scene, std::vector<Pair>& found,
              const std::function<bool(const Pair&)>& is_kept);

  /// The same for changes that a detector lists (Detector::FindChanges): as `came` may have pairs
  /// that are kept, and `went` others, so may those below. The list is unknown afterwards.
  bool Take(const Scene& scene, std::vector<Pair>& came, std::vector<Pair>& went,
            const std::function<bool(const Pair&)>& is_kept);
  /// Required before Update if not: the pairs that are kept.
  bool knows_list() const { return is_list_known_; }
  void SetList(std::vector<Pair> pairs);

  /// Changes of the last Update or Take: in order, a < b, each once, without pairs that may not
  /// collide.
  std::span<const Pair> came() const { return came_; }
  std::span<const Pair> went() const { return went_; }

 private:
  /// A list by first body.
  struct ByBody {
    std::vector<std::uint32_t> begins;  ///< of the pairs of each body; and the end
    std::vector<Id> seconds;            ///< in order for each body

    bool Sort(const Scene& scene, std::span<const Pair> pairs);
  };

  bool CompareInOrder(const Scene& scene, const std::vector<Pair>& found,
                      const std::function<bool(const Pair&)>& is_kept);
  bool CollectMoved(const std::vector<Pair>& found);
  void CompareByBody(const Scene& scene, std::vector<Pair>& found);
  void Sort(const Scene& scene, std::vector<Pair>& pairs);

  std::vector<Pair> listed_;  ///< the last list, each pair once
  ByBody sorted_, sorting_;   ///< the same, if known
  bool is_list_known_ = true, is_sorted_known_ = false;
  std::vector<Pair> came_, went_, moved_in_, moved_out_;
  std::vector<std::uint32_t> ends_;  ///< of the pairs of each body, of a call of Sort
};

}  // namespace cdb::detection
