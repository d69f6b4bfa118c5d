// The overlapping pairs of a world, for Bullet to read and a detector's changes to update.
#pragma once

#include <btBulletCollisionCommon.h>

#include <cstdint>
#include <span>
#include <vector>

#include "library/detectors/detector.h"

namespace cdb::detection {

/// Takes the place of Bullet's btHashedOverlappingPairCache, with the same pairs at the same places
/// of the array: new ones last, and the last one where one leaves. Looks up pairs without reading
/// their proxies, and processes them in the order of their bodies, if asked, without sorting all of
/// them in every cycle. Not thread-safe.
class OrderedPairCache final : public btOverlappingPairCache {
 public:
  /// The proxies are an array of `size` elements, with ascending m_uniqueId from 1.
  OrderedPairCache(btBroadphaseProxy* first, std::size_t size) : first_(first), begins_(size + 1) {}

  /// Pairs, a < b, that are not there.
  void Add(std::span<const Pair> pairs);
  /// Passes over those that are not there.
  void Remove(std::span<const Pair> pairs, btDispatcher* dispatcher);
  bool Has(std::uint32_t a, std::uint32_t b) const { return slots_[Find(KeyOf(a, b))].key != 0; }

  std::vector<Pair> List() const;

  btBroadphasePair* addOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b) override;
  void* removeOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b,
                              btDispatcher* dispatcher) override;
  void removeOverlappingPairsContainingProxy(btBroadphaseProxy* proxy,
                                             btDispatcher* dispatcher) override;
  void cleanOverlappingPair(btBroadphasePair& pair, btDispatcher* dispatcher) override;
  void cleanProxyFromPairs(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override;
  btBroadphasePair* findPair(btBroadphaseProxy* a, btBroadphaseProxy* b) override;

  btBroadphasePair* getOverlappingPairArrayPtr() override {
    return pairs_.size() > 0 ? &pairs_[0] : nullptr;
  }
  const btBroadphasePair* getOverlappingPairArrayPtr() const override {
    return pairs_.size() > 0 ? &pairs_[0] : nullptr;
  }
  btBroadphasePairArray& getOverlappingPairArray() override { return pairs_; }
  int getNumOverlappingPairs() const override { return pairs_.size(); }

  void processAllOverlappingPairs(btOverlapCallback* callback, btDispatcher* dispatcher) override;
  /// In the order of Bullet 3.24 in deterministic mode: the pairs of later bodies first.
  void processAllOverlappingPairs(btOverlapCallback* callback, btDispatcher* dispatcher,
                                  const btDispatcherInfo& info) override;

  bool needsBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override;
  btOverlapFilterCallback* getOverlapFilterCallback() override { return filter_; }
  void setOverlapFilterCallback(btOverlapFilterCallback* callback) override { filter_ = callback; }
  bool hasDeferredRemoval() override { return false; }
  void setInternalGhostPairCallback(btOverlappingPairCallback* /*callback*/) override {}
  /// For Bullet's own broad phases.
  void sortOverlappingPairs(btDispatcher* /*dispatcher*/) override {}

 private:
  using Key = std::uint64_t;
  struct Slot {
    Key key = 0;  ///< of no pair
    std::uint32_t place = 0;
  };
  struct Place {
    std::uint32_t second;  ///< body of a pair
    std::uint32_t at;      ///< in the array
  };

  static Key KeyOf(std::uint32_t a, std::uint32_t b) { return Key{a} << 32 | b; }
  Key KeyOf(const btBroadphaseProxy* a, const btBroadphaseProxy* b) const {
    return a < b ? KeyOf(IdOf(a), IdOf(b)) : KeyOf(IdOf(b), IdOf(a));
  }
  std::uint32_t IdOf(const btBroadphaseProxy* proxy) const {
    return static_cast<std::uint32_t>(proxy - first_);
  }
  std::size_t HomeOf(Key key) const { return key * 0x9E3779B97F4A7C15u >> shift_; }
  std::size_t Find(Key key) const;  ///< its slot, or the one for it
  void Free(std::size_t slot);
  void Append(Key key);
  void FetchAhead(std::span<const Pair> pairs, std::size_t at) const;
  void Grow();
  void RemoveAt(std::size_t slot, btDispatcher* dispatcher);
  void Sort();

  btBroadphaseProxy* first_;
  btBroadphasePairArray pairs_;
  btOverlapFilterCallback* filter_ = nullptr;
  unsigned shift_ = 64 - 6;
  std::vector<Slot> slots_ = std::vector<Slot>(64);  ///< twice the pairs or more, a power of two
  bool is_sorted_ = false;
  std::vector<Place> order_;
  std::vector<std::uint32_t> begins_;  ///< of the pairs of a first body, while they are sorted
};

}  // namespace cdb::detection
