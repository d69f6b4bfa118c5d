// Bullet adapter, narrow phase: runs a cdb::Detector in place of a btCollisionDispatcher.
#pragma once

#include <btBulletCollisionCommon.h>

#include <vector>

#include "runtime/engine/detection/detectors.h"
#include "runtime/engine/detection/scene_view.h"

namespace cdb::detection {

/// The pairs that the detector handles go to one FindContacts a cycle, the others to Bullet, which
/// also keeps the contacts: friction, restitution and what the solver remembers are Bullet's.
///
/// Old contacts of a pair are treated as Bullet 3.24 does: those of two balls are given up in each
/// cycle, others stay while the bodies keep close there.
///
/// Throws library::SceneError, from within a step, where the detector throws or finds a contact of
/// a pair that it was not asked for, of numbers that are none, with a normal that is not unit, or
/// whose points and distance disagree.
class AdapterDispatcher final : public btCollisionDispatcher {
 public:
  /// `view` must outlive it; `configuration` too, as for Bullet's own.
  AdapterDispatcher(btCollisionConfiguration* configuration, NamedDetector detector,
                    SceneView& view);

  /// Once, when all bodies are there. Nothing where the detector finds the pairs too: then it is
  /// prepared as that.
  void Prepare();

  void dispatchAllCollisionPairs(btOverlappingPairCache* cache, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override;

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
  // Of the cycle.
  std::vector<Pair> asked_;
  std::vector<btPersistentManifold*> manifolds_;  ///< of the pairs that were asked for
  std::vector<Contact> contacts_;
  std::vector<std::size_t> places_;  ///< among those pairs, of each contact
};

}  // namespace cdb::detection
