// Bullet adapter, broad phase: runs a cdb::Detector in place of a btBroadphaseInterface.
#pragma once

#include <btBulletCollisionCommon.h>

#include <vector>

#include "runtime/engine/detection/detectors.h"
#include "runtime/engine/detection/ordered_pair_cache.h"
#include "runtime/engine/detection/pair_changes.h"
#include "runtime/engine/detection/scene_view.h"

namespace cdb::detection {

/// Passes the boxes to the detector, checks its pairs, or the changes that it lists, and applies
/// the changes to the cache that Bullet reads.
///
/// Throws library::SceneError, from within a step, if the detector throws, or lists an unknown body
/// or a body with itself. A pair listed twice counts once. Ray casts, which `ccd` uses, test every
/// body.
class AdapterBroadPhase final : public btBroadphaseInterface {
 public:
  /// `view` must outlive it. All bodies that are added must be in it, and those that come and go.
  AdapterBroadPhase(NamedDetector detector, SceneView& view);

  /// To be called once, after the bodies of the start have been added.
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
  bool FindChanges(const Scene& scene);

  const NamedDetector detector_;
  SceneView& view_;
  std::vector<btBroadphaseProxy> proxies_;  ///< by body
  OrderedPairCache cache_;
  PairChanges changes_;
  std::vector<Pair> found_, lost_, list_;
  bool keeps_list_ = false;
};

}  // namespace cdb::detection
