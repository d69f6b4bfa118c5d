#include "runtime/engine/detection/adapter_broad_phase.h"

#include <algorithm>
#include <utility>

#include "dsl/text/check.h"
#include "library/detectors/bullet/vectors.h"

namespace cdb::detection {
namespace {

/// Bullet has no infinity: this is the side of its planes' boxes.
constexpr double kFar = BT_LARGE_FLOAT;

btVector3 Finite(const Vec3& v) {
  const auto part = [](double x) { return static_cast<btScalar>(std::clamp(x, -kFar, kFar)); };
  return {part(v.x), part(v.y), part(v.z)};
}

}  // namespace

AdapterBroadPhase::AdapterBroadPhase(NamedDetector detector, SceneView& view)
    : detector_(std::move(detector)),
      view_(view),
      proxies_(view.size()),
      cache_(proxies_.data(), view.size()) {}

void AdapterBroadPhase::Prepare() {
  try {
    detector_.detector->Prepare(view_.For(detector_.WantsPoses()));
  } catch (...) {
    Blame(detector_, "Prepare", view_.cycle());
  }
}

btBroadphaseProxy* AdapterBroadPhase::createProxy(const btVector3& lower, const btVector3& upper,
                                                  int /*shape_type*/, void* object, int group,
                                                  int mask, btDispatcher* /*dispatcher*/) {
  const Id id = view_.IdOf(*static_cast<btCollisionObject*>(object));
  CDB_CHECK(id < view_.size() && object == &view_.body(id));
  btBroadphaseProxy& proxy = proxies_[id];
  CDB_CHECK(proxy.m_clientObject == nullptr);
  proxy.m_clientObject = object;
  proxy.m_collisionFilterGroup = group;
  proxy.m_collisionFilterMask = mask;
  proxy.m_uniqueId = static_cast<int>(id + 1);
  view_.SetBox(id, lower, upper);
  view_.SetFilter(id, group, mask);
  return &proxy;
}

void AdapterBroadPhase::destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) {
  cache_.removeOverlappingPairsContainingProxy(proxy, dispatcher);
  proxy->m_clientObject = nullptr;
  view_.RemoveBox(IdOf(proxy));
}

void AdapterBroadPhase::setAabb(btBroadphaseProxy* proxy, const btVector3& lower,
                                const btVector3& upper, btDispatcher* /*dispatcher*/) {
  view_.SetBox(IdOf(proxy), lower, upper);
}

void AdapterBroadPhase::getAabb(btBroadphaseProxy* proxy, btVector3& lower,
                                btVector3& upper) const {
  const Box& box = view_.box(IdOf(proxy));
  lower = Finite(box.lower);
  upper = Finite(box.upper);
}

// What moves along the ray is the box `lower` to `upper` around it; the callback looks closer.
void AdapterBroadPhase::rayTest(const btVector3& from, const btVector3& to,
                                btBroadphaseRayCallback& callback, const btVector3& lower,
                                const btVector3& upper) {
  btVector3 least = from, most = from;
  least.setMin(to);
  most.setMax(to);
  aabbTest(least + lower, most + upper, callback);
}

void AdapterBroadPhase::aabbTest(const btVector3& lower, const btVector3& upper,
                                 btBroadphaseAabbCallback& callback) {
  const Box box = {bullet::ToVec3(lower), bullet::ToVec3(upper)};
  for (const btBroadphaseProxy& proxy : proxies_)
    if (proxy.m_clientObject != nullptr && Overlap(box, view_.box(IdOf(&proxy))))
      callback.process(&proxy);
}

/// False if there are none.
bool AdapterBroadPhase::FindChanges(const Scene& scene) {
  found_.clear();
  lost_.clear();
  const auto is_kept = [this](const Pair& pair) { return cache_.Has(pair); };
  if (keeps_list_) {
    detector_.detector->FindPairs(scene, found_);
    list_ = found_;
  } else if (detector_.detector->FindChanges(scene, found_, lost_)) {
    return changes_.Take(scene, found_, lost_, is_kept);
  }
  if (!changes_.knows_list()) changes_.SetList(cache_.List());
  return changes_.Update(scene, found_, is_kept);
}

void AdapterBroadPhase::calculateOverlappingPairs(btDispatcher* dispatcher) {
  view_.BeginCycle();
  try {
    if (!FindChanges(view_.For(detector_.WantsPoses()))) return;
  } catch (...) {
    Blame(detector_, "FindPairs", view_.cycle());
  }
  cache_.Remove(changes_.went(), dispatcher);
  cache_.Add(changes_.came());
}

void AdapterBroadPhase::getBroadphaseAabb(btVector3& lower, btVector3& upper) const {
  lower = btVector3(-BT_LARGE_FLOAT, -BT_LARGE_FLOAT, -BT_LARGE_FLOAT);
  upper = -lower;
}

}  // namespace cdb::detection
