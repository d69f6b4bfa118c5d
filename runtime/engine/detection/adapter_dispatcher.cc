#include "runtime/engine/detection/adapter_dispatcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "dsl/text/check.h"
#include "library/detectors/bullet/vectors.h"

namespace cdb::detection {
namespace {

constexpr double kUnit = 1e-3;           ///< a normal's length is off by no more
constexpr double kSizeTolerance = 1e-3;  ///< points and distance disagree by no more, in sizes
constexpr double kFarTolerance = 1e-6;   ///< and this part of the coordinates

/// Whose pair it is, in a field that Bullet sets to 0 with a new one and does not use.
enum Owner { kNobody = 0, kBullet = 1, kDetector = 2 };

/// Stands in a pair for what found its contacts, so that Bullet's own clean-up frees them with the
/// pair.
class KeptContacts final : public btCollisionAlgorithm {
 public:
  KeptContacts(btDispatcher& dispatcher, const btCollisionObject* a, const btCollisionObject* b)
      : manifold_(dispatcher.getNewManifold(a, b)) {
    m_dispatcher = &dispatcher;
  }
  ~KeptContacts() override { m_dispatcher->releaseManifold(manifold_); }
  btPersistentManifold* manifold() const { return manifold_; }
  std::uint64_t asked_in = 0;  ///< the last cycle in which the detector was asked,
  std::size_t place = 0;       ///< and the pair's place among all that it was asked for

  void processCollision(const btCollisionObjectWrapper*, const btCollisionObjectWrapper*,
                        const btDispatcherInfo&, btManifoldResult*) override {
    CDB_CHECK(false);  // AdapterDispatcher's, for all of them at once
  }
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1;
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override {
    manifolds.push_back(manifold_);
  }

 private:
  btPersistentManifold* manifold_;
};

Eigen::Map<const Eigen::Vector3d> AsEigen(const Vec3& v) {
  return Eigen::Map<const Eigen::Vector3d>(&v.x);
}

/// Bullet's way into a manifold.
class Into {
 public:
  explicit Into(btPersistentManifold* manifold)
      : a_(nullptr, manifold->getBody0()->getCollisionShape(), manifold->getBody0(),
           manifold->getBody0()->getWorldTransform(), -1, -1),
        b_(nullptr, manifold->getBody1()->getCollisionShape(), manifold->getBody1(),
           manifold->getBody1()->getWorldTransform(), -1, -1),
        result_(&a_, &b_) {
    result_.setPersistentManifold(manifold);
  }
  void Add(const Contact& contact) {
    result_.addContactPoint(bullet::ToBullet(contact.normal), bullet::ToBullet(contact.on_b),
                            static_cast<btScalar>(contact.distance));
  }
  void Refresh() { result_.refreshContactPoints(); }

 private:
  const btCollisionObjectWrapper a_, b_;
  btManifoldResult result_;
};

}  // namespace

class AdapterDispatcher::Visitor final : public btOverlapCallback {
 public:
  Visitor(AdapterDispatcher& dispatcher, const btDispatcherInfo& info)
      : dispatcher_(dispatcher), info_(info) {}
  bool processOverlap(btBroadphasePair& pair) override {
    dispatcher_.Visit(pair, info_);
    return false;
  }

 private:
  AdapterDispatcher& dispatcher_;
  const btDispatcherInfo& info_;
};

AdapterDispatcher::AdapterDispatcher(btCollisionConfiguration* configuration,
                                     NamedDetector detector, SceneView& view)
    : btCollisionDispatcher(configuration), detector_(std::move(detector)), view_(view) {
  const Scene scene = view_.For(false);
  for (Id id = 0; id < view_.size(); ++id) {
    is_ball_.push_back(view_.body(id).getCollisionShape()->getShapeType() ==
                       SPHERE_SHAPE_PROXYTYPE);
    sizes_.push_back(2 * AsEigen(scene.shapes[id].half).maxCoeff());
  }
}

void AdapterDispatcher::Prepare() {
  try {
    detector_.detector->Prepare(view_.For(true));
  } catch (...) {
    Blame(detector_, "Prepare", view_.cycle());
  }
}

void AdapterDispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* cache,
                                                  const btDispatcherInfo& info,
                                                  btDispatcher* dispatcher) {
  asked_.clear();
  manifolds_.clear();
  contacts_.clear();
  Visitor visitor(*this, info);
  cache->processAllOverlappingPairs(&visitor, dispatcher, info);
  try {
    Ask(*cache);
  } catch (...) {
    Blame(detector_, "FindContacts", view_.cycle());
  }
  Keep();
}

void AdapterDispatcher::Visit(btBroadphasePair& pair, const btDispatcherInfo& info) {
  const auto* a = static_cast<const btCollisionObject*>(pair.m_pProxy0->m_clientObject);
  const auto* b = static_cast<const btCollisionObject*>(pair.m_pProxy1->m_clientObject);
  const Pair bodies = {static_cast<Id>(pair.m_pProxy0->m_uniqueId - 1),
                       static_cast<Id>(pair.m_pProxy1->m_uniqueId - 1)};
  if (pair.m_internalTmpValue == kNobody) {
    try {
      const bool handles = detector_.detector->Handles(view_.For(true), bodies.a, bodies.b);
      pair.m_internalTmpValue = handles ? kDetector : kBullet;
    } catch (...) {
      Blame(detector_, "Handles", view_.cycle());
    }
  }
  if (pair.m_internalTmpValue == kBullet) return getNearCallback()(pair, *this, info);
  if (!needsCollision(a, b)) return;
  if (pair.m_algorithm == nullptr)
    pair.m_algorithm =
        new (allocateCollisionAlgorithm(sizeof(KeptContacts))) KeptContacts(*this, a, b);
  auto& kept = static_cast<KeptContacts&>(*pair.m_algorithm);
  kept.asked_in = view_.cycle();
  kept.place = asked_.size();
  asked_.push_back(bodies);
  manifolds_.push_back(kept.manifold());
}

bool AdapterDispatcher::IsDetectors(const btBroadphasePair& pair) {
  return pair.m_internalTmpValue == kDetector;
}

void AdapterDispatcher::Ask(btOverlappingPairCache& cache) {
  detector_.detector->FindContacts(view_.For(true), asked_, contacts_);
  places_.clear();
  for (const Contact& contact : contacts_) {
    places_.push_back(PlaceOf(contact, cache));
    Check(contact);
  }
}

// Most detectors answer in the order in which they are asked: soon after the last one.
std::size_t AdapterDispatcher::PlaceOf(const Contact& contact,
                                       btOverlappingPairCache& cache) const {
  constexpr std::size_t kSoon = 16;
  const Pair pair = {contact.a, contact.b};
  const std::size_t last = places_.empty() ? 0 : places_.back();
  for (std::size_t i = last; i < std::min(last + kSoon, asked_.size()); ++i)
    if (asked_[i] == pair) return i;
  if (pair.a < pair.b && pair.b < view_.size()) {
    const btBroadphasePair* found = cache.findPair(view_.body(pair.a).getBroadphaseHandle(),
                                                   view_.body(pair.b).getBroadphaseHandle());
    if (found != nullptr && found->m_internalTmpValue == kDetector &&
        found->m_algorithm != nullptr) {
      const auto& kept = static_cast<const KeptContacts&>(*found->m_algorithm);
      if (kept.asked_in == view_.cycle()) return kept.place;
    }
  }
  throw std::invalid_argument(
      fmt::format("it returns a contact of the bodies {} and {}, a pair that it was not given",
                  contact.a, contact.b));
}

void AdapterDispatcher::Check(const Contact& contact) const {
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(
        fmt::format("the contact of the bodies {} and {} {}", contact.a, contact.b, what));
  };
  const auto on_a = AsEigen(contact.on_a), on_b = AsEigen(contact.on_b);
  const auto normal = AsEigen(contact.normal);
  if (!on_a.allFinite() || !on_b.allFinite() || !normal.allFinite() ||
      !std::isfinite(contact.distance))
    refuse("has a number that is not finite");
  if (std::fabs(normal.norm() - 1) > kUnit)
    refuse(fmt::format("has a normal of length {:.6g}; it must be 1", normal.norm()));
  const double size = std::min(sizes_[contact.a], sizes_[contact.b]);
  const double apart = (on_a - on_b - contact.distance * normal).norm();
  const double tolerance =
      kSizeTolerance * size +
      kFarTolerance * std::max(on_a.cwiseAbs().maxCoeff(), on_b.cwiseAbs().maxCoeff());
  if (apart > tolerance)
    refuse(
        fmt::format("contradicts itself by {:.3g} m: its point on the first body has to be that "
                    "on the second and the distance, {:.6g} m, times the normal, which points "
                    "from the second to the first",
                    apart, contact.distance));
}

void AdapterDispatcher::Keep() {
  for (std::size_t i = 0; i < asked_.size(); ++i)
    if (AreBalls(asked_[i])) manifolds_[i]->clearManifold();
  for (std::size_t i = 0; i < contacts_.size(); ++i) Into(manifolds_[places_[i]]).Add(contacts_[i]);
  for (std::size_t i = 0; i < asked_.size(); ++i)
    if (!AreBalls(asked_[i])) Into(manifolds_[i]).Refresh();
}

}  // namespace cdb::detection
