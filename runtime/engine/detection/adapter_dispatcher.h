// Bullet adapter, narrow phase: runs a cdb::Detector in place of a btCollisionDispatcher.
#pragma once

#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <vector>

#include "library/detectors/kernels/pair_buffer.h"
#include "runtime/engine/detection/detectors.h"
#include "runtime/engine/detection/ordered_pair_cache.h"
#include "runtime/engine/detection/scene_view.h"

namespace cdb::detection {

class KeptContacts;

/// The pairs that the detector handles go to one call of FindContacts per cycle, the others to
/// Bullet. Bullet keeps all contacts: friction, restitution and warm starting are Bullet's.
///
/// Contacts of a detector that lists all points of a pair replace those of the last cycle. Others
/// accumulate as in Bullet 3.24; see KeptContacts. A pair gets a manifold with
/// its first contact if pairs are in the order `sorted`, in which manifolds without contacts have
/// no effect in Bullet; else at once, since Bullet then solves contacts in the order of manifolds.
/// The pairs of a detector that lists all points are collected, and its contacts kept, by as many
/// threads as it may use, in the same order as by one, and in manifolds that are made in the order
/// of the pairs.
///
/// Throws library::SceneError, from within a step, if the detector throws or returns a contact of a
/// pair that was not requested, with a NaN, with a normal that is not a unit vector, or with
/// inconsistent points and distance.
class AdapterDispatcher final : public btCollisionDispatcher {
 public:
  /// `view` must outlive it; `configuration` too, as for Bullet's own. The pairs of its world must
  /// be those of an AdapterBroadPhase with the same view.
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
  /// A pair that the detector is asked for.
  struct Place {
    btBroadphasePair* pair;
    btCollisionAlgorithm* kept;  ///< of the pair, a KeptContacts; null if there is none
    std::uint32_t first, count;  ///< of its contacts
  };
  /// The pairs of a part of the bodies.
  struct alignas(64) Visited {
    std::vector<Pair> asked;
    std::vector<Place> places;
    std::vector<btBroadphasePair*> for_bullet;

    void Clear() {
      asked.clear();
      places.clear();
      for_bullet.clear();
    }
  };

  void Visit(const Scene& scene, const Pair& bodies, btBroadphasePair& pair,
             const btDispatcherInfo& info, Visited& to);
  void VisitAll(const btDispatcherInfo& info);
  bool Handles(const Scene& scene, const Pair& bodies);
  KeptContacts& Make(btBroadphasePair& pair);
  void Ask();
  void AssignContacts();
  bool AreInOrder();
  std::size_t Look(const Contact& contact);
  double SmallerSize(const Contact& contact) const {
    return std::min(sizes_[contact.a], sizes_[contact.b]);
  }
  void Check(const Contact& contact) const;
  void Keep();
  void KeepOf(const Place& place);

  const NamedDetector detector_;
  SceneView& view_;
  kernels::PairParts parts_;      ///< of the pairs whose contacts are kept
  std::vector<Visited> visited_;  ///< by part; after VisitAll, the first one has all
  std::vector<double> sizes_;     ///< by body, m: the longest side; infinite for planes
  // Of the current cycle.
  OrderedPairCache* cache_ = nullptr;
  std::vector<Pair>& asked_;
  std::vector<Place>& places_;  ///< of the requested pairs
  std::vector<Contact> contacts_, in_order_;
  bool are_indexed_ = false;  ///< the pairs hold their places
};

}  // namespace cdb::detection
