// The contact points of a pair whose contacts a detector finds.
#pragma once

#include <btBulletCollisionCommon.h>

#include <span>

#include "library/detectors/detector.h"

namespace cdb::detection {

/// Stands in a pair for the algorithm that Bullet has there, so that Bullet's own clean-up frees
/// its manifold with the pair. Accumulated points are those that btManifoldResult would make, to
/// the bit, without its set-up for each of them. Assumes that the materials of bodies do not
/// change.
///
/// To be allocated by allocateCollisionAlgorithm of the dispatcher. Not thread-safe.
class KeptContacts final : public btCollisionAlgorithm {
 public:
  KeptContacts(btDispatcher& dispatcher, const btCollisionObject& a, const btCollisionObject& b);
  ~KeptContacts() override { m_dispatcher->releaseManifold(&manifold_); }
  KeptContacts(const KeptContacts&) = delete;
  KeptContacts& operator=(const KeptContacts&) = delete;

  /// Takes the contacts of a cycle, all of this pair.
  ///
  /// If they are all that the bodies have, and at most four, they are the points of the manifold
  /// from now on. A point starts with the impulses of the nearest earlier one within Bullet's
  /// breaking threshold, except those of two balls, which Bullet forgets.
  ///
  /// Otherwise points accumulate as in Bullet: those of two balls are discarded, a contact takes
  /// the place of a point nearby or of the least useful of four, and points move with their bodies
  /// until these are no longer close there.
  void Update(std::span<const Contact> contacts, bool are_all);

  void processCollision(const btCollisionObjectWrapper*, const btCollisionObjectWrapper*,
                        const btDispatcherInfo&, btManifoldResult*) override;
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1;
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override {
    manifolds.push_back(&manifold_);
  }

 private:
  /// What the points of a pair have in common.
  struct Material {
    btScalar friction, restitution, rolling_friction, spinning_friction;
    btScalar stiffness, damping;
    bool is_soft;  ///< has the last two
  };

  static Material MaterialOf(const btCollisionObject* a, const btCollisionObject* b);
  void Prepare(btManifoldPoint& point) const;
  void Replace(std::span<const Contact> contacts);
  void Add(std::span<const Contact> contacts);
  void AddByBullet(std::span<const Contact> contacts);

  btPersistentManifold& manifold_;
  const bool are_balls_;
  const bool is_plain_;  ///< neither body has a setting that Bullet treats contact by contact
  const Material material_;
};

}  // namespace cdb::detection
