// Scenes in which most bodies sleep: the candidates of `skin` whose bodies may have moved.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "library/detectors/detector.h"

namespace cdb::builtin {

/// Keeps which bodies may have moved since the candidates were tested, and, if they are few, an
/// index of the candidates of each body. Cost: a few bytes a body in each cycle; the index 12 bytes
/// a candidate. Errors: bad_alloc. Not thread-safe.
class SkinAwake {
 public:
  /// Nothing is known about the last cycle: every body may have moved.
  void Forget() {
    last_asleep_.clear();
    may_have_moved_.clear();
    ForgetIndex();
  }
  /// Candidates have been replaced or reordered.
  void ForgetIndex() {
    indexed_ = 0;
    few_cycles_ = 0;
  }
  /// Call once in every cycle.
  void See(const Scene& scene);
  /// Whether so few bodies may have moved that ForEach is worthwhile. Makes the index if this is so
  /// for several cycles.
  bool AreFew(const Scene& scene, std::span<const Pair> candidates);
  /// Calls test(i) for every candidate with a body that may have moved, for some twice, and for
  /// those appended since the index was made. After AreFew.
  template <typename Test>
  void ForEach(std::span<const Pair> candidates, const Test& test) const {
    for (const Id id : moved_)
      for (std::uint32_t at = begins_[id]; at < begins_[id + 1]; ++at) test(entries_[at]);
    for (std::size_t i = indexed_; i < candidates.size(); ++i) test(i);
  }
  /// All candidates have been tested, or those of ForEach.
  void Tested() { may_have_moved_.clear(); }

 private:
  void MakeIndex(const Scene& scene, std::span<const Pair> candidates);

  std::vector<std::uint8_t> last_asleep_;     ///< in the last cycle; empty if unknown
  std::vector<std::uint8_t> may_have_moved_;  ///< since the last test; empty right after it
  bool is_known_ = false;                     ///< may_have_moved_; else every body may have
  std::vector<Id> moved_;                     ///< of the last AreFew
  unsigned few_cycles_ = 0;                   ///< in a row, with these candidates
  std::size_t indexed_ = 0;                   ///< candidates in the index; 0 without one
  std::vector<std::uint32_t> begins_;         ///< of the entries of each body; and the end
  std::vector<std::uint32_t> entries_;        ///< candidates by body, each twice
};

}  // namespace cdb::builtin
