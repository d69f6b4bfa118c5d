#include "runtime/engine/detection/ordered_pair_cache.h"

#include <algorithm>

#include "dsl/text/check.h"

namespace cdb::detection {
namespace {

/// The longest row that is searched linearly.
constexpr std::uint32_t kShortRow = 16;

/// The end of the pairs from `begin` on that have its first body.
std::size_t RowEnd(std::span<const Pair> pairs, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < pairs.size() && pairs[end].a == pairs[begin].a) ++end;
  return end;
}

}  // namespace

std::uint32_t OrderedPairCache::Find(const Pair& pair) const {
  const Row& row = rows_[pair.a];
  const Entry* begin = entries_.data() + row.begin;
  const Entry* end = begin + row.size;
  const Entry* at = begin;
  if (row.size > kShortRow)
    at = std::lower_bound(begin, end, pair.b,
                          [](const Entry& entry, Id second) { return entry.second < second; });
  while (at != end && at->second < pair.b) ++at;
  return at != end && at->second == pair.b ? static_cast<std::uint32_t>(at - entries_.data())
                                           : kNone;
}

/// Moves the row to a larger place. The old one is left unused until TidyRows.
void OrderedPairCache::MakeRoom(Row& row, std::size_t count) {
  const std::size_t needed = row.size + count;
  if (needed <= row.capacity) return;
  left_behind_ += row.capacity;
  const std::size_t capacity = std::max<std::size_t>(needed + needed / 2, 4);
  const auto begin = static_cast<std::uint32_t>(entries_.size());
  entries_.resize(begin + capacity);
  std::copy_n(entries_.begin() + row.begin, row.size, entries_.begin() + begin);
  row = {begin, row.size, static_cast<std::uint32_t>(capacity)};
}

void OrderedPairCache::TidyRows() {
  if (left_behind_ <= entries_.size() / 2) return;
  std::vector<Entry> tidy;
  tidy.reserve(entries_.size());
  for (Row& row : rows_) {
    const auto begin = static_cast<std::uint32_t>(tidy.size());
    const auto first = entries_.begin() + row.begin;
    tidy.insert(tidy.end(), first, first + row.size);
    row.capacity = row.size + row.size / 2;
    row.begin = begin;
    tidy.resize(begin + row.capacity);
  }
  entries_.swap(tidy);
  left_behind_ = 0;
}

/// Adds pairs that have the same first body.
void OrderedPairCache::AddToRow(std::span<const Pair> pairs) {
  Row& row = rows_[pairs.front().a];
  fresh_.clear();
  const Entry* at = entries_.data() + row.begin;
  const Entry* end = at + row.size;
  for (const Pair& pair : pairs) {
    while (at != end && at->second < pair.b) ++at;
    if (at == end || at->second != pair.b) fresh_.push_back(pair.b);
  }
  if (fresh_.empty()) return;
  MakeRoom(row, fresh_.size());
  auto place = static_cast<std::uint32_t>(pairs_.size());
  for (const Id second : fresh_) {
    btBroadphasePair& pair = pairs_.expandNonInitializing();
    new (&pair) btBroadphasePair(first_[pairs.front().a], first_[second]);
    pair.m_internalTmpValue = 0;
  }
  place += static_cast<std::uint32_t>(fresh_.size());
  // Merged from the end, where there is room.
  Entry* first = entries_.data() + row.begin;
  Entry* last = first + row.size;
  Entry* to = last + fresh_.size();
  for (auto second = fresh_.rbegin(); second != fresh_.rend(); ++second) {
    while (last != first && (last - 1)->second > *second) *--to = *--last;
    *--to = {*second, --place};
  }
  row.size += static_cast<std::uint32_t>(fresh_.size());
}

void OrderedPairCache::Add(std::span<const Pair> pairs) {
  for (std::size_t begin = 0; begin < pairs.size();) {
    const std::size_t end = RowEnd(pairs, begin);
    AddToRow(pairs.subspan(begin, end - begin));
    begin = end;
  }
  TidyRows();
}

// A pair that leaves, its algorithm and its manifolds are scattered in memory. They are fetched in
// this order, ahead of their removal.
void OrderedPairCache::FetchAhead(std::size_t at, btDispatcher* dispatcher) {
  constexpr std::size_t kStep = 5;
  const auto pair = [&](std::size_t i) -> const btBroadphasePair* {
    if (i >= leaving_.size() || leaving_[i] == kNone) return nullptr;
    return &pairs_[static_cast<int>(entries_[leaving_[i]].place)];
  };
  if (const btBroadphasePair* later = pair(at + 3 * kStep)) Prefetch(later);
  if (const btBroadphasePair* next = pair(at + 2 * kStep)) Prefetch(next->m_algorithm);
  const btBroadphasePair* soon = pair(at + kStep);
  if (soon == nullptr || soon->m_algorithm == nullptr || dispatcher == nullptr) return;
  manifolds_.resizeNoInitialize(0);
  soon->m_algorithm->getAllContactManifolds(manifolds_);
  for (int i = 0; i < manifolds_.size(); ++i) {
    Prefetch(manifolds_[i]);
    Prefetch(&manifolds_[i]->m_index1a);
  }
  // Bullet gives the last manifold the index of the freed one.
  const int last = dispatcher->getNumManifolds() - static_cast<int>(kStep);
  if (last >= 0) Prefetch(&dispatcher->getManifoldByIndexInternal(last)->m_index1a);
}

void OrderedPairCache::Remove(std::span<const Pair> pairs, btDispatcher* dispatcher) {
  leaving_.clear();
  for (const Pair& pair : pairs) leaving_.push_back(Find(pair));
  for (std::size_t begin = 0; begin < pairs.size();) {
    const std::size_t end = RowEnd(pairs, begin);
    for (std::size_t i = begin; i < end; ++i) {
      FetchAhead(i, dispatcher);
      if (leaving_[i] == kNone) continue;
      RemoveAt(entries_[leaving_[i]].place, dispatcher);
      entries_[leaving_[i]].place = kNone;
    }
    Row& row = rows_[pairs[begin].a];
    const auto first = entries_.begin() + row.begin;
    const auto rest = std::remove_if(first, first + row.size,
                                     [](const Entry& entry) { return entry.place == kNone; });
    row.size = static_cast<std::uint32_t>(rest - first);
    begin = end;
  }
}

std::vector<Pair> OrderedPairCache::List() const {
  std::vector<Pair> list;
  list.reserve(static_cast<std::size_t>(pairs_.size()));
  for (Id body = 0; body < rows_.size(); ++body)
    for (std::uint32_t i = 0; i < rows_[body].size; ++i)
      list.push_back({body, entries_[rows_[body].begin + i].second});
  return list;
}

/// The caller removes the entry of the pair.
void OrderedPairCache::RemoveAt(std::uint32_t place, btDispatcher* dispatcher) {
  const int last = pairs_.size() - 1;
  cleanOverlappingPair(pairs_[static_cast<int>(place)], dispatcher);
  if (static_cast<int>(place) != last) {
    const btBroadphasePair& moved = pairs_[last];
    entries_[Find(PairOf(moved.m_pProxy0, moved.m_pProxy1))].place = place;
    pairs_[static_cast<int>(place)] = moved;
  }
  pairs_.pop_back();
}

btBroadphasePair* OrderedPairCache::addOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b) {
  if (!needsBroadphaseCollision(a, b)) return nullptr;
  const Pair pair = PairOf(a, b);
  Add({&pair, 1});
  return findPair(a, b);
}

void* OrderedPairCache::removeOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b,
                                              btDispatcher* dispatcher) {
  const Pair pair = PairOf(a, b);
  Remove({&pair, 1}, dispatcher);
  return nullptr;  // nobody stores anything with a pair
}

void OrderedPairCache::removeOverlappingPairsContainingProxy(btBroadphaseProxy* proxy,
                                                             btDispatcher* dispatcher) {
  for (int i = 0; i < pairs_.size();) {
    const btBroadphasePair& pair = pairs_[i];
    if (pair.m_pProxy0 == proxy || pair.m_pProxy1 == proxy) {
      removeOverlappingPair(pair.m_pProxy0, pair.m_pProxy1, dispatcher);
    } else {
      ++i;
    }
  }
}

void OrderedPairCache::cleanOverlappingPair(btBroadphasePair& pair, btDispatcher* dispatcher) {
  if (pair.m_algorithm == nullptr || dispatcher == nullptr) return;
  pair.m_algorithm->~btCollisionAlgorithm();
  dispatcher->freeCollisionAlgorithm(pair.m_algorithm);
  pair.m_algorithm = nullptr;
}

void OrderedPairCache::cleanProxyFromPairs(btBroadphaseProxy* proxy, btDispatcher* dispatcher) {
  for (int i = 0; i < pairs_.size(); ++i)
    if (pairs_[i].m_pProxy0 == proxy || pairs_[i].m_pProxy1 == proxy)
      cleanOverlappingPair(pairs_[i], dispatcher);
}

btBroadphasePair* OrderedPairCache::findPair(btBroadphaseProxy* a, btBroadphaseProxy* b) {
  const std::uint32_t entry = Find(PairOf(a, b));
  return entry == kNone ? nullptr : &pairs_[static_cast<int>(entries_[entry].place)];
}

bool OrderedPairCache::needsBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const {
  if (filter_ != nullptr) return filter_->needBroadphaseCollision(a, b);
  return (a->m_collisionFilterGroup & b->m_collisionFilterMask) != 0 &&
         (b->m_collisionFilterGroup & a->m_collisionFilterMask) != 0;
}

void OrderedPairCache::processAllOverlappingPairs(btOverlapCallback* callback,
                                                  btDispatcher* dispatcher) {
  for (int i = 0; i < pairs_.size();) {
    btBroadphasePair& pair = pairs_[i];
    if (callback->processOverlap(pair)) {
      removeOverlappingPair(pair.m_pProxy0, pair.m_pProxy1, dispatcher);
    } else {
      ++i;
    }
  }
}

void OrderedPairCache::processAllOverlappingPairs(btOverlapCallback* callback,
                                                  btDispatcher* dispatcher,
                                                  const btDispatcherInfo& info) {
  if (!info.m_deterministicOverlappingPairs)
    return processAllOverlappingPairs(callback, dispatcher);
  ForEach(true, [callback](const Pair&, btBroadphasePair& pair) {
    const bool is_removed = callback->processOverlap(pair);
    CDB_CHECK(!is_removed);  // no callback in this order removes pairs
  });
}

}  // namespace cdb::detection
