#include "runtime/engine/probes/pair_referee.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cdb::probes {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Replaces Bullet's value for an infinite side.
double Side(btScalar value) {
  if (std::abs(value) < BT_LARGE_FLOAT) return static_cast<double>(value);
  return std::copysign(std::numeric_limits<double>::infinity(), static_cast<double>(value));
}

Vec3 Corner(const btVector3& corner) {
  return {Side(corner.x()), Side(corner.y()), Side(corner.z())};
}

Id IdOf(const btBroadphaseProxy* proxy) {
  return static_cast<Id>(
      static_cast<const btCollisionObject*>(proxy->m_clientObject)->getUserIndex());
}

}  // namespace

PairReferee::PairReferee(world::Engine& engine, protocol::Recording& recording)
    : engine_(engine),
      adapter_(dynamic_cast<detection::AdapterBroadPhase*>(engine.world().getBroadphase())),
      detects_(!engine.omissions().Omits(schema::Component::kDetection)),
      recording_(recording),
      boxes_(engine.objects().size() + omissions::kWallCount,
             {{kNone, kNone, kNone}, {kNone, kNone, kNone}}),
      filters_(boxes_.size()) {
  if (adapter_ != nullptr) adapter_->KeepList();
}

void PairReferee::BeforeStep() {
  // The detector runs before the bodies are moved.
  if (detects_) overlaps_ = ExactOverlaps(engine_, ExactPairs(engine_));
}

void PairReferee::AfterStep(std::uint64_t cycle) {
  if (!detects_) return;
  JudgePairs(cycle);
  JudgeContacts(cycle);
}

/// Boxes do not change between the broad phase and the end of the step.
void PairReferee::ReadBoxes() {
  const auto read = [&](const btRigidBody& body) {
    btBroadphaseProxy* proxy = const_cast<btBroadphaseProxy*>(body.getBroadphaseHandle());
    if (proxy == nullptr) return;
    const Id id = IdOf(proxy);
    btVector3 lower, upper;
    engine_.world().getBroadphase()->getAabb(proxy, lower, upper);
    boxes_[id] = {Corner(lower), Corner(upper)};
    filters_[id] = {static_cast<std::uint32_t>(proxy->m_collisionFilterGroup),
                    static_cast<std::uint32_t>(proxy->m_collisionFilterMask),
                    body.isStaticOrKinematicObject()};
  };
  for (const auto& body : engine_.objects()) read(*body);
  for (const auto& wall : engine_.walls()) read(*wall);
}

std::vector<Pair> PairReferee::ListedPairs() const {
  std::vector<Pair> pairs;
  if (adapter_ != nullptr) {
    const auto index = [&](Id id) {
      return static_cast<Id>(engine_.scene_view()->body(id).getUserIndex());
    };
    for (const Pair& pair : adapter_->list()) {
      const auto [a, b] = std::minmax({index(pair.a), index(pair.b)});
      pairs.push_back({a, b});
    }
    return pairs;
  }
  btOverlappingPairCache& cache = *engine_.world().getPairCache();
  const std::span listed(cache.getOverlappingPairArrayPtr(),
                         static_cast<std::size_t>(cache.getNumOverlappingPairs()));
  pairs.reserve(listed.size());
  for (const btBroadphasePair& pair : listed) {
    const auto [a, b] = std::minmax({IdOf(pair.m_pProxy0), IdOf(pair.m_pProxy1)});
    pairs.push_back({a, b});
  }
  return pairs;
}

void PairReferee::JudgePairs(std::uint64_t cycle) {
  ReadBoxes();
  Scene scene;
  scene.size = boxes_.size();
  scene.boxes = boxes_;
  scene.filters = filters_;
  const detectors::PairFaults faults = detectors::ComparePairs(scene, ListedPairs());
  recording_.Put("exact_pairs", cycle, static_cast<std::int32_t>(faults.exact));
  recording_.Put("missed_pairs", cycle, static_cast<std::int32_t>(faults.missed));
  recording_.Put("phantom_pairs", cycle, static_cast<std::int32_t>(faults.false_positives));
  recording_.Put("duplicate_pairs", cycle, static_cast<std::int32_t>(faults.duplicate));
}

void PairReferee::JudgeContacts(std::uint64_t cycle) {
  const NarrowPhaseErrors errors = CompareContacts(engine_, overlaps_);
  recording_.Put("missed_contacts", cycle, static_cast<std::int32_t>(errors.missed));
  const double found = static_cast<double>(overlaps_.size()) - errors.missed;
  if (found > 0) recording_.Put("depth_error", cycle, errors.depth_sum / found);
  if (errors.normals > 0) recording_.Put("normal_error", cycle, errors.normal_sum / errors.normals);
}

}  // namespace cdb::probes
