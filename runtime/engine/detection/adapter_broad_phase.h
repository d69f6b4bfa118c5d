// Bullet adapter, broad phase: runs a cdb::Detector in place of a btBroadphaseInterface.
#pragma once

#include <btBulletCollisionCommon.h>

#include <vector>

#include "runtime/engine/detection/detectors.h"
#include "runtime/engine/detection/pair_changes.h"
#include "runtime/engine/detection/scene_view.h"

namespace cdb::detection {

/// Bullet's pairs by hash, which can be worked on in the order of their bodies without Bullet's own
/// sorting of them in every cycle.
class OrderedPairCache final : public btHashedOverlappingPairCache {
 public:
  /// Of `size` proxies that are one array, their m_uniqueId going up from 1.
  OrderedPairCache(const btBroadphaseProxy* first, std::size_t size)
      : first_(first), begins_(size + 1) {}

  btBroadphasePair* addOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b) override;
  void* removeOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b,
                              btDispatcher* dispatcher) override;
  using btHashedOverlappingPairCache::processAllOverlappingPairs;
  /// In the order that Bullet 3.24 has where it is to be deterministic: the pairs of later bodies
  /// first.
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

/// Tells the detector of the boxes, checks its pairs and brings what changed into Bullet's cache.
///
/// Throws library::SceneError, from within a step, where the detector throws, or lists a body that
/// there is not or one with itself. A pair listed twice counts once. Ray casts, which sweeps of
/// `ccd` make, look at every body.
class AdapterBroadPhase final : public btBroadphaseInterface {
 public:
  /// `view` must outlive it, and its bodies be added in its order.
  AdapterBroadPhase(NamedDetector detector, SceneView& view);

  /// Once, when all bodies are there.
  void Prepare();

  /// From the next cycle on, `list` is what the detector listed, before anything of it is dropped.
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
