#include "runtime/engine/detection/broad_phase.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/schema/catalogue.h"
#include "library/scene_error.h"
#include "runtime/engine/detection/detectors.h"

namespace cdb::detection {
namespace {

int NumberOf(const void* object) {
  return static_cast<const btCollisionObject*>(object)->getUserIndex() + 1;
}

class NumberedSimple final : public btSimpleBroadphase {
 public:
  using btSimpleBroadphase::btSimpleBroadphase;
  btBroadphaseProxy* createProxy(const btVector3& lower, const btVector3& upper, int shape_type,
                                 void* object, int group, int mask,
                                 btDispatcher* dispatcher) override {
    btBroadphaseProxy* proxy =
        btSimpleBroadphase::createProxy(lower, upper, shape_type, object, group, mask, dispatcher);
    proxy->m_uniqueId = NumberOf(object);
    return proxy;
  }
};

/// The tree looks for the pairs of a new body at once, and keeps them by their numbers: it must
/// not collide before it has its own.
class NumberedTree final : public btDbvtBroadphase {
 public:
  btBroadphaseProxy* createProxy(const btVector3& lower, const btVector3& upper, int shape_type,
                                 void* object, int group, int mask,
                                 btDispatcher* dispatcher) override {
    const btVector3 middle = (lower + upper) / 2;
    btBroadphaseProxy* proxy =
        btDbvtBroadphase::createProxy(middle, middle, shape_type, object, 0, 0, dispatcher);
    proxy->m_uniqueId = NumberOf(object);
    proxy->m_collisionFilterGroup = group;
    proxy->m_collisionFilterMask = mask;
    setAabb(proxy, lower, upper, dispatcher);
    return proxy;
  }
};

/// The number of a body is that of its handle, which would be the next free one.
template <typename Sweep>
class NumberedSweep final : public Sweep {
 public:
  using Sweep::Sweep;
  btBroadphaseProxy* createProxy(const btVector3& lower, const btVector3& upper, int shape_type,
                                 void* object, int group, int mask,
                                 btDispatcher* dispatcher) override {
    this->m_firstFreeHandle = static_cast<decltype(this->m_firstFreeHandle)>(NumberOf(object));
    return Sweep::createProxy(lower, upper, shape_type, object, group, mask, dispatcher);
  }
};

/// Walls have numbers beyond the objects, whether they stand or not.
constexpr std::size_t kWallNumbers = 6;

std::unique_ptr<btBroadphaseInterface> MakeNumbered(const BroadPhaseOptions& options) {
  const std::size_t capacity = options.bodies + kWallNumbers;
  if (options.detector == "dbvt") return std::make_unique<NumberedTree>();
  if (options.detector == "simple")
    return std::make_unique<NumberedSimple>(static_cast<int>(capacity));
  if (options.detector == "sap")
    return std::make_unique<NumberedSweep<btAxisSweep3>>(options.lower, options.upper,
                                                         static_cast<unsigned short>(capacity),
                                                         nullptr, !options.raycast_tree);
  return std::make_unique<NumberedSweep<bt32BitAxisSweep3>>(options.lower, options.upper,
                                                            static_cast<unsigned>(capacity),
                                                            nullptr, !options.raycast_tree);
}

}  // namespace

std::unique_ptr<btBroadphaseInterface> MakeBroadPhase(const BroadPhaseOptions& options) {
  const schema::DetectorInfo* info = schema::FindDetector(options.detector);
  if (info != nullptr) CheckHolds(options.detector, info->max_bodies, options.bodies);
  if (info != nullptr && options.numbers_bodies) return MakeNumbered(options);
  // All of them write past their arrays when a body comes too many.
  const auto capacity = static_cast<unsigned>(std::max<std::size_t>(options.bodies, 1));
  if (options.detector == "dbvt") return std::make_unique<btDbvtBroadphase>();
  if (options.detector == "simple")
    return std::make_unique<btSimpleBroadphase>(static_cast<int>(capacity));
  if (options.detector == "sap")
    return std::make_unique<btAxisSweep3>(options.lower, options.upper,
                                          static_cast<unsigned short>(capacity), nullptr,
                                          !options.raycast_tree);
  if (options.detector == "sap32")
    return std::make_unique<bt32BitAxisSweep3>(options.lower, options.upper, capacity, nullptr,
                                               !options.raycast_tree);
  throw library::SceneError(
      fmt::format("detector `{}` does not exist in this version", options.detector));
}

}  // namespace cdb::detection
