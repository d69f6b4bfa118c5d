// Scenes in which most bodies sleep: the candidates of `skin` whose bodies may have moved.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
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
    ForgetIndex();
  }
  /// Candidates have been replaced or reordered.
  void ForgetIndex() {
    indexed_ = 0;
    few_cycles_ = 0;
  }
  /// Notes which bodies may have moved since the last cycle; call once in every cycle.
  void See(const Scene& scene);
  /// True if few bodies may have moved since the candidates were tested.
  bool HaveFewMoved() const { return kFew * moved_count_ <= may_have_moved_.size(); }
  /// Calls visit(id) for each body that may have moved since the candidates were tested.
  template <typename Visit>
  void ForEachMoved(const Visit& visit) const {
    for (std::size_t id = NextMoved(0); id < may_have_moved_.size(); id = NextMoved(id + 1))
      visit(static_cast<Id>(id));
  }
  /// Makes the index if few bodies may have moved for several cycles. True if there is one: call
  /// ForEach.
  bool UpdateIndex(const Scene& scene, std::span<const Pair> candidates);
  /// Calls test(i) for every candidate with a body that may have moved, for some twice, and for
  /// those appended since the index was made. After UpdateIndex.
  template <typename Test>
  void ForEach(std::span<const Pair> candidates, const Test& test) const {
    ForEachMoved([&](Id id) {
      for (std::uint32_t at = begins_[id]; at < begins_[id + 1]; ++at) test(entries_[at]);
    });
    for (std::size_t i = indexed_; i < candidates.size(); ++i) test(i);
  }
  /// All candidates have been tested, or those of ForEach.
  void Tested() {
    std::ranges::fill(may_have_moved_, std::uint8_t{0});
    moved_count_ = 0;
  }

 private:
  /// One in so many bodies may have moved.
  static constexpr std::size_t kFew = 8;

  /// The first body from `id` on that may have moved; the number of bodies if none has.
  std::size_t NextMoved(std::size_t id) const {
    const std::size_t size = may_have_moved_.size();
    const void* at = std::memchr(may_have_moved_.data() + id, 1, size - id);
    return at == nullptr ? size
                         : static_cast<std::size_t>(static_cast<const std::uint8_t*>(at) -
                                                    may_have_moved_.data());
  }
  void MakeIndex(const Scene& scene, std::span<const Pair> candidates);

  std::vector<std::uint8_t> last_asleep_;     ///< in the last cycle; empty if unknown
  std::vector<std::uint8_t> may_have_moved_;  ///< since the candidates were tested
  std::size_t moved_count_ = 0;               ///< bodies in may_have_moved_
  unsigned few_cycles_ = 0;                   ///< in a row, with these candidates
  std::size_t indexed_ = 0;                   ///< candidates in the index; 0 without one
  std::vector<std::uint32_t> begins_;         ///< of the entries of each body; and the end
  std::vector<std::uint32_t> entries_;        ///< candidates by body, each twice
};

}  // namespace cdb::builtin
