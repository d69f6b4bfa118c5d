#include "library/detectors/builtin/skin_awake.h"

#include <algorithm>

namespace cdb::builtin {
namespace {

/// Cycles with few moved bodies before the index is made.
constexpr unsigned kPatience = 4;
/// One in so many candidates may have been appended to those in the index.
constexpr std::size_t kAppended = 8;

}  // namespace

void SkinAwake::See(const Scene& scene) {
  if (last_asleep_.size() == scene.size && scene.is_asleep.size() == scene.size) {
    // Writes of bytes may change the members, but not local pointers: so the loop is vectorized.
    const std::uint8_t *asleep = scene.is_asleep.data(), *was_asleep = last_asleep_.data();
    std::uint8_t* moved = may_have_moved_.data();
    for (std::size_t i = 0, size = scene.size; i < size; ++i)
      moved[i] |=
          static_cast<std::uint8_t>(asleep[i] == 0) | static_cast<std::uint8_t>(was_asleep[i] == 0);
  } else {
    may_have_moved_.assign(scene.size, 1);
  }
  moved_count_ = static_cast<std::size_t>(std::ranges::count(may_have_moved_, std::uint8_t{1}));
  last_asleep_.assign(scene.is_asleep.begin(), scene.is_asleep.end());
}

bool SkinAwake::UpdateIndex(const Scene& scene, std::span<const Pair> candidates) {
  if (!HaveFewMoved()) {
    few_cycles_ = 0;
    return false;
  }
  if (++few_cycles_ < kPatience) return false;
  if (indexed_ == 0 || kAppended * (candidates.size() - indexed_) > candidates.size())
    MakeIndex(scene, candidates);
  return true;
}

void SkinAwake::MakeIndex(const Scene& scene, std::span<const Pair> candidates) {
  begins_.assign(scene.size + 2, 0);
  for (const auto& [a, b] : candidates) {
    ++begins_[a + 2];
    ++begins_[b + 2];
  }
  for (std::size_t body = 2; body < begins_.size(); ++body) begins_[body] += begins_[body - 1];
  entries_.resize(2 * candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i)
    for (const Id id : {candidates[i].a, candidates[i].b})
      entries_[begins_[id + 1]++] = static_cast<std::uint32_t>(i);
  begins_.pop_back();
  indexed_ = candidates.size();
}

}  // namespace cdb::builtin
