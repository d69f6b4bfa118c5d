#include "library/detectors/bullet/broad_phases.h"

#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <random>

namespace cdb::bullet {
namespace {

/// Bullet has no infinity: this is the extent of the boxes of its planes.
constexpr btScalar kFar = BT_LARGE_FLOAT;

/// Rounds to the next number of Bullet's precision in the direction of `to`.
btScalar Rounded(double x, btScalar to) {
  const auto rounded = static_cast<btScalar>(std::clamp(x, -double{kFar}, double{kFar}));
  const bool is_inside =
      to > 0 ? static_cast<double>(rounded) < x : static_cast<double>(rounded) > x;
  return is_inside && std::fabs(rounded) < kFar ? std::nextafter(rounded, to) : rounded;
}
btVector3 Lower(const Vec3& v) {
  return {Rounded(v.x, -kFar), Rounded(v.y, -kFar), Rounded(v.z, -kFar)};
}
btVector3 Upper(const Vec3& v) {
  return {Rounded(v.x, kFar), Rounded(v.y, kFar), Rounded(v.z, kFar)};
}

/// btSimpleBroadphase treats a proxy without an object as a free one.
void* ObjectOf(Id body) { return reinterpret_cast<void*>(std::uintptr_t{body} + 1); }
Id IdOf(const btBroadphaseProxy* proxy) {
  return static_cast<Id>(reinterpret_cast<std::uintptr_t>(proxy->m_clientObject) - 1);
}

/// Bullet's pairs, and the same pairs as a flat list in the same order: reading the bodies through
/// the proxies each cycle would cost more than some broad phases.
class ListedPairs final : public btHashedOverlappingPairCache {
 public:
  btBroadphasePair* addOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b) override {
    btBroadphasePair* pair = btHashedOverlappingPairCache::addOverlappingPair(a, b);
    if (static_cast<std::size_t>(getNumOverlappingPairs()) > list_.size()) {
      list_.push_back({std::min(IdOf(a), IdOf(b)), std::max(IdOf(a), IdOf(b))});
      touched_.push_back(list_.back());
    }
    return pair;
  }
  void* removeOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b,
                              btDispatcher* dispatcher) override {
    const btBroadphasePair* pair = findPair(a, b);
    if (pair == nullptr) return nullptr;
    Pair& place = list_[static_cast<std::size_t>(pair - getOverlappingPairArrayPtr())];
    touched_.push_back(place);
    // Bullet also moves the last pair to the position of a removed one.
    place = list_.back();
    list_.pop_back();
    return btHashedOverlappingPairCache::removeOverlappingPair(a, b, dispatcher);
  }
  const std::vector<Pair>& list() const { return list_; }
  /// Pairs that were added or removed since Forget, some of them both.
  const std::vector<Pair>& touched() const { return touched_; }
  void Forget() { touched_.clear(); }

 private:
  std::vector<Pair> list_, touched_;
};

/// The range that sweep and prune divides into steps: the finite boxes, with room to move.
struct Bounds {
  btVector3 lower{0, 0, 0}, upper{0, 0, 0};
};

Bounds BoundsOf(const Scene& scene) {
  constexpr double kRoom = 0.5;  // as a fraction of the extent, on each side
  const auto along = [&](double Vec3::*axis) {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const Box& box : scene.boxes) {
      if (!std::isfinite(box.lower.*axis) || !std::isfinite(box.upper.*axis)) continue;
      least = std::min(least, box.lower.*axis);
      most = std::max(most, box.upper.*axis);
    }
    const double room = most > least ? kRoom * (most - least) : 1;
    return most >= least ? std::pair(least - room, most + room) : std::pair(-room, room);
  };
  const auto x = along(&Vec3::x), y = along(&Vec3::y), z = along(&Vec3::z);
  return {Lower({x.first, y.first, z.first}), Upper({x.second, y.second, z.second})};
}

/// The common part of all four: a box is passed to Bullet only if it has changed.
class BulletBroadPhase : public Detector {
 public:
  ~BulletBroadPhase() override {
    // Bullet searches all pairs for each proxy that is destroyed, so remove the pairs first.
    while (pairs_.getNumOverlappingPairs() > 0) {
      const btBroadphasePair& last =
          pairs_.getOverlappingPairArray()[pairs_.getNumOverlappingPairs() - 1];
      pairs_.removeOverlappingPair(last.m_pProxy0, last.m_pProxy1, &dispatcher_);
    }
    for (btBroadphaseProxy* proxy : proxies_)
      if (proxy != nullptr) broad_phase_->destroyProxy(proxy, &dispatcher_);
  }

  void Prepare(const Scene& scene) override {
    broad_phase_ = Make(scene, pairs_);
    is_listed_ = false;
    bodies_.resize(scene.size);
    proxies_.resize(scene.size);
    for (Id body = 0; body < scene.size; ++body) bodies_[body] = {scene.boxes[body], nullptr, body};
    // Boxes in order along a line would degenerate the tree to a list.
    std::shuffle(bodies_.begin(), bodies_.end(), std::mt19937_64(1));
    for (Body& body : bodies_)
      if (IsThere(body.box)) Add(scene, body);
  }

  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    Update(scene);
    pairs = pairs_.list();
    pairs_.Forget();
    is_listed_ = true;
  }

  bool FindChanges(const Scene& scene, std::vector<Pair>& came, std::vector<Pair>& went) override {
    if (!is_listed_) return Detector::FindChanges(scene, came, went);
    Update(scene);
    for (const Pair& pair : pairs_.touched()) {
      const bool are_there = proxies_[pair.a] != nullptr && proxies_[pair.b] != nullptr;
      (are_there && pairs_.findPair(proxies_[pair.a], proxies_[pair.b]) != nullptr ? came : went)
          .push_back(pair);
    }
    pairs_.Forget();
    return true;
  }

 private:
  struct Body {
    Box box;  ///< as Bullet has it
    btBroadphaseProxy* proxy;
    Id id;
  };

  virtual std::unique_ptr<btBroadphaseInterface> Make(const Scene& scene,
                                                      btOverlappingPairCache& pairs) = 0;
  /// False for the box of a body that is not in the world.
  static bool IsThere(const Box& box) { return !std::isnan(box.lower.x); }
  void Add(const Scene& scene, Body& body) {
    const Filter& filter = scene.filters[body.id];
    proxies_[body.id] = body.proxy = broad_phase_->createProxy(
        Lower(body.box.lower), Upper(body.box.upper), BOX_SHAPE_PROXYTYPE, ObjectOf(body.id),
        static_cast<int>(filter.group), static_cast<int>(filter.mask), &dispatcher_);
  }
  void Remove(Body& body) {
    if (body.proxy == nullptr) return;
    pairs_.removeOverlappingPairsContainingProxy(body.proxy, &dispatcher_);
    broad_phase_->destroyProxy(body.proxy, &dispatcher_);
    proxies_[body.id] = body.proxy = nullptr;
  }
  void Update(const Scene& scene) {
    constexpr std::size_t kAhead = 8;  // bodies whose boxes are fetched
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
#if defined(__GNUC__)
      if (i + kAhead < bodies_.size()) __builtin_prefetch(&scene.boxes[bodies_[i + kAhead].id]);
#endif
      Body& body = bodies_[i];
      const Box& box = scene.boxes[body.id];
      if (std::memcmp(&box, &body.box, sizeof box) == 0) continue;
      body.box = box;
      if (body.proxy != nullptr && IsThere(box))
        broad_phase_->setAabb(body.proxy, Lower(box.lower), Upper(box.upper), &dispatcher_);
      else if (IsThere(box))
        Add(scene, body);
      else
        Remove(body);
    }
    broad_phase_->calculateOverlappingPairs(&dispatcher_);
  }

  btDefaultCollisionConfiguration configuration_{[] {
    btDefaultCollisionConstructionInfo info;
    info.m_defaultMaxPersistentManifoldPoolSize = info.m_defaultMaxCollisionAlgorithmPoolSize = 1;
    return info;
  }()};
  btCollisionDispatcher dispatcher_{&configuration_};  ///< never called, but required by Bullet
  ListedPairs pairs_;
  std::unique_ptr<btBroadphaseInterface> broad_phase_;
  std::vector<Body> bodies_;                 ///< in the order in which Bullet has them in memory
  std::vector<btBroadphaseProxy*> proxies_;  ///< by id
  bool is_listed_ = false;                   ///< all pairs were, since Prepare
};

/// The capacity: all of them write past their arrays if it is exceeded.
int Room(const Scene& scene) { return std::max(static_cast<int>(scene.size), 1); }

class Simple final : public BulletBroadPhase {
  std::unique_ptr<btBroadphaseInterface> Make(const Scene& scene,
                                              btOverlappingPairCache& pairs) override {
    return std::make_unique<btSimpleBroadphase>(Room(scene), &pairs);
  }
};

template <typename Sweep, typename Handle>
class Sap final : public BulletBroadPhase {
  std::unique_ptr<btBroadphaseInterface> Make(const Scene& scene,
                                              btOverlappingPairCache& pairs) override {
    const Bounds bounds = BoundsOf(scene);
    constexpr bool kWithoutRaycastTree = true;  // it is not needed for pairs
    return std::make_unique<Sweep>(bounds.lower, bounds.upper, static_cast<Handle>(Room(scene)),
                                   &pairs, kWithoutRaycastTree);
  }
};

class Dbvt final : public BulletBroadPhase {
  std::unique_ptr<btBroadphaseInterface> Make(const Scene&,
                                              btOverlappingPairCache& pairs) override {
    return std::make_unique<btDbvtBroadphase>(&pairs);
  }
};

}  // namespace

Detector* MakeBulletSimple(const Options&) { return new Simple; }
Detector* MakeBulletSap(const Options&) { return new Sap<btAxisSweep3, unsigned short>; }
Detector* MakeBulletSap32(const Options&) { return new Sap<bt32BitAxisSweep3, unsigned>; }
Detector* MakeBulletDbvt(const Options&) { return new Dbvt; }

}  // namespace cdb::bullet
