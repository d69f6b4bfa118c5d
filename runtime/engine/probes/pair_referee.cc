#include "runtime/engine/probes/pair_referee.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "library/distributions/stream.h"
#include "library/objects/distance.h"
#include "runtime/engine/detection/adapter_dispatcher.h"
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

void RecordPairFaults(const Scene& scene, std::vector<Pair> listed, std::uint64_t cycle,
                      protocol::Recording& recording, const detectors::PairFilter& asked,
                      const detectors::PairFilter& collides) {
  std::erase_if(listed, [&](const Pair& pair) {
    return !scene.MayCollide(pair.a, pair.b) || (asked && !asked(pair));
  });
  std::ranges::sort(listed);
  const std::vector<Pair> exact = detectors::ExactPairs(scene, asked);
  const detectors::PairFaults faults = detectors::ComparePairs(exact, listed);
  const auto put = [&](schema::IntSeries series, std::size_t count) {
    constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
    recording.Put(series, cycle, static_cast<std::int32_t>(std::min(count, kMost)));
  };
  if (collides) {
    std::size_t collisions = 0, missed = 0;
    for (const Pair& pair : exact) {
      if (!collides(pair)) continue;
      ++collisions;
      missed += !std::ranges::binary_search(listed, pair);
    }
    put("exact_collisions", collisions);
    put("missed_collisions", missed);
  }
  put("exact_pairs", faults.exact);
  put("missed_pairs", faults.missed);
  put("phantom_pairs", faults.false_positives);
  put("duplicate_pairs", faults.duplicate);
  if (faults.first_missed && recording.header().message.str().empty())
    recording.header().message = fmt::format("pair missed in cycle {}: {}", cycle,
                                             detectors::OverlapText(scene, *faults.first_missed));
}

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
  if (detects_)
    contacts_ = ExactOverlaps(engine_, WithWalls(engine_, ExactPairs(engine_)), steps_++);
}

void PairReferee::AfterStep(std::uint64_t cycle) {
  if (!detects_) return;
  JudgePairs(cycle);
  JudgeContacts(engine_, contacts_, recording_, cycle);
}

/// Boxes do not change between the broad phase and the end of the step.
void PairReferee::ReadBoxes() {
  const auto read = [&](const btRigidBody& body) {
    btBroadphaseProxy* proxy = const_cast<btBroadphaseProxy*>(body.getBroadphaseHandle());
    const auto id = static_cast<Id>(body.getUserIndex());
    if (proxy == nullptr) {
      boxes_[id] = {{kNone, kNone, kNone}, {kNone, kNone, kNone}};
      return;
    }
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
  RecordPairFaults(scene, ListedPairs(), cycle, recording_);
}

namespace {

using Eigen::Vector3d;

/// Normals are equivalent if their depths differ by at most this fraction.
constexpr double kTie = 0.01;

/// Bodies whose depth is to be computed.
struct Candidate {
  BodyPair bodies;
  double size;  ///< m, of the smaller object
  objects::Solid a, b;
  objects::Pose pose_a, pose_b;
};

/// Leaves those that may overlap, and of these at most so many, drawn at random. The others are
/// added to `uncompared`.
void Draw(std::vector<Candidate>& candidates, std::uint64_t draw, std::size_t most,
          std::vector<BodyPair>& uncompared) {
  if (candidates.size() <= most) return;
  std::erase_if(candidates, [](const Candidate& of) {
    return !objects::Overlap(of.a, of.pose_a, of.b, of.pose_b);
  });
  if (candidates.size() <= most) return;
  distributions::Stream stream(draw);
  for (std::size_t i = 0; i < most; ++i) {
    const double rest = static_cast<double>(candidates.size() - i);
    std::swap(candidates[i], candidates[i + static_cast<std::size_t>(rest * stream.Uniform())]);
  }
  for (std::size_t i = most; i < candidates.size(); ++i) uncompared.push_back(candidates[i].bodies);
  candidates.resize(most);
}

/// Null if the two do not overlap, or are not known to.
ExactOverlap* Add(const BodyPair& bodies, double size, const exact::SignedDistance& distance,
                  ExactContacts& contacts) {
  if (-distance.lower <= kLeastOverlap * size) {
    contacts.touching += distance.lower < 0;
    return nullptr;
  }
  if (!distance.IsTight(size)) {
    contacts.uncompared.push_back(bodies);
    return nullptr;
  }
  return &contacts.overlaps.emplace_back(
      ExactOverlap{bodies, distance.Depth(), distance.normal, true, size});
}

void Compute(const Candidate& of, ExactContacts& contacts) {
  const exact::SignedDistance distance = exact::DistanceOf(of.a, of.pose_a, of.b, of.pose_b, 0);
  if (distance.is_inside) {
    contacts.overlaps.push_back({of.bodies, 0, Vector3d::UnitY(), false, of.size, true});
    return;
  }
  if (ExactOverlap* overlap = Add(of.bodies, of.size, distance, contacts))
    overlap->has_one_normal = exact::HasOneNormal(of.a, of.pose_a, of.b, of.pose_b, distance, kTie);
}

const btRigidBody& WallOf(const world::Engine& engine, std::uint32_t index) {
  return **std::ranges::find(engine.walls(), static_cast<int>(index),
                             [](const auto& wall) { return wall->getUserIndex(); });
}

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
    if (!engine.IsPresent(i)) continue;
    const objects::Pose pose = world::ExactPose(*engine.objects()[i]);
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

std::vector<BodyPair> WithWalls(const world::Engine& engine, std::vector<BodyPair> pairs) {
  const auto& objects = engine.initial_state().objects;
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    if (!engine.IsPresent(i) || objects[i].IsFixed() || !engine.MayTouchWalls(i)) continue;
    for (const auto& wall : engine.walls()) {
      const auto index = static_cast<std::uint32_t>(wall->getUserIndex());
      if (!engine.IsWithoutWall(i, static_cast<int>(index - objects.size())))
        pairs.emplace_back(i, index);
    }
  }
  return pairs;
}

ExactContacts ExactOverlaps(const world::Engine& engine, const std::vector<BodyPair>& pairs,
                            std::uint64_t draw, std::size_t most) {
  ExactContacts contacts;
  std::vector<Candidate> candidates;
  const auto& objects = engine.initial_state().objects;
  const auto size_of = [&](std::uint32_t object) { return objects[object].solid.sides.maxCoeff(); };
  for (const auto& [first, second] : pairs) {
    const btRigidBody& a = *engine.objects()[first];
    if (second >= objects.size()) {
      const btRigidBody& wall = WallOf(engine, second);
      const objects::Pose pose = world::ExactPose(a);
      if (const auto plane = world::PlaneOf(wall))
        Add({first, second}, size_of(first), exact::DistanceOf(objects[first].solid, pose, *plane),
            contacts);
      else
        candidates.push_back({{first, second},
                              size_of(first),
                              objects[first].solid,
                              world::BoxWallSolid(wall),
                              pose,
                              world::ExactPose(wall)});
      continue;
    }
    const btRigidBody& b = *engine.objects()[second];
    // Linked objects may pass through each other.
    if (!a.checkCollideWith(&b)) continue;
    candidates.push_back({{first, second},
                          std::min(size_of(first), size_of(second)),
                          objects[first].solid,
                          objects[second].solid,
                          world::ExactPose(a),
                          world::ExactPose(b)});
  }
  Draw(candidates, draw, most, contacts.uncompared);
  for (const Candidate& candidate : candidates) Compute(candidate, contacts);
  std::ranges::sort(contacts.overlaps, {}, &ExactOverlap::bodies);
  std::ranges::sort(contacts.uncompared);
  return contacts;
}

ContactMaker ContactMakerOf(world::Engine& engine, const BodyPair& bodies) {
  const auto proxy = [&](std::uint32_t index) {
    const auto objects = engine.objects().size();
    return const_cast<btBroadphaseProxy*>(
        (index < objects ? *engine.objects()[index] : WallOf(engine, index)).getBroadphaseHandle());
  };
  const btBroadphasePair* pair =
      engine.world().getPairCache()->findPair(proxy(bodies.first), proxy(bodies.second));
  if (pair == nullptr) return ContactMaker::kNone;
  return detection::AdapterDispatcher::IsDetectors(*pair) ? ContactMaker::kDetector
                                                          : ContactMaker::kBullet;
}

namespace {

/// The deepest point of a pair.
struct Found {
  double depth = -std::numeric_limits<double>::infinity();
  Vector3d normal = Vector3d::Zero();  ///< from the second body to the first
};

void AddError(const ExactOverlap& exact, const Found& found, NarrowPhaseErrors& errors) {
  const double depth = std::fabs(found.depth - exact.depth) / exact.size;
  errors.depth_sum += depth;
  errors.depth_max = std::max(errors.depth_max, depth);
  if (!exact.has_one_normal) return;
  // The sine is accurate for small angles, the cosine for large ones.
  const double angle =
      std::atan2(found.normal.cross(exact.normal).norm(), found.normal.dot(exact.normal));
  errors.normal_sum += angle;
  errors.normal_max = std::max(errors.normal_max, angle);
  ++errors.normals;
}

/// m, of the smaller object; walls have none.
double SizeOf(const world::Engine& engine, const BodyPair& bodies) {
  const auto& objects = engine.initial_state().objects;
  const double first = objects[bodies.first].solid.sides.maxCoeff();
  return bodies.second < objects.size()
             ? std::min(first, objects[bodies.second].solid.sides.maxCoeff())
             : first;
}

}  // namespace

NarrowPhaseErrors CompareContacts(world::Engine& engine, const ExactContacts& exact) {
  const std::vector<ExactOverlap>& overlaps = exact.overlaps;
  std::vector<Found> founds(overlaps.size());
  std::vector<BodyPair> others;  // in contact, and not known to overlap
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine.world())) {
    const auto body0 = static_cast<std::uint32_t>(manifold.getBody0()->getUserIndex());
    const auto body1 = static_cast<std::uint32_t>(manifold.getBody1()->getUserIndex());
    const BodyPair bodies = std::minmax(body0, body1);
    Found deepest;
    for (int j = 0; j < manifold.getNumContacts(); ++j) {
      const btManifoldPoint& point = manifold.getContactPoint(j);
      const double depth = -static_cast<double>(point.getDistance());
      // Bullet's normal points from the second body to the first.
      if (depth > deepest.depth)
        deepest = {depth, (body0 < body1 ? 1 : -1) * world::ToEigen(point.m_normalWorldOnB)};
    }
    const auto overlap = std::ranges::lower_bound(overlaps, bodies, {}, &ExactOverlap::bodies);
    if (overlap == overlaps.end() || overlap->bodies != bodies) {
      if (deepest.depth >= kLeastFalse * SizeOf(engine, bodies)) others.push_back(bodies);
      continue;
    }
    Found& found = founds[static_cast<std::size_t>(overlap - overlaps.begin())];
    if (deepest.depth > found.depth) found = deepest;
  }
  NarrowPhaseErrors errors;
  // A compound may have several manifolds.
  std::ranges::sort(others);
  others.erase(std::unique(others.begin(), others.end()), others.end());
  errors.false_ = static_cast<double>(std::ranges::count_if(others, [&](const BodyPair& bodies) {
    return !std::ranges::binary_search(exact.uncompared, bodies);
  }));
  for (std::size_t i = 0; i < overlaps.size(); ++i) {
    const bool is_missed = std::isinf(founds[i].depth);
    const ContactMaker maker = ContactMakerOf(engine, overlaps[i].bodies);
    errors.missed += is_missed;
    errors.unlisted += is_missed && maker == ContactMaker::kNone;
    errors.bullet += maker == ContactMaker::kBullet;
    errors.bullet_missed += is_missed && maker == ContactMaker::kBullet;
    if (is_missed) continue;
    if (overlaps[i].is_inside)
      ++errors.unknown;
    else
      AddError(overlaps[i], founds[i], errors);
  }
  return errors;
}

void JudgeContacts(world::Engine& engine, const ExactContacts& exact,
                   protocol::Recording& recording, std::uint64_t cycle) {
  const NarrowPhaseErrors errors = CompareContacts(engine, exact);
  const auto of_bullet =
      std::ranges::count(exact.uncompared, ContactMaker::kBullet,
                         [&](const BodyPair& bodies) { return ContactMakerOf(engine, bodies); });
  const auto put = [&](schema::IntSeries series, auto count) {
    recording.Put(series, cycle, static_cast<std::int32_t>(count));
  };
  put("exact_contacts", exact.overlaps.size());
  put("uncompared_contacts", exact.uncompared.size());
  put("missed_contacts", errors.missed);
  put("unlisted_contacts", errors.unlisted);
  put("bullet_contacts", errors.bullet);
  put("bullet_missed_contacts", errors.bullet_missed);
  put("bullet_uncompared_contacts", of_bullet);
  put("false_contacts", errors.false_);
  const double found = static_cast<double>(exact.overlaps.size()) - errors.missed - errors.unknown;
  if (found > 0) {
    recording.Put("depth_error", cycle, errors.depth_sum / found);
    recording.Put("max_depth_error", cycle, errors.depth_max);
  }
  if (errors.normals > 0) {
    recording.Put("normal_error", cycle, errors.normal_sum / errors.normals);
    recording.Put("max_normal_error", cycle, errors.normal_max);
  }
}

}  // namespace cdb::probes
