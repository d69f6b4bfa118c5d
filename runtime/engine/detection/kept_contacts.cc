// Source: btManifoldResult::addContactPoint of Bullet 3.24.
#include "runtime/engine/detection/kept_contacts.h"

#include "dsl/text/check.h"
#include "library/detectors/bullet/vectors.h"

namespace cdb::detection {
namespace {

using bullet::ToBullet;

bool IsBall(const btCollisionObject& body) {
  return body.getCollisionShape()->getShapeType() == SPHERE_SHAPE_PROXYTYPE;
}

bool IsPlain(const btCollisionObject& body) {
  return (body.getCollisionFlags() & (btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK |
                                      btCollisionObject::CF_HAS_FRICTION_ANCHOR)) == 0;
}

}  // namespace

KeptContacts::KeptContacts(btDispatcher& dispatcher, const btCollisionObject& a,
                           const btCollisionObject& b)
    : manifold_(*dispatcher.getNewManifold(&a, &b)),
      are_balls_(IsBall(a) && IsBall(b)),
      is_plain_(IsPlain(a) && IsPlain(b)),
      material_(MaterialOf(&a, &b)) {
  m_dispatcher = &dispatcher;
}

KeptContacts::Material KeptContacts::MaterialOf(const btCollisionObject* a,
                                                const btCollisionObject* b) {
  Material material = {.friction = gCalculateCombinedFrictionCallback(a, b),
                       .restitution = gCalculateCombinedRestitutionCallback(a, b),
                       .rolling_friction = gCalculateCombinedRollingFrictionCallback(a, b),
                       .spinning_friction = gCalculateCombinedSpinningFrictionCallback(a, b),
                       .stiffness = 0,
                       .damping = 0,
                       .is_soft = ((a->getCollisionFlags() | b->getCollisionFlags()) &
                                   btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING) != 0};
  if (material.is_soft) {
    material.stiffness = gCalculateCombinedContactStiffnessCallback(a, b);
    material.damping = gCalculateCombinedContactDampingCallback(a, b);
  }
  return material;
}

void KeptContacts::processCollision(const btCollisionObjectWrapper*,
                                    const btCollisionObjectWrapper*, const btDispatcherInfo&,
                                    btManifoldResult*) {
  CDB_CHECK(false);  // AdapterDispatcher's, for all of them at once
}

/// The nearest point within the breaking threshold, whose place a new one takes; -1: none.
int KeptContacts::PlaceFor(const btVector3& local_a) const {
  const btScalar threshold = manifold_.getContactBreakingThreshold();
  btScalar least = threshold * threshold;
  int nearest = -1;
  for (int i = 0; i < manifold_.getNumContacts(); ++i) {
    const btVector3 difference = manifold_.getContactPoint(i).m_localPointA - local_a;
    const btScalar square = difference.dot(difference);
    if (square < least) least = square, nearest = i;
  }
  return nearest;
}

void KeptContacts::Add(std::span<const Contact> contacts) {
  if (contacts.empty()) return;
  if (!is_plain_) return AddByBullet(contacts);
  const btTransform &pose_a = manifold_.getBody0()->getWorldTransform(),
                    &pose_b = manifold_.getBody1()->getWorldTransform();
  const btScalar threshold = manifold_.getContactBreakingThreshold();
  const btVector3 none(0, 0, 0);
  btManifoldPoint point(none, none, none, 0);
  point.m_combinedFriction = material_.friction;
  point.m_combinedRestitution = material_.restitution;
  point.m_combinedRollingFriction = material_.rolling_friction;
  point.m_combinedSpinningFriction = material_.spinning_friction;
  if (material_.is_soft) {
    point.m_combinedContactStiffness1 = material_.stiffness;
    point.m_combinedContactDamping1 = material_.damping;
    point.m_contactPointFlags = BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
  }
  for (const Contact& contact : contacts) {
    const auto distance = static_cast<btScalar>(contact.distance);
    if (distance > threshold) continue;
    point.m_normalWorldOnB = ToBullet(contact.normal);
    point.m_positionWorldOnB = ToBullet(contact.on_b);
    point.m_positionWorldOnA = point.m_positionWorldOnB + point.m_normalWorldOnB * distance;
    point.m_localPointA = pose_a.invXform(point.m_positionWorldOnA);
    point.m_localPointB = pose_b.invXform(point.m_positionWorldOnB);
    point.m_distance1 = distance;
    const int place = PlaceFor(point.m_localPointA);
    if (place >= 0) {
      manifold_.replaceContactPoint(point, place);
    } else if (const int count = manifold_.getNumContacts(); count < MANIFOLD_CACHE_SIZE) {
      manifold_.setNumContacts(count + 1);
      manifold_.getContactPoint(count) = point;
    } else {
      manifold_.addManifoldPoint(point);
    }
  }
}

void KeptContacts::AddByBullet(std::span<const Contact> contacts) {
  const btCollisionObject *a = manifold_.getBody0(), *b = manifold_.getBody1();
  const btCollisionObjectWrapper first(nullptr, a->getCollisionShape(), a, a->getWorldTransform(),
                                       -1, -1),
      second(nullptr, b->getCollisionShape(), b, b->getWorldTransform(), -1, -1);
  btManifoldResult result(&first, &second);
  result.setPersistentManifold(&manifold_);
  for (const Contact& contact : contacts)
    result.addContactPoint(ToBullet(contact.normal), ToBullet(contact.on_b),
                           static_cast<btScalar>(contact.distance));
}

void KeptContacts::Refresh() {
  if (are_balls_ || manifold_.getNumContacts() == 0) return;
  manifold_.refreshContactPoints(manifold_.getBody0()->getWorldTransform(),
                                 manifold_.getBody1()->getWorldTransform());
}

}  // namespace cdb::detection
