#include "runtime/engine/detection/box_pass.h"

#include <BulletCollision/CollisionShapes/btConvexPointCloudShape.h>

#include <cstring>
#include <map>

#if defined(__SSE2__) && !defined(BT_USE_DOUBLE_PRECISION)
#include <emmintrin.h>
#define CDB_FLOAT_LANES 1
#else
#define CDB_FLOAT_LANES 0
#endif

namespace cdb::detection {
namespace {

/// Bullet's limit of the square of a box's diagonal, m^2; sides of a box that is surely within.
constexpr btScalar kMostDiagonal2 = btScalar(1e12), kSafeSide = btScalar(5e5);
/// ns, about, most of which are waits for memory; and the bodies that two threads never share, as
/// 64 of them have a cache line of `is_asleep`.
constexpr double kWorkOfBody = 50;
constexpr std::size_t kBlock = 64;
/// Bodies ahead of the one at work whose poses are fetched.
constexpr std::size_t kAhead = 20;

/// The local boxes of shapes that keep them to themselves.
class PieceBox : public btPolyhedralConvexAabbCachingShape {
 public:
  static void Get(const btPolyhedralConvexAabbCachingShape& shape, btVector3& lower,
                  btVector3& upper) {
    (shape.*(&PieceBox::getCachedLocalAabb))(lower, upper);
  }
};
class CompoundBox : public btCompoundShape {
 public:
  static void Get(const btCompoundShape& shape, btVector3& lower, btVector3& upper) {
    lower = shape.*(&CompoundBox::m_localAabbMin);
    upper = shape.*(&CompoundBox::m_localAabbMax);
  }
};

btVector3 Cube(btScalar side) { return {side, side, side}; }

/// Where a body keeps whether it is asleep.
class ActivationState : public btCollisionObject {
 public:
  static const int* Of(const btCollisionObject& body) {
    return &(body.*(&ActivationState::m_activationState1));
  }
};

/// Fetches what Update reads, as bodies are larger than the caches next to the processor.
void Prefetch(const btRigidBody& body, bool needs_basis, bool was_asleep) {
#if defined(__GNUC__)
  __builtin_prefetch(ActivationState::Of(body));
  if (was_asleep) return;
  if (needs_basis) __builtin_prefetch(&body.getWorldTransform());
  __builtin_prefetch(&body.getWorldTransform().getOrigin());
  __builtin_prefetch(&body.getInterpolationWorldTransform().getOrigin());
#endif
}

#if CDB_FLOAT_LANES
__m128 Lanes(const btVector3& v) { return _mm_loadu_ps(v.m_floats); }
__m128 Size(__m128 x) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), x); }
#endif

}  // namespace

#if CDB_FLOAT_LANES

/// The last lane means nothing.
struct BoxPass::Corners {
  __m128 lower, upper;

  Corners(__m128 centre, __m128 extent)
      : lower(_mm_sub_ps(centre, extent)), upper(_mm_add_ps(centre, extent)) {}
  Corners(const btVector3& least, const btVector3& most)
      : lower(Lanes(least)), upper(Lanes(most)) {}

  void Widen() {
    const __m128 by = _mm_set1_ps(gContactBreakingThreshold);
    lower = _mm_sub_ps(lower, by);
    upper = _mm_add_ps(upper, by);
  }
  /// As setMin and setMax: what is not a number stays here and is passed over there.
  void Join(const Corners& other) {
    lower = _mm_min_ps(other.lower, lower);
    upper = _mm_max_ps(other.upper, upper);
  }
  bool IsWithinLimit() const {
    const __m128 sides = _mm_sub_ps(upper, lower);
    if ((_mm_movemask_ps(_mm_cmplt_ps(sides, _mm_set1_ps(kSafeSide))) & 7) == 7) return true;
    btVector3 diagonal;
    _mm_storeu_ps(diagonal.m_floats, sides);
    return diagonal.length2() < kMostDiagonal2;
  }
  void Store(Box& box) const {
    const __m128 middle = _mm_shuffle_ps(lower, upper, _MM_SHUFFLE(0, 0, 2, 2));
    double* at = &box.lower.x;
    _mm_storeu_pd(at, _mm_cvtps_pd(lower));
    _mm_storeu_pd(at + 2, _mm_cvtps_pd(_mm_shuffle_ps(middle, middle, _MM_SHUFFLE(2, 2, 2, 0))));
    _mm_storeu_pd(at + 4, _mm_cvtps_pd(_mm_shuffle_ps(upper, upper, _MM_SHUFFLE(2, 2, 2, 1))));
  }
  btVector3 Lower() const { return AsVector(lower); }
  btVector3 Upper() const { return AsVector(upper); }

 private:
  static btVector3 AsVector(__m128 lanes) {
    btVector3 vector;
    _mm_storeu_ps(vector.m_floats, lanes);
    return vector;
  }
};

// Sums are in Bullet's order: x, y, z.
[[gnu::always_inline]] inline BoxPass::Corners BoxPass::Around(const ShapeBox& shape,
                                                               const btTransform& pose) {
  if (shape.kind == Kind::kVirtual) {
    btVector3 lower, upper;
    shape.shape->getAabb(pose, lower, upper);
    return {lower, upper};
  }
  const __m128 origin = Lanes(pose.getOrigin()), half = Lanes(shape.half);
  if (shape.kind == Kind::kBall) return {origin, half};
  const btMatrix3x3& basis = pose.getBasis();
  __m128 x = Lanes(basis[0]), y = Lanes(basis[1]), z = Lanes(basis[2]), w = _mm_setzero_ps();
  _MM_TRANSPOSE4_PS(x, y, z, w);
  const auto times = [](__m128 a, __m128 b, __m128 c, __m128 v) {
    const __m128 vx = _mm_shuffle_ps(v, v, _MM_SHUFFLE(0, 0, 0, 0));
    const __m128 vy = _mm_shuffle_ps(v, v, _MM_SHUFFLE(1, 1, 1, 1));
    const __m128 vz = _mm_shuffle_ps(v, v, _MM_SHUFFLE(2, 2, 2, 2));
    return _mm_add_ps(_mm_add_ps(_mm_mul_ps(vx, a), _mm_mul_ps(vy, b)), _mm_mul_ps(vz, c));
  };
  const __m128 extent = times(Size(x), Size(y), Size(z), half);
  if (shape.kind == Kind::kCentred) return {origin, extent};
  return {_mm_add_ps(times(x, y, z, Lanes(shape.centre)), origin), extent};
}

#else

struct BoxPass::Corners {
  btVector3 lower, upper;

  void Widen() {
    const btVector3 by = Cube(gContactBreakingThreshold);
    lower -= by;
    upper += by;
  }
  void Join(const Corners& other) {
    lower.setMin(other.lower);
    upper.setMax(other.upper);
  }
  bool IsWithinLimit() const { return (upper - lower).length2() < kMostDiagonal2; }
  void Store(Box& box) const {
    box = {{static_cast<double>(lower.x()), static_cast<double>(lower.y()),
            static_cast<double>(lower.z())},
           {static_cast<double>(upper.x()), static_cast<double>(upper.y()),
            static_cast<double>(upper.z())}};
  }
  const btVector3& Lower() const { return lower; }
  const btVector3& Upper() const { return upper; }
};

BoxPass::Corners BoxPass::Around(const ShapeBox& shape, const btTransform& pose) {
  if (shape.kind == Kind::kVirtual) {
    Corners corners;
    shape.shape->getAabb(pose, corners.lower, corners.upper);
    return corners;
  }
  const btVector3& origin = pose.getOrigin();
  if (shape.kind == Kind::kBall) return {origin - shape.half, origin + shape.half};
  const btMatrix3x3 sizes = pose.getBasis().absolute();
  const btVector3 extent = shape.half.dot3(sizes[0], sizes[1], sizes[2]);
  const btVector3 centre = shape.kind == Kind::kCentred ? origin : pose(shape.centre);
  return {centre - extent, centre + extent};
}

#endif

BoxPass::ShapeBox BoxPass::Describe(const btCollisionShape& shape) {
  ShapeBox box{{0, 0, 0}, {0, 0, 0}, &shape, Kind::kVirtual};
  const auto local = [&](const btVector3& lower, const btVector3& upper) {
    box.half = btScalar(0.5) * (upper - lower);
    box.half += Cube(shape.getMargin());
    box.centre = btScalar(0.5) * (upper + lower);
    box.kind = Kind::kOffCentre;
  };
  btVector3 lower, upper;
  switch (shape.getShapeType()) {
    case SPHERE_SHAPE_PROXYTYPE:
      box.half = Cube(shape.getMargin());
      box.kind = Kind::kBall;
      break;
    case BOX_SHAPE_PROXYTYPE:
      box.half = static_cast<const btBoxShape&>(shape).getHalfExtentsWithoutMargin() +
                 Cube(shape.getMargin());
      box.kind = Kind::kCentred;
      break;
    case CYLINDER_SHAPE_PROXYTYPE:
      box.half = static_cast<const btCylinderShape&>(shape).getHalfExtentsWithoutMargin() +
                 Cube(shape.getMargin());
      box.kind = Kind::kCentred;
      break;
    case CAPSULE_SHAPE_PROXYTYPE: {
      const auto& capsule = static_cast<const btCapsuleShape&>(shape);
      box.half = Cube(capsule.getRadius());
      box.half[capsule.getUpAxis()] = capsule.getRadius() + capsule.getHalfHeight();
      box.kind = Kind::kCentred;
      break;
    }
    case CONVEX_POINT_CLOUD_SHAPE_PROXYTYPE:
      PieceBox::Get(static_cast<const btConvexPointCloudShape&>(shape), lower, upper);
      local(lower, upper);
      break;
    case COMPOUND_SHAPE_PROXYTYPE:
      CompoundBox::Get(static_cast<const btCompoundShape&>(shape), lower, upper);
      if (static_cast<const btCompoundShape&>(shape).getNumChildShapes() > 0) local(lower, upper);
      break;
    default:
      break;
  }
  if (!Agrees(box)) box.kind = Kind::kVirtual;
  return box;
}

// A build of Bullet may round in another way, as where multiplication and addition are one
// instruction.
bool BoxPass::Agrees(const ShapeBox& shape) {
  const auto same = [](const btVector3& a, const btVector3& b) {
    return std::memcmp(a.m_floats, b.m_floats, 3 * sizeof(btScalar)) == 0;
  };
  for (int trial = 0; trial < 16; ++trial) {
    const auto at = static_cast<btScalar>(trial);
    const btTransform pose(
        btQuaternion(btVector3(btScalar(1.1) - at, 2 + at, btScalar(-3.3)).normalized(),
                     btScalar(0.37) * at),
        btVector3(btScalar(1.7) * at, btScalar(-0.013) * at, btScalar(1234.5) / (at + 1)));
    btVector3 lower, upper;
    shape.shape->getAabb(pose, lower, upper);
    const Corners corners = Around(shape, pose);
    if (!same(corners.Lower(), lower) || !same(corners.Upper(), upper)) return false;
  }
  return true;
}

BoxPass::BoxPass(std::span<btRigidBody* const> bodies) {
  std::map<const btCollisionShape*, std::uint32_t> places;
  Id id = 0;
  for (btRigidBody* body : bodies) {
    const btCollisionShape* shape = body->getCollisionShape();
    const auto [place, is_new] =
        places.try_emplace(shape, static_cast<std::uint32_t>(shapes_.size()));
    if (is_new) shapes_.push_back(Describe(*shape));
    const Kind kind = shapes_[place->second].kind;
    computed_ += kind != Kind::kVirtual;
    (body->isStaticObject() ? unwritten_ : moving_)
        .push_back({body, place->second, id++, kind != Kind::kBall, body->isStaticObject(),
                    body->isKinematicObject()});
  }
}

/// False where the box is beyond Bullet's limit.
bool BoxPass::Write(const ShapeBox& shape, const Body& at, Box& box) {
  Corners corners = Around(shape, at.body->getWorldTransform());
  corners.Widen();
  if (!at.is_static && !at.is_kinematic) {
    Corners predicted = Around(shape, at.body->getInterpolationWorldTransform());
    predicted.Widen();
    corners.Join(predicted);
  }
  if (!at.is_static && !corners.IsWithinLimit()) return false;
  corners.Store(box);
  return true;
}

/// True if the box is written.
bool BoxPass::Visit(const Body& at, bool updates_all, std::span<Box> boxes,
                    std::span<std::uint8_t> is_asleep) const {
  // A kinematic body is moved by others, asleep or not.
  const bool sleeps =
      at.body->getActivationState() == ISLAND_SLEEPING && !at.is_static && !at.is_kinematic;
  const bool still_sleeps = sleeps && is_asleep[at.id] != 0;
  is_asleep[at.id] = sleeps || at.is_static;
  if (still_sleeps || !(updates_all || at.body->isActive())) return false;
  if (!Write(shapes_[at.shape], at, boxes[at.id])) at.body->setActivationState(DISABLE_SIMULATION);
  return true;
}

void BoxPass::Update(bool updates_all, std::span<Box> boxes, std::span<std::uint8_t> is_asleep,
                     kernels::PairParts& parts) {
  std::erase_if(unwritten_,
                [&](const Body& at) { return Visit(at, updates_all, boxes, is_asleep); });
  const double work = kWorkOfBody * static_cast<double>(moving_.size());
  const kernels::ThreadPool::Session session = parts.Begin(work);
  parts.ForEach(work, 0, moving_.size(), kBlock, [&](unsigned, std::size_t from, std::size_t to) {
    VisitMoving(from, to, updates_all, boxes, is_asleep);
  });
}

void BoxPass::VisitMoving(std::size_t from, std::size_t to, bool updates_all, std::span<Box> boxes,
                          std::span<std::uint8_t> is_asleep) const {
  for (std::size_t i = from; i < to; ++i) {
    if (i + kAhead < to) {
      const Body& ahead = moving_[i + kAhead];
      Prefetch(*ahead.body, ahead.needs_basis, is_asleep[ahead.id] != 0);
    }
    Visit(moving_[i], updates_all, boxes, is_asleep);
  }
}

}  // namespace cdb::detection
