#include "runtime/engine/detection/pair_changes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace cdb::detection {
namespace {

/// Lists of which more than this part is not in the order of the last one are sorted.
constexpr std::size_t kMostMoved = 8;  // one in so many
constexpr std::size_t kFewMoved = 64;
/// Pairs that may be inserted or dropped in one place.
constexpr std::size_t kWindow = 8;

/// Smaller body first, and both there.
Pair InShape(const Scene& scene, const Pair& pair) {
  if (pair.a >= scene.size || pair.b >= scene.size)
    throw std::invalid_argument(
        fmt::format("it lists the pair ({}, {}), but the scene has {} bodies, counted from 0",
                    pair.a, pair.b, scene.size));
  if (pair.a == pair.b)
    throw std::invalid_argument(fmt::format("it lists body {} with itself", pair.a));
  return pair.a < pair.b ? pair : Pair{pair.b, pair.a};
}

void PutInShape(const Scene& scene, std::span<Pair> pairs) {
  for (Pair& pair : pairs) pair = InShape(scene, pair);
}

bool AreSame(const std::vector<Pair>& a, const std::vector<Pair>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Pair)) == 0);
}

/// How many pairs from `a` and `b` on are the same, of `count`.
std::size_t CommonPairs(const Pair* a, const Pair* b, std::size_t count) {
  constexpr std::size_t kBlock = 8;
  std::size_t same = 0;
  while (same + kBlock <= count && std::memcmp(a + same, b + same, kBlock * sizeof(Pair)) == 0)
    same += kBlock;
  while (same < count && a[same] == b[same]) ++same;
  return same;
}

/// How far the first `pair` is in the window of `list` from `at`; its size if it is not there.
std::size_t Ahead(const std::vector<Pair>& list, std::size_t at, const Pair& pair) {
  const std::size_t window = std::min(kWindow, list.size() - at);
  for (std::size_t k = 1; k < window; ++k)
    if (list[at + k] == pair) return k;
  return kWindow;
}

}  // namespace

/// False if a pair is listed twice; it is in the lists once.
bool PairChanges::ByBody::Sort(const Scene& scene, std::span<const Pair> pairs) {
  begins.assign(scene.size + 2, 0);
  for (const Pair& pair : pairs) ++begins[InShape(scene, pair).a + 2];
  for (std::size_t body = 2; body < begins.size(); ++body) begins[body] += begins[body - 1];
  seconds.resize(pairs.size());
  for (const Pair& pair : pairs)
    seconds[begins[std::min(pair.a, pair.b) + 1]++] = std::max(pair.a, pair.b);
  begins.pop_back();
  const auto first = seconds.begin();
  Id* end = seconds.data();
  for (std::size_t body = 0; body < scene.size; ++body) {
    const auto begin = first + begins[body], stop = first + begins[body + 1];
    if (stop - begin > 1) std::sort(begin, stop);
    begins[body] = static_cast<std::uint32_t>(end - seconds.data());
    for (auto at = begin; at != stop; ++at)
      if (at == begin || *at != *(at - 1)) *end++ = *at;
  }
  const auto count = static_cast<std::size_t>(end - seconds.data());
  begins[scene.size] = static_cast<std::uint32_t>(count);
  seconds.resize(count);
  return count == pairs.size();
}

bool PairChanges::Update(const Scene& scene, std::vector<Pair>& found,
                         const std::function<bool(const Pair&)>& is_kept) {
  came_.clear();
  went_.clear();
  if (AreSame(found, listed_)) return false;
  if (CompareInOrder(scene, found, is_kept)) {
    listed_.swap(found);
    is_sorted_known_ = false;
  } else {
    CompareByBody(scene, found);
  }
  const auto may_not = [&](const Pair& pair) { return !scene.MayCollide(pair.a, pair.b); };
  std::erase_if(came_, may_not);
  std::erase_if(went_, may_not);
  return !came_.empty() || !went_.empty();
}

bool PairChanges::Take(const Scene& scene, std::vector<Pair>& came, std::vector<Pair>& went,
                       const std::function<bool(const Pair&)>& is_kept) {
  PutInShape(scene, came);
  PutInShape(scene, went);
  is_list_known_ = false;
  std::erase_if(came, [&](const Pair& pair) { return !scene.MayCollide(pair.a, pair.b); });
  // As many come as go, unless a detector lists most that are kept: they need not be sorted.
  if (came.size() > 2 * went.size() + kFewMoved) std::erase_if(came, is_kept);
  for (std::vector<Pair>* pairs : {&came, &went}) {
    Sort(scene, *pairs);
    const auto repeated = std::ranges::unique(*pairs);
    pairs->erase(repeated.begin(), repeated.end());
  }
  came_.swap(came);
  went_.swap(went);
  return !came_.empty() || !went_.empty();
}

/// In order: many are counted by their first body, as there are few of each.
void PairChanges::Sort(const Scene& scene, std::vector<Pair>& pairs) {
  constexpr std::size_t kMany = 16;  // bodies for each pair
  if (pairs.size() * kMany < scene.size) {
    std::ranges::sort(pairs);
    return;
  }
  ends_.assign(scene.size + 1, 0);
  for (const Pair& pair : pairs) ++ends_[pair.a + 1];
  for (std::size_t body = 1; body <= scene.size; ++body) ends_[body] += ends_[body - 1];
  moved_in_.resize(pairs.size());
  for (const Pair& pair : pairs) moved_in_[ends_[pair.a]++] = pair;
  pairs.swap(moved_in_);
  const auto first = pairs.begin();
  for (std::size_t body = 0, begin = 0; body < scene.size; begin = ends_[body++])
    if (ends_[body] > begin + 1)
      std::sort(first + static_cast<std::ptrdiff_t>(begin), first + ends_[body]);
}

void PairChanges::SetList(std::vector<Pair> pairs) {
  listed_ = std::move(pairs);
  is_list_known_ = true;
  is_sorted_known_ = false;
}

/// Puts what is not common to both lists, in the same order, into moved_in_ and moved_out_. False
/// if that is too much.
bool PairChanges::CollectMoved(const std::vector<Pair>& found) {
  const std::size_t most = 2 * (found.size() / kMostMoved + kFewMoved);
  moved_in_.clear();
  moved_out_.clear();
  std::size_t in = 0, out = 0;
  while (in < found.size() && out < listed_.size()) {
    const std::size_t same = CommonPairs(found.data() + in, listed_.data() + out,
                                         std::min(found.size() - in, listed_.size() - out));
    in += same;
    out += same;
    if (in == found.size() || out == listed_.size()) break;
    if (moved_in_.size() + moved_out_.size() > most) return false;
    const std::size_t inserted = Ahead(found, in, listed_[out]);
    const std::size_t dropped = Ahead(listed_, out, found[in]);
    if (inserted == kWindow && dropped == kWindow) {
      moved_in_.push_back(found[in++]);
      moved_out_.push_back(listed_[out++]);
    } else if (inserted <= dropped) {
      for (std::size_t k = 0; k < inserted; ++k) moved_in_.push_back(found[in++]);
    } else {
      for (std::size_t k = 0; k < dropped; ++k) moved_out_.push_back(listed_[out++]);
    }
  }
  if (found.size() - in + listed_.size() - out > most) return false;
  moved_in_.insert(moved_in_.end(), found.begin() + static_cast<std::ptrdiff_t>(in), found.end());
  moved_out_.insert(moved_out_.end(), listed_.begin() + static_cast<std::ptrdiff_t>(out),
                    listed_.end());
  return true;
}

// False where it gives up: too many have moved, or a pair is listed twice, which only sorting all
// of them can settle.
bool PairChanges::CompareInOrder(const Scene& scene, const std::vector<Pair>& found,
                                 const std::function<bool(const Pair&)>& is_kept) {
  if (!CollectMoved(found)) return false;
  PutInShape(scene, moved_in_);
  PutInShape(scene, moved_out_);
  std::ranges::sort(moved_in_);
  std::ranges::sort(moved_out_);
  if (std::ranges::adjacent_find(moved_in_) != moved_in_.end()) return false;
  std::ranges::set_difference(moved_in_, moved_out_, std::back_inserter(came_));
  if (std::ranges::any_of(came_, is_kept)) {
    came_.clear();
    return false;
  }
  std::ranges::set_difference(moved_out_, moved_in_, std::back_inserter(went_));
  return true;
}

void PairChanges::CompareByBody(const Scene& scene, std::vector<Pair>& found) {
  const bool are_distinct = sorting_.Sort(scene, found);
  if (!is_sorted_known_) sorted_.Sort(scene, listed_);
  for (Id body = 0; body < scene.size; ++body) {
    const Id* in = sorting_.seconds.data() + sorting_.begins[body];
    const Id* in_end = sorting_.seconds.data() + sorting_.begins[body + 1];
    const Id* out = sorted_.seconds.data() + sorted_.begins[body];
    const Id* out_end = sorted_.seconds.data() + sorted_.begins[body + 1];
    while (in != in_end || out != out_end) {
      if (in != in_end && out != out_end && *in == *out) {
        ++in;
        ++out;
      } else if (out == out_end || (in != in_end && *in < *out)) {
        came_.push_back({body, *in++});
      } else {
        went_.push_back({body, *out++});
      }
    }
  }
  std::swap(sorted_, sorting_);
  is_sorted_known_ = true;
  listed_.swap(found);
  if (are_distinct) return;
  listed_.clear();
  for (Id body = 0; body < scene.size; ++body)
    for (std::uint32_t at = sorted_.begins[body]; at < sorted_.begins[body + 1]; ++at)
      listed_.push_back({body, sorted_.seconds[at]});
}

}  // namespace cdb::detection
