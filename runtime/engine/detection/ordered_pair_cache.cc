#include "runtime/engine/detection/ordered_pair_cache.h"

#include <algorithm>
#include <utility>

#include "dsl/check.h"

namespace cdb::detection {

std::size_t OrderedPairCache::Find(Key key) const {
  const std::size_t last = slots_.size() - 1;
  std::size_t slot = HomeOf(key);
  while (slots_[slot].key != key && slots_[slot].key != 0) slot = (slot + 1) & last;
  return slot;
}

// Those that follow without a gap move up, unless they are at home.
void OrderedPairCache::Free(std::size_t slot) {
  const std::size_t last = slots_.size() - 1;
  for (std::size_t next = (slot + 1) & last; slots_[next].key != 0; next = (next + 1) & last) {
    const std::size_t home = HomeOf(slots_[next].key);
    if (((next - home) & last) < ((next - slot) & last)) continue;
    slots_[slot] = slots_[next];
    slot = next;
  }
  slots_[slot].key = 0;
}

void OrderedPairCache::Grow() {
  std::vector<Slot> old(2 * slots_.size());
  old.swap(slots_);
  --shift_;
  for (const Slot& slot : old)
    if (slot.key != 0) slots_[Find(slot.key)] = slot;
}

void OrderedPairCache::Append(Key key) {
  is_sorted_ = false;
  if (2 * (static_cast<std::size_t>(pairs_.size()) + 1) > slots_.size()) Grow();
  slots_[Find(key)] = {key, static_cast<std::uint32_t>(pairs_.size())};
  btBroadphasePair& pair = pairs_.expandNonInitializing();
  new (&pair) btBroadphasePair(first_[key >> 32], first_[key & 0xFFFFFFFF]);
  pair.m_internalTmpValue = 0;
}

void OrderedPairCache::Add(std::span<const Pair> pairs) {
  for (const Pair& pair : pairs) Append(KeyOf(pair.a, pair.b));
}

// A pair that leaves is anywhere in memory, and so is what Bullet keeps of it: its slot is fetched
// first, then the pair, then its algorithm.
void OrderedPairCache::FetchAhead(std::span<const Pair> pairs, std::size_t at) const {
#if defined(__GNUC__)
  constexpr std::size_t kStep = 6;
  const auto key = [&](std::size_t i) { return KeyOf(pairs[i].a, pairs[i].b); };
  if (at + 3 * kStep < pairs.size()) __builtin_prefetch(&slots_[HomeOf(key(at + 3 * kStep))]);
  const auto place = [&](std::size_t i) {
    const Slot& slot = slots_[Find(key(i))];
    return slot.key == 0 ? nullptr : &pairs_[static_cast<int>(slot.place)];
  };
  if (at + 2 * kStep < pairs.size())
    if (const btBroadphasePair* pair = place(at + 2 * kStep)) __builtin_prefetch(pair);
  if (at + kStep < pairs.size())
    if (const btBroadphasePair* pair = place(at + kStep)) __builtin_prefetch(pair->m_algorithm);
#endif
}

void OrderedPairCache::Remove(std::span<const Pair> pairs, btDispatcher* dispatcher) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    FetchAhead(pairs, i);
    const std::size_t slot = Find(KeyOf(pairs[i].a, pairs[i].b));
    if (slots_[slot].key != 0) RemoveAt(slot, dispatcher);
  }
}

std::vector<Pair> OrderedPairCache::List() const {
  std::vector<Pair> list;
  list.reserve(static_cast<std::size_t>(pairs_.size()));
  for (int i = 0; i < pairs_.size(); ++i)
    list.push_back({IdOf(pairs_[i].m_pProxy0), IdOf(pairs_[i].m_pProxy1)});
  return list;
}

void OrderedPairCache::RemoveAt(std::size_t slot, btDispatcher* dispatcher) {
  is_sorted_ = false;
  const std::uint32_t place = slots_[slot].place;
  const int last = pairs_.size() - 1;
  cleanOverlappingPair(pairs_[static_cast<int>(place)], dispatcher);
  Free(slot);
  if (static_cast<int>(place) != last) {
    const btBroadphasePair& moved = pairs_[last];
    slots_[Find(KeyOf(moved.m_pProxy0, moved.m_pProxy1))].place = place;
    pairs_[static_cast<int>(place)] = moved;
  }
  pairs_.pop_back();
}

btBroadphasePair* OrderedPairCache::addOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b) {
  if (!needsBroadphaseCollision(a, b)) return nullptr;
  if (btBroadphasePair* pair = findPair(a, b)) return pair;
  Append(KeyOf(a, b));
  return &pairs_[pairs_.size() - 1];
}

void* OrderedPairCache::removeOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b,
                                              btDispatcher* dispatcher) {
  const std::size_t slot = Find(KeyOf(a, b));
  if (slots_[slot].key != 0) RemoveAt(slot, dispatcher);
  return nullptr;  // nobody stores anything with a pair
}

void OrderedPairCache::removeOverlappingPairsContainingProxy(btBroadphaseProxy* proxy,
                                                             btDispatcher* dispatcher) {
  for (int i = 0; i < pairs_.size();) {
    const btBroadphasePair& pair = pairs_[i];
    if (pair.m_pProxy0 == proxy || pair.m_pProxy1 == proxy) {
      RemoveAt(Find(KeyOf(pair.m_pProxy0, pair.m_pProxy1)), dispatcher);
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
  const Slot& slot = slots_[Find(KeyOf(a, b))];
  return slot.key == 0 ? nullptr : &pairs_[static_cast<int>(slot.place)];
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
      RemoveAt(Find(KeyOf(pair.m_pProxy0, pair.m_pProxy1)), dispatcher);
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
  if (!is_sorted_) Sort();
  for (auto place = order_.rbegin(); place != order_.rend(); ++place) {
    const bool is_removed = callback->processOverlap(pairs_[static_cast<int>(place->at)]);
    CDB_CHECK(!is_removed);  // nobody who asks for this order removes
  }
}

// By the first body with a count, as there are few pairs of each, and then by the second.
void OrderedPairCache::Sort() {
  std::ranges::fill(begins_, 0);
  for (int i = 0; i < pairs_.size(); ++i) ++begins_[IdOf(pairs_[i].m_pProxy0) + 1];
  for (std::size_t i = 1; i < begins_.size(); ++i) begins_[i] += begins_[i - 1];
  order_.resize(static_cast<std::size_t>(pairs_.size()));
  for (int i = 0; i < pairs_.size(); ++i)
    order_[begins_[IdOf(pairs_[i].m_pProxy0)]++] = {IdOf(pairs_[i].m_pProxy1),
                                                    static_cast<std::uint32_t>(i)};
  std::uint32_t begin = 0;
  for (std::size_t i = 0; begin < order_.size(); begin = begins_[i++])
    std::sort(order_.begin() + begin, order_.begin() + begins_[i],
              [](const Place& a, const Place& b) { return a.second < b.second; });
  is_sorted_ = true;
}

}  // namespace cdb::detection
