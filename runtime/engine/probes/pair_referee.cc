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

PairReferee::PairReferee(world::Engine& engine, measure::Recording& recording)
    : engine_(engine),
      adapter_(dynamic_cast<detection::AdapterBroadPhase*>(engine.world().getBroadphase())),
      detects_(!engine.omissions().Omits(schema::Component::kDetection)),
      exact_pairs_(recording.Ints("exact_pairs")),
      missed_pairs_(recording.Ints("missed_pairs")),
      false_positives_(recording.Ints("phantom_pairs")),
      duplicate_pairs_(recording.Ints("duplicate_pairs")),
      exact_contacts_(recording.Ints("exact_contacts")),
      missed_contacts_(recording.Ints("missed_contacts")),
      unsure_contacts_(recording.Ints("unsure_contacts")),
      depth_error_(recording.Reals("depth_error")),
      normal_error_(recording.Reals("normal_error")),
      boxes_(engine.objects().size() + pruning::kWallCount,
             {{kNone, kNone, kNone}, {kNone, kNone, kNone}}),
      filters_(boxes_.size()) {
  if (adapter_ != nullptr) adapter_->KeepList();
}

void PairReferee::BeforeStep() {
  // The detector runs before the bodies are moved.
  if (detects_) contacts_ = ExactOverlaps(engine_, ExactPairs(engine_));
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
  exact_pairs_[cycle] = static_cast<std::int32_t>(faults.exact);
  missed_pairs_[cycle] = static_cast<std::int32_t>(faults.missed);
  false_positives_[cycle] = static_cast<std::int32_t>(faults.false_positives);
  duplicate_pairs_[cycle] = static_cast<std::int32_t>(faults.duplicate);
}

void PairReferee::JudgeContacts(std::uint64_t cycle) {
  const NarrowPhaseErrors errors = CompareContacts(engine_, contacts_.overlaps);
  exact_contacts_[cycle] = static_cast<std::int32_t>(contacts_.overlaps.size());
  unsure_contacts_[cycle] = static_cast<std::int32_t>(contacts_.unsure);
  missed_contacts_[cycle] = static_cast<std::int32_t>(errors.missed);
  const double found = static_cast<double>(contacts_.overlaps.size()) - errors.missed;
  if (found > 0) depth_error_[cycle] = errors.depth_sum / found;
  if (errors.normals > 0) normal_error_[cycle] = errors.normal_sum / errors.normals;
}

}  // namespace cdb::probes
