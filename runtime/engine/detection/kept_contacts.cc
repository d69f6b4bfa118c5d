// Source: btManifoldResult::addContactPoint of Bullet 3.24.
#include "runtime/engine/detection/kept_contacts.h"

#include <cstring>

#include "dsl/text/check.h"
#include "library/detectors/bullet/vectors.h"

namespace cdb::detection {
namespace {

using bullet::ToBullet;

bool IsBall(const btCollisionObject& body) {
  return body.getCollisionShape()->getShapeType() == SPHERE_SHAPE_PROXYTYPE;
}

/// A register of the vector extensions of GCC and Clang.
typedef btScalar Register __attribute__((vector_size(16)));
constexpr int kLanes = 16 / sizeof(btScalar), kParts = 4 / kLanes;

/// Four numbers; of a vector, the last one is 0.
struct Quad {
  Register part[kParts];

  template <typename Operation>
  [[gnu::always_inline]] static Quad Each(const Operation& operation) {
    Quad to;
    for (int k = 0; k < kParts; ++k) to.part[k] = operation(k);
    return to;
  }
  [[gnu::always_inline]] friend Quad operator+(const Quad& a, const Quad& b) {
    return Each([&](int k) { return a.part[k] + b.part[k]; });
  }
  [[gnu::always_inline]] friend Quad operator-(const Quad& a, const Quad& b) {
    return Each([&](int k) { return a.part[k] - b.part[k]; });
  }
  [[gnu::always_inline]] friend Quad operator-(const Quad& a, btScalar b) {
    return Each([&](int k) { return a.part[k] - b; });
  }
  [[gnu::always_inline]] friend Quad operator*(const Quad& a, const Quad& b) {
    return Each([&](int k) { return a.part[k] * b.part[k]; });
  }
  [[gnu::always_inline]] friend Quad operator*(const Quad& a, btScalar b) {
    return Each([&](int k) { return a.part[k] * b; });
  }
  btScalar operator[](int i) const { return part[i / kLanes][i % kLanes]; }
  void Set(int i, btScalar to) { part[i / kLanes][i % kLanes] = to; }
};

Quad Load(const btScalar* from) {
  Quad to;
  std::memcpy(&to, from, sizeof to);
  return to;
}
void Store(const Quad& from, btVector3& to) { std::memcpy(to.m_floats, &from, sizeof from); }
/// Through memory, the four numbers would have to wait for the store of each.
Quad Rounded(const Vec3& v) {
  const auto x = static_cast<btScalar>(v.x), y = static_cast<btScalar>(v.y),
             z = static_cast<btScalar>(v.z);
  Quad to = {};
  to.Set(0, x);
  to.Set(1, y);
  to.Set(2, z);
  return to;
}

/// From the world into the frame of a body, to the bit as btTransform::invXform.
class IntoFrame {
 public:
  explicit IntoFrame(const btCollisionObject& body) {
    const btTransform& pose = body.getWorldTransform();
    for (int i = 0; i < 3; ++i) rows_[i] = Load(pose.getBasis()[i].m_floats);
    origin_ = Load(pose.getOrigin().m_floats);
  }
  Quad operator()(const Quad& point) const {
    const Quad from = point - origin_;
    return rows_[0] * from[0] + rows_[1] * from[1] + rows_[2] * from[2];
  }

 private:
  Quad rows_[3], origin_;
};

/// The frames of a pair.
class Frames {
 public:
  explicit Frames(const btPersistentManifold& manifold)
      : a_(*manifold.getBody0()), b_(*manifold.getBody1()) {}
  /// Sets the place of a contact. Returns that in the frame of a.
  Quad Place(const Contact& contact, btScalar distance, btManifoldPoint& point) const {
    const Quad normal = Rounded(contact.normal), on_b = Rounded(contact.on_b);
    const Quad on_a = on_b + normal * distance, local_a = a_(on_a);
    Store(normal, point.m_normalWorldOnB);
    Store(on_b, point.m_positionWorldOnB);
    Store(on_a, point.m_positionWorldOnA);
    Store(local_a, point.m_localPointA);
    Store(b_(on_b), point.m_localPointB);
    point.m_distance1 = distance;
    return local_a;
  }

 private:
  IntoFrame a_, b_;
};

/// The points of the last cycle, with which the solver starts.
class Earlier {
 public:
  Earlier(const btPersistentManifold& manifold, int count) {
    for (int i = 0; i < count; ++i) {
      const btManifoldPoint& point = manifold.getContactPoint(i);
      kept_[i] = {{point.m_appliedImpulse, point.m_prevRHS, point.m_appliedImpulseLateral1,
                   point.m_appliedImpulseLateral2},
                  point.m_lifeTime};
      x_.Set(i, point.m_localPointA.x());
      y_.Set(i, point.m_localPointA.y());
      z_.Set(i, point.m_localPointA.z());
    }
  }
  /// Gives the point the impulses of the nearest one that is closer than `threshold` and has not
  /// given its own, or none.
  void GiveTo(btManifoldPoint& point, const Quad& local_a, btScalar threshold) {
    const Quad x = x_ - local_a[0], y = y_ - local_a[1], z = z_ - local_a[2];
    const Quad squares = x * x + y * y + z * z;
    btScalar least = threshold * threshold;
    int nearest = MANIFOLD_CACHE_SIZE;
    for (int i = 0; i < MANIFOLD_CACHE_SIZE; ++i)
      if (squares[i] < least) least = squares[i], nearest = i;
    const Kept kept = kept_[nearest];
    point.m_appliedImpulse = kept.impulses[0];
    point.m_prevRHS = kept.impulses[1];
    point.m_appliedImpulseLateral1 = kept.impulses[2];
    point.m_appliedImpulseLateral2 = kept.impulses[3];
    point.m_lifeTime = kept.lifetime + 1;
    if (nearest < MANIFOLD_CACHE_SIZE) x_.Set(nearest, kFar);
  }

 private:
  struct Kept {
    btScalar impulses[4] = {0, 0, 0, 0};
    int lifetime = 0;
  };
  static constexpr btScalar kFar = BT_LARGE_FLOAT;

  Quad x_ = Quad{} - -kFar, y_ = {}, z_ = {};
  Kept kept_[MANIFOLD_CACHE_SIZE + 1];  ///< the last one for points without an earlier one
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

void KeptContacts::Replace(std::span<const Contact> contacts) {
  const btScalar threshold = manifold_.getContactBreakingThreshold();
  const int before = manifold_.getNumContacts();
  Earlier earlier(manifold_, are_balls_ ? 0 : before);
  const Frames frames(manifold_);
  int count = 0;
  for (const Contact& contact : contacts) {
    const auto distance = static_cast<btScalar>(contact.distance);
    if (distance > threshold) continue;
    manifold_.setNumContacts(count + 1);
    btManifoldPoint& point = manifold_.getContactPoint(count);
    if (count++ >= before) Prepare(point);
    earlier.GiveTo(point, frames.Place(contact, distance, point), threshold);
  }
  manifold_.setNumContacts(count);
}

void KeptContacts::Add(std::span<const Contact> contacts) {
  if (contacts.empty()) return;
  const btScalar threshold = manifold_.getContactBreakingThreshold();
  const Frames frames(manifold_);
  btManifoldPoint point;
  Prepare(point);
  for (const Contact& contact : contacts) {
    const auto distance = static_cast<btScalar>(contact.distance);
    if (distance > threshold) continue;
    frames.Place(contact, distance, point);
    const int place = manifold_.getCacheEntry(point);
    if (place >= 0) {
      manifold_.replaceContactPoint(point, place);
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
