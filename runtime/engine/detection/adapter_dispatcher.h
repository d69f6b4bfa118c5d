// Bullet adapter, narrow phase: runs a cdb::Detector in place of a btCollisionDispatcher.
#pragma once

#include <btBulletCollisionCommon.h>

#include <vector>

#include "runtime/engine/detection/detectors.h"
#include "runtime/engine/detection/scene_view.h"

namespace cdb::detection {

/// The pairs that the detector handles go to one call of FindContacts per cycle, the others to
/// Bullet. Bullet keeps all contacts: friction, restitution and warm starting are Bullet's.
///
/// Existing contacts of a pair are treated as by Bullet 3.24: those of two balls are discarded in
/// each cycle, others persist while the bodies stay close at the point.
///
/// Throws library::SceneError, from within a step, if the detector throws or returns a contact of a
/// pair that was not requested, with a NaN, with a normal that is not a unit vector, or with
/// inconsistent points and distance.
class AdapterDispatcher final : public btCollisionDispatcher {
 public:
  /// `view` must outlive it; `configuration` too, as for Bullet's own.
  AdapterDispatcher(btCollisionConfiguration* configuration, NamedDetector detector,
                    SceneView& view);

  /// To be called once, after all bodies have been added. Does nothing if the detector is also the
  /// broad phase, which prepares it.
  void Prepare();

  void dispatchAllCollisionPairs(btOverlappingPairCache* cache, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override;

  /// True if the contacts of the pair are the detector's, not Bullet's.
  static bool IsDetectors(const btBroadphasePair& pair);

 private:
  class Visitor;

  void Visit(btBroadphasePair& pair, const btDispatcherInfo& info);
  void Ask(btOverlappingPairCache& cache);
  std::size_t PlaceOf(const Contact& contact, btOverlappingPairCache& cache) const;
  void Check(const Contact& contact) const;
  void Keep();
  bool AreBalls(const Pair& pair) const { return is_ball_[pair.a] && is_ball_[pair.b]; }

  const NamedDetector detector_;
  SceneView& view_;
  std::vector<char> is_ball_;  ///< by body
  std::vector<double> sizes_;  ///< by body, m: the longest side; infinite for planes
  // Of the current cycle.
  std::vector<Pair> asked_;
  std::vector<btPersistentManifold*> manifolds_;  ///< of the requested pairs
  std::vector<Contact> contacts_;
  std::vector<std::size_t> places_;  ///< among those pairs, of each contact
};

}  // namespace cdb::detection
