#include "runtime/engine/probes/exact_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;
using objects::Penetration;

/// Two directions of separation are equivalent if their depths differ by at most this fraction.
constexpr double kTie = 0.01;

/// The pose in the engine, converted to a quaternion in double precision.
objects::Pose PoseOf(const btRigidBody& body) {
  const btTransform& transform = body.getWorldTransform();
  Eigen::Matrix3d turn;
  for (int row = 0; row < 3; ++row) turn.row(row) = world::ToEigen(transform.getBasis()[row]);
  return {world::ToEigen(transform.getOrigin()), Eigen::Quaterniond(turn).normalized()};
}

/// The walls have the shapes made by MakeWall of the engine.
std::optional<Penetration> ContactWithWall(const objects::Solid& solid, const objects::Pose& pose,
                                           const btRigidBody& wall) {
  const btCollisionShape& shape = *wall.getCollisionShape();
  if (shape.getShapeType() == STATIC_PLANE_PROXYTYPE) {
    const Vector3d normal =
        world::ToEigen(static_cast<const btStaticPlaneShape&>(shape).getPlaneNormal());
    return objects::ExactContact(solid, pose, normal,
                                 normal.dot(world::ToEigen(wall.getWorldTransform().getOrigin())));
  }
  const auto& box = static_cast<const btBoxShape&>(shape);
  return objects::ExactContact(
      solid, pose,
      {objects::Shape::kCuboid, 2 * world::ToEigen(box.getHalfExtentsWithMargin()), nullptr},
      PoseOf(wall));
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

std::vector<ExactOverlap> ExactOverlaps(const world::Engine& engine,
                                        const std::vector<BodyPair>& pairs) {
  std::vector<ExactOverlap> overlaps;
  const auto& objects = engine.initial_state().objects;
  const auto add = [&](const BodyPair& bodies, const std::optional<Penetration>& contact,
                       double size) {
    if (contact && contact->depth > kLeastOverlap * size)
      overlaps.push_back({bodies, *contact, size});
  };
  const auto size_of = [&](std::uint32_t object) { return objects[object].solid.sides.maxCoeff(); };
  for (const auto& [first, second] : pairs) {
    const btRigidBody &a = *engine.objects()[first], &b = *engine.objects()[second];
    // Linked objects may pass through each other.
    if (!a.checkCollideWith(&b)) continue;
    add({first, second},
        objects::ExactContact(objects[first].solid, PoseOf(a), objects[second].solid, PoseOf(b)),
        std::min(size_of(first), size_of(second)));
  }
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    if (objects[i].IsFixed() || !engine.MayTouchWalls(i)) continue;
    const objects::Pose pose = PoseOf(*engine.objects()[i]);
    for (const auto& wall : engine.walls()) {
      const auto index = static_cast<std::uint32_t>(wall->getUserIndex());
      if (engine.IsWithoutWall(i, static_cast<int>(index - objects.size()))) continue;
      add({i, index}, ContactWithWall(objects[i].solid, pose, *wall), size_of(i));
    }
  }
  std::ranges::sort(overlaps, {}, &ExactOverlap::bodies);
  return overlaps;
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
    const Penetration& exact = overlaps[i].contact;
    const Found& found = founds[i];
    if (std::isinf(found.depth)) {
      ++errors.missed;
      continue;
    }
    errors.depth_sum += std::fabs(found.depth - exact.depth) / overlaps[i].size;
    if (exact.next_depth <= (1 + kTie) * exact.depth) continue;
    // The sine is accurate for small angles, the cosine for large ones.
    errors.normal_sum +=
        std::atan2(found.normal.cross(exact.normal).norm(), found.normal.dot(exact.normal));
    ++errors.normals;
  }
  return errors;
}

}  // namespace cdb::probes
