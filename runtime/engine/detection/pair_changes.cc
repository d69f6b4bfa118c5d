#include "runtime/engine/detection/pair_changes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace cdb::detection {
namespace {

/// Lists of which more than this part has moved are sorted.
constexpr std::size_t kMostMoved = 8;  // one in so many
constexpr std::size_t kFewMoved = 64;

/// Smaller body first, and all of them there.
void PutInShape(const Scene& scene, std::span<Pair> pairs) {
  for (Pair& pair : pairs) {
    if (pair.a >= scene.size || pair.b >= scene.size)
      throw std::invalid_argument(
          fmt::format("it lists the pair ({}, {}), and the scene's {} bodies are counted from 0",
                      pair.a, pair.b, scene.size));
    if (pair.a == pair.b)
      throw std::invalid_argument(fmt::format("it lists body {} with itself", pair.a));
    if (pair.a > pair.b) std::swap(pair.a, pair.b);
  }
}

/// By the first body with a count, as there are few pairs of each, and then by the second.
void Sort(std::size_t bodies, std::vector<Pair>& pairs, std::vector<Pair>& sorting,
          std::vector<std::uint32_t>& begins) {
  if (std::ranges::is_sorted(pairs)) return;
  if (pairs.size() < bodies / 8) {
    std::ranges::sort(pairs);
    return;
  }
  begins.assign(bodies + 1, 0);
  for (const Pair& pair : pairs) ++begins[pair.a + 1];
  for (std::size_t body = 0; body < bodies; ++body) begins[body + 1] += begins[body];
  sorting.resize(pairs.size());
  for (const Pair& pair : pairs) sorting[begins[pair.a]++] = pair;
  pairs.swap(sorting);
  // Each beginning has moved to its end.
  std::uint32_t begin = 0;
  for (std::size_t body = 0; body < bodies; ++body) {
    std::sort(pairs.begin() + begin, pairs.begin() + begins[body],
              [](const Pair& x, const Pair& y) { return x.b < y.b; });
    begin = begins[body];
  }
}

bool AreSame(const std::vector<Pair>& a, const std::vector<Pair>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Pair)) == 0);
}

}  // namespace

bool PairChanges::Update(const Scene& scene, std::vector<Pair>& found,
                         const std::function<bool(const Pair&)>& is_kept) {
  came_.clear();
  went_.clear();
  if (AreSame(found, listed_)) return false;
  if (CompareByPlace(scene, found, is_kept)) {
    listed_.swap(found);
    is_sorted_known_ = false;
  } else {
    CompareSorted(scene, found);
  }
  const auto may_not = [&](const Pair& pair) { return !scene.MayCollide(pair.a, pair.b); };
  std::erase_if(came_, may_not);
  std::erase_if(went_, may_not);
  return !came_.empty() || !went_.empty();
}

// False where it gives up: too many have another place, or a pair is listed twice, which only
// sorting all of them can settle.
bool PairChanges::CompareByPlace(const Scene& scene, const std::vector<Pair>& found,
                                 const std::function<bool(const Pair&)>& is_kept) {
  const std::size_t most = found.size() / kMostMoved + kFewMoved;
  const std::size_t common = std::min(found.size(), listed_.size());
  const std::size_t longer = std::max(found.size(), listed_.size()) - common;
  if (longer > most) return false;
  new_places_.assign(found.begin() + static_cast<std::ptrdiff_t>(common), found.end());
  old_places_.assign(listed_.begin() + static_cast<std::ptrdiff_t>(common), listed_.end());
  for (std::size_t i = 0; i < common; ++i) {
    if (found[i] == listed_[i]) continue;
    if (new_places_.size() + old_places_.size() > 2 * most) return false;
    new_places_.push_back(found[i]);
    old_places_.push_back(listed_[i]);
  }
  PutInShape(scene, new_places_);
  PutInShape(scene, old_places_);
  std::ranges::sort(new_places_);
  std::ranges::sort(old_places_);
  if (std::ranges::adjacent_find(new_places_) != new_places_.end()) return false;
  std::ranges::set_difference(new_places_, old_places_, std::back_inserter(came_));
  if (std::ranges::any_of(came_, is_kept)) {
    came_.clear();
    return false;
  }
  std::ranges::set_difference(old_places_, new_places_, std::back_inserter(went_));
  return true;
}

void PairChanges::CompareSorted(const Scene& scene, std::vector<Pair>& found) {
  std::vector<Pair>& sorted = new_places_;
  sorted = found;
  PutInShape(scene, sorted);
  Sort(scene.size, sorted, sorting_, begins_);
  const bool has_duplicates = std::ranges::adjacent_find(sorted) != sorted.end();
  if (has_duplicates) sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  if (!is_sorted_known_) {
    sorted_ = listed_;
    PutInShape(scene, sorted_);
    Sort(scene.size, sorted_, sorting_, begins_);
  }
  std::ranges::set_difference(sorted, sorted_, std::back_inserter(came_));
  std::ranges::set_difference(sorted_, sorted, std::back_inserter(went_));
  sorted_.swap(sorted);
  is_sorted_known_ = true;
  if (has_duplicates) {
    listed_ = sorted_;
  } else {
    listed_.swap(found);
  }
}

}  // namespace cdb::detection
