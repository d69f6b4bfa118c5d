#include "runtime/engine/probes/exact_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::probes {
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

/// Judges pairs of bodies and collects the overlaps.
class Judge {
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
  /// Null if the two are no overlap.
  ExactOverlap* Add(const BodyPair& bodies, double size, const exact::SignedDistance& distance) {
    if (-distance.lower <= kLeastOverlap * size) return nullptr;
    if (!distance.IsTight(size)) {
      ++contacts_.unsure;
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
  Judge judge;
  const auto& objects = engine.initial_state().objects;
  const auto size_of = [&](std::uint32_t object) { return objects[object].solid.sides.maxCoeff(); };
  for (const auto& [first, second] : pairs) {
    const btRigidBody &a = *engine.objects()[first], &b = *engine.objects()[second];
    // Linked objects may pass through each other.
    if (!a.checkCollideWith(&b)) continue;
    judge.Add({first, second}, std::min(size_of(first), size_of(second)), objects[first].solid,
              PoseOf(a), objects[second].solid, PoseOf(b));
  }
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    if (objects[i].IsFixed() || !engine.MayTouchWalls(i)) continue;
    const objects::Pose pose = PoseOf(*engine.objects()[i]);
    for (const auto& wall : engine.walls()) {
      const auto index = static_cast<std::uint32_t>(wall->getUserIndex());
      if (engine.IsWithoutWall(i, static_cast<int>(index - objects.size()))) continue;
      judge.AddWall({i, index}, size_of(i), objects[i].solid, pose, *wall);
    }
  }
  return judge.Finish();
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
