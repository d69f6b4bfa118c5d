// The overlapping pairs of a world, for Bullet to read and a detector's changes to update.
#pragma once

#include <btBulletCollisionCommon.h>

#include <cstdint>
#include <span>
#include <vector>

#include "library/detectors/detector.h"

namespace cdb::detection {

/// Takes the place of Bullet's btHashedOverlappingPairCache, with the same pairs at the same places
/// of the array: new ones last, and the last one where one leaves. Beside the array are rows: for
/// each body the later bodies that it makes pairs with, in order, and their places. Pairs are
/// looked up in them, without reading proxies, and processed in their order, if asked, without
/// being sorted. Changes that come in order are applied row by row. Not thread-safe.
class OrderedPairCache final : public btOverlappingPairCache {
 public:
  /// The proxies are an array of `size` elements, with ascending m_uniqueId from 1.
  OrderedPairCache(btBroadphaseProxy* first, std::size_t size) : first_(first), rows_(size) {}

  /// Pairs in order, a < b, each once. Passes over those that are there.
  void Add(std::span<const Pair> pairs);
  /// The same; passes over those that are not there.
  void Remove(std::span<const Pair> pairs, btDispatcher* dispatcher);
  /// Calls visit(pair, btBroadphasePair&) with each, a < b, in the order of
  /// processAllOverlappingPairs. `visit` adds and removes none.
  template <typename Visit>
  void ForEach(bool is_sorted, Visit visit);
  /// The same with those of which the first body is from `begin` to `end`, in the order `sorted`.
  /// Different threads may visit different ones.
  template <typename Visit>
  void ForEachFrom(std::size_t begin, std::size_t end, Visit visit);
  bool Has(const Pair& pair) const { return Find(pair) != kNone; }
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
  static constexpr std::uint32_t kNone = ~0u;
  struct Entry {
    std::uint32_t second;  ///< body of a pair
    std::uint32_t place;   ///< in the array
  };
  /// A range of entries_, with room for more.
  struct Row {
    std::uint32_t begin = 0, size = 0, capacity = 0;
  };

  std::uint32_t IdOf(const btBroadphaseProxy* proxy) const {
    return static_cast<std::uint32_t>(proxy - first_);
  }
  Pair PairOf(const btBroadphaseProxy* a, const btBroadphaseProxy* b) const {
    return a < b ? Pair{IdOf(a), IdOf(b)} : Pair{IdOf(b), IdOf(a)};
  }
  std::uint32_t Find(const Pair& pair) const;  ///< its entry, or kNone
  void AddToRow(std::span<const Pair> pairs);
  void MakeRoom(Row& row, std::size_t count);
  void TidyRows();
  void RemoveAt(std::uint32_t place, btDispatcher* dispatcher);
  static void Prefetch([[maybe_unused]] const void* at) {
#if defined(__GNUC__)
    __builtin_prefetch(at);
#endif
  }
  void FetchAhead(std::size_t at, btDispatcher* dispatcher);

  btBroadphaseProxy* first_;
  btBroadphasePairArray pairs_;
  btOverlapFilterCallback* filter_ = nullptr;
  std::vector<Row> rows_;  ///< by first body
  std::vector<Entry> entries_;
  std::size_t left_behind_ = 0;         ///< entries that belong to no row
  std::vector<Id> fresh_;               ///< of a call of AddToRow
  std::vector<std::uint32_t> leaving_;  ///< entries, of a call of Remove
  btManifoldArray manifolds_;           ///< of a call of FetchAhead
};

template <typename Visit>
void OrderedPairCache::ForEach(bool is_sorted, Visit visit) {
  if (is_sorted) return ForEachFrom(0, rows_.size(), visit);
  for (int i = 0; i < pairs_.size(); ++i)
    visit(PairOf(pairs_[i].m_pProxy0, pairs_[i].m_pProxy1), pairs_[i]);
}

template <typename Visit>
void OrderedPairCache::ForEachFrom(std::size_t begin, std::size_t end, Visit visit) {
  const auto pair_at = [this](std::uint32_t place) -> btBroadphasePair& {
    return pairs_[static_cast<int>(place)];
  };
  const auto entries = [this](std::size_t row) {
    return std::span(entries_).subspan(rows_[row].begin, rows_[row].size);
  };
  // Rows are short, so fetch the pairs two rows ahead and their algorithms one row ahead.
  for (std::size_t row = end; row-- > begin;) {
    if (row > begin + 1)
      for (const Entry& entry : entries(row - 2)) Prefetch(&pair_at(entry.place));
    if (row > begin)
      for (const Entry& entry : entries(row - 1)) Prefetch(pair_at(entry.place).m_algorithm);
    const std::span<Entry> own = entries(row);
    for (auto entry = own.rbegin(); entry != own.rend(); ++entry)
      visit(Pair{static_cast<Id>(row), entry->second}, pair_at(entry->place));
  }
}

}  // namespace cdb::detection
