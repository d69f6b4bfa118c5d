#include "runtime/engine/probes/pair_referee.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/manifolds.h"

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
  recording_.Put("exact_pairs", cycle, static_cast<std::int32_t>(faults.exact));
  recording_.Put("missed_pairs", cycle, static_cast<std::int32_t>(faults.missed));
  recording_.Put("phantom_pairs", cycle, static_cast<std::int32_t>(faults.false_positives));
  recording_.Put("duplicate_pairs", cycle, static_cast<std::int32_t>(faults.duplicate));
}

void PairReferee::JudgeContacts(std::uint64_t cycle) {
  const NarrowPhaseErrors errors = CompareContacts(engine_, contacts_.overlaps);
  recording_.Put("exact_contacts", cycle, static_cast<std::int32_t>(contacts_.overlaps.size()));
  recording_.Put("uncompared_contacts", cycle, static_cast<std::int32_t>(contacts_.uncompared));
  recording_.Put("missed_contacts", cycle, static_cast<std::int32_t>(errors.missed));
  const double found = static_cast<double>(contacts_.overlaps.size()) - errors.missed;
  if (found > 0) recording_.Put("depth_error", cycle, errors.depth_sum / found);
  if (errors.normals > 0) recording_.Put("normal_error", cycle, errors.normal_sum / errors.normals);
}

namespace {

using Eigen::Vector3d;

/// Normals are equivalent if their depths differ by at most this fraction.
constexpr double kTie = 0.01;

/// The pose in the engine, converted to a quaternion in double precision.
objects::Pose PoseOf(const btRigidBody& body) {
  const btTransform& transform = body.getWorldTransform();
  Eigen::Matrix3d turn;
  for (int row = 0; row < 3; ++row) turn.row(row) = world::ToEigen(transform.getBasis()[row]);
  return {world::ToEigen(transform.getOrigin()), Eigen::Quaterniond(turn).normalized()};
}

/// Measures pairs of bodies and collects the overlaps.
class OverlapCollector {
 public:
  void Add(const BodyPair& bodies, double size, const objects::Solid& a,
           const objects::Pose& pose_a, const objects::Solid& b, const objects::Pose& pose_b) {
    const exact::SignedDistance distance = exact::DistanceOf(a, pose_a, b, pose_b, 0);
    if (ExactOverlap* overlap = Add(bodies, size, distance))
      overlap->has_one_normal = exact::HasOneNormal(a, pose_a, b, pose_b, distance, kTie);
  }

  /// The walls have the shapes made by MakeWall of the engine.
  void AddWall(const BodyPair& bodies, double size, const objects::Solid& solid,
               const objects::Pose& pose, const btRigidBody& wall) {
    const btCollisionShape& shape = *wall.getCollisionShape();
    if (shape.getShapeType() == STATIC_PLANE_PROXYTYPE) {
      const Vector3d normal =
          world::ToEigen(static_cast<const btStaticPlaneShape&>(shape).getPlaneNormal());
      const double offset = normal.dot(world::ToEigen(wall.getWorldTransform().getOrigin()));
      Add(bodies, size, exact::DistanceOf(solid, pose, exact::HalfSpace{normal, offset}));
      return;
    }
    const auto& box = static_cast<const btBoxShape&>(shape);
    const Vector3d sides = 2 * world::ToEigen(box.getHalfExtentsWithMargin());
    Add(bodies, size, solid, pose, {objects::Shape::kCuboid, sides}, PoseOf(wall));
  }

  ExactContacts Finish() {
    std::ranges::sort(contacts_.overlaps, {}, &ExactOverlap::bodies);
    return std::move(contacts_);
  }

 private:
  /// Null if the two do not overlap, or are not known to.
  ExactOverlap* Add(const BodyPair& bodies, double size, const exact::SignedDistance& distance) {
    if (-distance.lower <= kLeastOverlap * size) return nullptr;
    if (!distance.IsTight(size)) {
      ++contacts_.uncompared;
      return nullptr;
    }
    return &contacts_.overlaps.emplace_back(
        ExactOverlap{bodies, distance.Depth(), distance.normal, true, size});
  }

  ExactContacts contacts_;
};

}  // namespace

std::vector<BodyPair> ExactPairs(const world::Engine& engine) {
  struct Row {
    objects::Box box;
    std::uint32_t object;
    bool is_fixed;
  };
  std::vector<Row> rows;
  const auto& objects = engine.initial_state().objects;
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    const objects::Pose pose = PoseOf(*engine.objects()[i]);
    objects::Box box = objects::Bounds(objects[i].solid, pose.orientation);
    box.lower += pose.position;
    box.upper += pose.position;
    rows.push_back({box, i, objects[i].IsFixed()});
  }
  // Rows are sorted along x: only neighbours can overlap.
  std::ranges::sort(rows, {}, [](const Row& row) { return row.box.lower.x(); });
  std::vector<BodyPair> pairs;
  for (auto a = rows.begin(); a != rows.end(); ++a) {
    for (auto b = a + 1; b != rows.end() && b->box.lower.x() <= a->box.upper.x(); ++b) {
      if ((a->is_fixed && b->is_fixed) || !engine.MayTouch(a->object, b->object)) continue;
      if ((a->box.lower.array() <= b->box.upper.array()).all() &&
          (b->box.lower.array() <= a->box.upper.array()).all())
        pairs.push_back(std::minmax(a->object, b->object));
    }
  }
  std::ranges::sort(pairs);
  return pairs;
}

ExactContacts ExactOverlaps(const world::Engine& engine, const std::vector<BodyPair>& pairs) {
  OverlapCollector collector;
  const auto& objects = engine.initial_state().objects;
  const auto size_of = [&](std::uint32_t object) { return objects[object].solid.sides.maxCoeff(); };
  for (const auto& [first, second] : pairs) {
    const btRigidBody &a = *engine.objects()[first], &b = *engine.objects()[second];
    // Linked objects may pass through each other.
    if (!a.checkCollideWith(&b)) continue;
    collector.Add({first, second}, std::min(size_of(first), size_of(second)), objects[first].solid,
                  PoseOf(a), objects[second].solid, PoseOf(b));
  }
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    if (objects[i].IsFixed() || !engine.MayTouchWalls(i)) continue;
    const objects::Pose pose = PoseOf(*engine.objects()[i]);
    for (const auto& wall : engine.walls()) {
      const auto index = static_cast<std::uint32_t>(wall->getUserIndex());
      if (engine.IsWithoutWall(i, static_cast<int>(index - objects.size()))) continue;
      collector.AddWall({i, index}, size_of(i), objects[i].solid, pose, *wall);
    }
  }
  return collector.Finish();
}

NarrowPhaseErrors CompareContacts(world::Engine& engine,
                                  const std::vector<ExactOverlap>& overlaps) {
  struct Found {
    double depth = -std::numeric_limits<double>::infinity();
    Vector3d normal;
  };
  std::vector<Found> founds(overlaps.size());
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine.world())) {
    const auto body0 = static_cast<std::uint32_t>(manifold.getBody0()->getUserIndex());
    const auto body1 = static_cast<std::uint32_t>(manifold.getBody1()->getUserIndex());
    const BodyPair bodies = std::minmax(body0, body1);
    const auto overlap = std::ranges::lower_bound(overlaps, bodies, {}, &ExactOverlap::bodies);
    if (overlap == overlaps.end() || overlap->bodies != bodies) continue;
    Found& found = founds[static_cast<std::size_t>(overlap - overlaps.begin())];
    for (int j = 0; j < manifold.getNumContacts(); ++j) {
      const btManifoldPoint& point = manifold.getContactPoint(j);
      const double depth = -static_cast<double>(point.getDistance());
      // Bullet's normal points from the second body to the first.
      if (depth > found.depth)
        found = {depth, (body0 < body1 ? 1 : -1) * world::ToEigen(point.m_normalWorldOnB)};
    }
  }
  NarrowPhaseErrors errors;
  for (std::size_t i = 0; i < overlaps.size(); ++i) {
    const ExactOverlap& exact = overlaps[i];
    const Found& found = founds[i];
    if (std::isinf(found.depth)) {
      ++errors.missed;
      continue;
    }
    errors.depth_sum += std::fabs(found.depth - exact.depth) / exact.size;
    if (!exact.has_one_normal) continue;
    // The sine is accurate for small angles, the cosine for large ones.
    errors.normal_sum +=
        std::atan2(found.normal.cross(exact.normal).norm(), found.normal.dot(exact.normal));
    ++errors.normals;
  }
  return errors;
}

}  // namespace cdb::probes
