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

/// What the solver keeps in a point of the last cycle.
struct Earlier {
  btVector3 local_a = {BT_LARGE_FLOAT, 0, 0};
  btScalar impulse = 0, right_side = 0, lateral_1 = 0, lateral_2 = 0;
  int lifetime = 0;

  Earlier() = default;
  explicit Earlier(const btManifoldPoint& point)
      : local_a(point.m_localPointA),
        impulse(point.m_appliedImpulse),
        right_side(point.m_prevRHS),
        lateral_1(point.m_appliedImpulseLateral1),
        lateral_2(point.m_appliedImpulseLateral2),
        lifetime(point.m_lifeTime) {}
  /// Once: an impulse is applied at one point.
  void GiveTo(btManifoldPoint& point) {
    point.m_appliedImpulse = impulse;
    point.m_prevRHS = right_side;
    point.m_appliedImpulseLateral1 = lateral_1;
    point.m_appliedImpulseLateral2 = lateral_2;
    point.m_lifeTime = lifetime + 1;
    local_a.setX(BT_LARGE_FLOAT);
  }
};

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

/// Makes a point without a place.
void KeptContacts::Prepare(btManifoldPoint& point) const {
  const btVector3 none(0, 0, 0);
  point = btManifoldPoint(none, none, none, 0);
  point.m_combinedFriction = material_.friction;
  point.m_combinedRestitution = material_.restitution;
  point.m_combinedRollingFriction = material_.rolling_friction;
  point.m_combinedSpinningFriction = material_.spinning_friction;
  if (material_.is_soft) {
    point.m_combinedContactStiffness1 = material_.stiffness;
    point.m_combinedContactDamping1 = material_.damping;
    point.m_contactPointFlags = BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
  }
}

void KeptContacts::Update(std::span<const Contact> contacts, bool are_all) {
  if (are_all && is_plain_ && contacts.size() <= MANIFOLD_CACHE_SIZE) return Replace(contacts);
  if (are_balls_) manifold_.clearManifold();
  if (is_plain_) {
    Add(contacts);
  } else {
    AddByBullet(contacts);
  }
  if (!are_balls_ && manifold_.getNumContacts() > 0)
    manifold_.refreshContactPoints(manifold_.getBody0()->getWorldTransform(),
                                   manifold_.getBody1()->getWorldTransform());
}

/// The place of a contact, in world coordinates and in those of both bodies.
void KeptContacts::Place(const Contact& contact, btManifoldPoint& point) const {
  const auto distance = static_cast<btScalar>(contact.distance);
  point.m_normalWorldOnB = ToBullet(contact.normal);
  point.m_positionWorldOnB = ToBullet(contact.on_b);
  point.m_positionWorldOnA = point.m_positionWorldOnB + point.m_normalWorldOnB * distance;
  point.m_localPointA =
      manifold_.getBody0()->getWorldTransform().invXform(point.m_positionWorldOnA);
  point.m_localPointB =
      manifold_.getBody1()->getWorldTransform().invXform(point.m_positionWorldOnB);
  point.m_distance1 = distance;
}

void KeptContacts::Replace(std::span<const Contact> contacts) {
  const btScalar threshold = manifold_.getContactBreakingThreshold();
  const int before = manifold_.getNumContacts();
  Earlier earlier[MANIFOLD_CACHE_SIZE];
  const std::span known(earlier, are_balls_ ? 0 : static_cast<std::size_t>(before));
  for (std::size_t i = 0; i < known.size(); ++i)
    known[i] = Earlier(manifold_.getContactPoint(static_cast<int>(i)));
  int count = 0;
  for (const Contact& contact : contacts) {
    if (static_cast<btScalar>(contact.distance) > threshold) continue;
    manifold_.setNumContacts(count + 1);
    btManifoldPoint& point = manifold_.getContactPoint(count);
    if (count++ >= before) Prepare(point);
    Place(contact, point);
    Earlier none = {}, *nearest = &none;
    btScalar least = threshold * threshold;
    for (Earlier& one : known)
      if (const btScalar square = (one.local_a - point.m_localPointA).length2(); square < least)
        least = square, nearest = &one;
    nearest->GiveTo(point);
  }
  manifold_.setNumContacts(count);
}

void KeptContacts::Add(std::span<const Contact> contacts) {
  btManifoldPoint point;
  Prepare(point);
  for (const Contact& contact : contacts) {
    if (static_cast<btScalar>(contact.distance) > manifold_.getContactBreakingThreshold()) continue;
    Place(contact, point);
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

}  // namespace cdb::detection
