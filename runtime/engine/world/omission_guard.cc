#include "runtime/engine/world/omission_guard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/engine/world/manifolds.h"

namespace cdb::world {
namespace {

using schema::Component;

/// Below this distance from a wall, a contact is made (btPersistentManifold's breaking threshold).
btScalar TouchingDistance(const btRigidBody& body) {
  return body.getCollisionShape()->getContactBreakingThreshold(gContactBreakingThreshold);
}

/// The extent of the body along the unit vector, from the origin, computed as in Bullet's test
/// before it makes a contact with a plane. A bounding box can be much larger.
btScalar FarthestAlong(const btRigidBody& body, const btVector3& direction) {
  const btTransform& pose = body.getWorldTransform();
  const btVector3 local = direction * pose.getBasis();
  return direction.dot(pose.getOrigin()) +
         local.dot(FarthestPoint(*body.getCollisionShape(), local));
}

/// Bound of the rounding errors in the positions of a wall and an object, and in the distance that
/// Bullet computes from them.
btScalar Rounding(btScalar half_side) {
  return 16 * half_side * std::numeric_limits<btScalar>::epsilon();
}

}  // namespace

OmissionGuard::OmissionGuard(Engine& engine)
    : engine_(engine),
      is_set_(engine.omissions().Omits(Component::kWalls)),
      watches_sleepers_(engine.detector() == "dbvt" &&
                        !engine.omissions().Omits(Component::kSleeping)) {
  if (!is_set_) return;
  constexpr btScalar kAnywhere = std::numeric_limits<btScalar>::infinity();
  const auto half = static_cast<btScalar>(engine.side() / 2);
  for (std::size_t i = 0; i < engine.objects().size(); ++i) {
    const btRigidBody& body = *engine.objects()[i];
    const btScalar reach =
        body.getCollisionShape()->getAngularMotionDisc() + TouchingDistance(body) + Rounding(half);
    Room room;
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<std::size_t>(axis);
      // Bullet makes no contact between two fixed bodies.
      const auto is_free = [&](int wall) {
        return body.isStaticOrKinematicObject() || !engine.IsWithoutWall(i, wall);
      };
      room.lower[at] = is_free(2 * axis) ? -kAnywhere : reach - half;
      room.upper[at] = is_free(2 * axis + 1) ? kAnywhere : half - reach;
    }
    rooms_.push_back(room);
  }
  touches_.resize(engine.objects().size());
  has_met_.resize(engine.objects().size());
}

void OmissionGuard::CheckWalls() const {
  for (std::size_t i = 0; i < rooms_.size(); ++i) {
    const btVector3& centre = engine_.objects()[i]->getWorldTransform().getOrigin();
    const Room& room = rooms_[i];
    bool is_inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      is_inside = is_inside && centre[static_cast<int>(axis)] >= room.lower[axis] &&
                  centre[static_cast<int>(axis)] <= room.upper[axis];
    if (!is_inside) CheckOutside(i);
  }
}

void OmissionGuard::CheckOutside(std::size_t object) const {
  const btRigidBody& body = *engine_.objects()[object];
  const auto half = static_cast<btScalar>(engine_.side() / 2);
  const btScalar limit = half - TouchingDistance(body) - Rounding(half);
  for (int wall = 0; wall < omissions::kWallCount; ++wall) {
    if (!engine_.IsWithoutWall(object, wall)) continue;
    btVector3 outward(0, 0, 0);
    outward[wall / 2] = static_cast<btScalar>(wall % 2 == 0 ? -1 : 1);
    if (!(FarthestAlong(body, outward) < limit))
      throw OmissionGuardTripped(
          fmt::format("object {} came close to the wall {}, which it was proven not to reach",
                      object + 1, omissions::kWallNames[wall]));
  }
}

void OmissionGuard::CheckOrder() {
  std::ranges::fill(touches_, 0);
  for (const btPersistentManifold& manifold : TouchingManifolds(engine_.world())) {
    for (const btCollisionObject* body : {manifold.getBody0(), manifold.getBody1()}) {
      if (body->isStaticOrKinematicObject()) continue;
      char& touches = touches_[static_cast<std::size_t>(body->getUserIndex())];
      if (touches != 0)
        throw OmissionGuardTripped(
            fmt::format("object {} was in two contacts at once, and their order could change",
                        body->getUserIndex() + 1));
      touches = 1;
    }
  }
  if (watches_sleepers_) CheckSleepers();
}

void OmissionGuard::CheckSleepers() {
  btOverlappingPairCache& pairs = *engine_.world().getPairCache();
  const btBroadphasePair* pair = pairs.getOverlappingPairArrayPtr();
  for (int i = 0; i < pairs.getNumOverlappingPairs(); ++i, ++pair) {
    const auto* a = static_cast<const btCollisionObject*>(pair->m_pProxy0->m_clientObject);
    const auto* b = static_cast<const btCollisionObject*>(pair->m_pProxy1->m_clientObject);
    if (a->isStaticOrKinematicObject() || b->isStaticOrKinematicObject()) continue;
    has_met_[static_cast<std::size_t>(a->getUserIndex())] = 1;
    has_met_[static_cast<std::size_t>(b->getUserIndex())] = 1;
  }
  for (std::size_t i = 0; i < has_met_.size(); ++i) {
    const int state = engine_.objects()[i]->getActivationState();
    if (has_met_[i] != 0 && (state == WANTS_DEACTIVATION || state == ISLAND_SLEEPING))
      throw OmissionGuardTripped(
          fmt::format("object {} came to rest after it had been near another", i + 1));
  }
}

}  // namespace cdb::world
