// Bullet adapter, broad phase: runs a cdb::Detector in place of a btBroadphaseInterface.
#pragma once

#include <btBulletCollisionCommon.h>

#include <vector>

#include "runtime/engine/detection/detectors.h"
#include "runtime/engine/detection/pair_changes.h"
#include "runtime/engine/detection/scene_view.h"

namespace cdb::detection {

/// Bullet's hashed pair cache, which can process pairs in the order of their bodies without
/// Bullet's sorting in every cycle.
class OrderedPairCache final : public btHashedOverlappingPairCache {
 public:
  /// The proxies are an array of `size` elements, with ascending m_uniqueId from 1.
  OrderedPairCache(const btBroadphaseProxy* first, std::size_t size)
      : first_(first), begins_(size + 1) {}

  btBroadphasePair* addOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b) override;
  void* removeOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b,
                              btDispatcher* dispatcher) override;
  using btHashedOverlappingPairCache::processAllOverlappingPairs;
  /// In the order of Bullet 3.24 in deterministic mode: the pairs of later bodies first.
  void processAllOverlappingPairs(btOverlapCallback* callback, btDispatcher* dispatcher,
                                  const btDispatcherInfo& info) override;

 private:
  void Sort();

  const btBroadphaseProxy* first_;
  bool is_sorted_ = false;
  struct Place {
    std::uint32_t second;  ///< body of a pair
    std::uint32_t at;      ///< in Bullet's array
  };
  std::vector<Place> order_;
  std::vector<std::uint32_t> begins_;  ///< of the pairs of a first body, while they are sorted
};

/// Passes the boxes to the detector, checks its pairs and applies the changes to Bullet's cache.
///
/// Throws library::SceneError, from within a step, if the detector throws, or lists an unknown body
/// or a body with itself. A pair listed twice counts once. Ray casts, which `ccd` uses, test every
/// body.
class AdapterBroadPhase final : public btBroadphaseInterface {
 public:
  /// `view` must outlive it; bodies must be added in the order of the view.
  AdapterBroadPhase(NamedDetector detector, SceneView& view);

  /// To be called once, after all bodies have been added.
  void Prepare();

  /// From the next cycle on, stores the unfiltered pairs of the detector in `list`.
  void KeepList() { keeps_list_ = true; }
  const std::vector<Pair>& list() const { return list_; }

  btBroadphaseProxy* createProxy(const btVector3& lower, const btVector3& upper, int shape_type,
                                 void* object, int group, int mask,
                                 btDispatcher* dispatcher) override;
  void destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override;
  void setAabb(btBroadphaseProxy* proxy, const btVector3& lower, const btVector3& upper,
               btDispatcher* dispatcher) override;
  void getAabb(btBroadphaseProxy* proxy, btVector3& lower, btVector3& upper) const override;
  void rayTest(const btVector3& from, const btVector3& to, btBroadphaseRayCallback& callback,
               const btVector3& lower, const btVector3& upper) override;
  void aabbTest(const btVector3& lower, const btVector3& upper,
                btBroadphaseAabbCallback& callback) override;
  void calculateOverlappingPairs(btDispatcher* dispatcher) override;
  btOverlappingPairCache* getOverlappingPairCache() override { return &cache_; }
  const btOverlappingPairCache* getOverlappingPairCache() const override { return &cache_; }
  void getBroadphaseAabb(btVector3& lower, btVector3& upper) const override;
  void printStats() override {}

 private:
  Id IdOf(const btBroadphaseProxy* proxy) const { return static_cast<Id>(proxy - proxies_.data()); }

  const NamedDetector detector_;
  SceneView& view_;
  std::vector<btBroadphaseProxy> proxies_;  ///< by body
  Id added_ = 0;
  OrderedPairCache cache_;
  PairChanges changes_;
  std::vector<Pair> found_, list_;
  bool keeps_list_ = false;
};

}  // namespace cdb::detection
