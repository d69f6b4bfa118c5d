#include "runtime/engine/worker/contact_reuse.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "dsl/text/check.h"

namespace cdb::worker {
namespace {

/// Stored in a body's second user index, the only data that Bullet's callback can read.
enum : int { kStays = 0, kMoved = 1 };

bool HasMoved(const btBroadphaseProxy& proxy) {
  return static_cast<const btCollisionObject*>(proxy.m_clientObject)->getUserIndex2() == kMoved;
}

void FindContactsOfMoved(btBroadphasePair& pair, btCollisionDispatcher& dispatcher,
                         const btDispatcherInfo& info) {
  if (pair.m_algorithm == nullptr || HasMoved(*pair.m_pProxy0) || HasMoved(*pair.m_pProxy1))
    return btCollisionDispatcher::defaultNearCallback(pair, dispatcher, info);
  thread_local btManifoldArray manifolds;  // keeps its memory between calls
  manifolds.resizeNoInitialize(0);
  pair.m_algorithm->getAllContactManifolds(manifolds);
  for (int i = 0; i < manifolds.size(); ++i)
    manifolds[i]->refreshContactPoints(manifolds[i]->getBody0()->getWorldTransform(),
                                       manifolds[i]->getBody1()->getWorldTransform());
}

}  // namespace

double Displacement(const btTransform& from, const btTransform& to, double radius) {
  btScalar squares = 0;
  for (int row = 0; row < 3; ++row)
    squares += (to.getBasis()[row] - from.getBasis()[row]).length2();
  // A rotation by the angle a changes the matrix by 2 sqrt(2) sin(a/2), whatever its axis.
  const double turn = std::sqrt(static_cast<double>(squares)) / std::numbers::sqrt2;
  return static_cast<double>((to.getOrigin() - from.getOrigin()).length()) + radius * turn;
}

ContactReuse::ContactReuse(world::Engine& engine, std::vector<Body> bodies)
    : engine_(engine), bodies_(std::move(bodies)) {
  CDB_CHECK(bodies_.size() == engine_.objects().size());
  for (const auto& body : engine_.objects()) counted_.push_back(body->getWorldTransform());
  static_cast<btCollisionDispatcher*>(engine_.world().getDispatcher())
      ->setNearCallback(FindContactsOfMoved);
}

void ContactReuse::BeforeStep() {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    btRigidBody& body = *engine_.objects()[i];
    if (body.isStaticOrKinematicObject()) continue;
    const btTransform& pose = body.getWorldTransform();
    const bool has_moved =
        !(Displacement(counted_[i], pose, bodies_[i].radius) <= bodies_[i].tolerance);
    if (has_moved) counted_[i] = pose;
    body.setUserIndex2(has_moved ? kMoved : kStays);
  }
}

}  // namespace cdb::worker
