#include "runtime/engine/world/internal_edges.h"

#include <BulletCollision/CollisionDispatch/btInternalEdgeUtility.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace cdb::world {
namespace {

/// m: the mean of the triangles' shortest edges; of some, if there are very many.
double UsualEdge(const objects::Compound& surface) {
  constexpr std::size_t kEnough = 2'000'000;
  double sum = 0;
  std::size_t seen = 0;
  const std::size_t count = surface.form().PieceCount(), step = (count - 1) / kEnough + 1;
  for (std::size_t triangle = 0; triangle < count; triangle += step, ++seen) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i)
      least = std::min(
          least, (surface.Corner(triangle, i) - surface.Corner(triangle, (i + 1) % 3)).norm());
    sum += least;
  }
  return sum / static_cast<double>(seen);
}

/// Bullet's limits are in m, and meant for bodies of 1 m.
void SetLimits(const objects::Compound& surface, btTriangleInfoMap& edges) {
  constexpr double kSamePoint = 1e-5, kAtEdge = 0.05;
  const double same = kSamePoint * surface.sides().maxCoeff();
  edges.m_equalVertexThreshold = static_cast<btScalar>(same * same);
  edges.m_edgeDistanceThreshold = static_cast<btScalar>(kAtEdge * UsualEdge(surface));
  edges.m_zeroAreaThreshold = 0;  // a surface has no triangles without area
}

/// Null if no triangle is beyond any edge of this one.
const btTriangleInfo* EdgesOf(const btCollisionShape& surface, int triangle) {
  const btTriangleInfoMap* edges =
      surface.getShapeType() == TERRAIN_SHAPE_PROXYTYPE
          ? static_cast<const btHeightfieldTerrainShape&>(surface).getTriangleInfoMap()
          : static_cast<const btBvhTriangleMeshShape&>(surface).getTriangleInfoMap();
  return edges->find(btHashInt(triangle));
}

/// True if the triangle turns into another one at each edge, by no more than a right angle.
bool HasBluntEdges(const btCollisionShape& surface, int triangle) {
  const btTriangleInfo* found = EdgesOf(surface, triangle);
  return found != nullptr &&
         std::max({btFabs(found->m_edgeV0V1Angle), btFabs(found->m_edgeV1V2Angle),
                   btFabs(found->m_edgeV2V0Angle)}) <= SIMD_HALF_PI;
}

/// The corner of the triangle where the point is, or -1.
int CornerAt(const btTriangleShape& triangle, const btVector3& point) {
  constexpr btScalar kSame(1e-4);
  const auto edge = [&](int i) {
    return triangle.getVertexPtr((i + 1) % 3) - triangle.getVertexPtr(i);
  };
  const btScalar least = std::min({edge(0).length2(), edge(1).length2(), edge(2).length2()});
  for (int i = 0; i < 3; ++i)
    if (point.distance2(triangle.getVertexPtr(i)) <= kSame * kSame * least) return i;
  return -1;
}

/// Whether a ball that touches a corner of the triangle from the side of `front`, along `normal`,
/// may touch it there, as far as the two edges tell: neither triangle beyond them is nearer to the
/// ball. That holds for at least one triangle at a convex corner, that whose normal is nearest.
bool MayTouchCorner(const btTriangleShape& triangle, const btTriangleInfo& edges, int corner,
                    const btVector3& front, bool is_behind, const btVector3& normal) {
  constexpr btScalar kSlack(1e-3);
  const btScalar angles[] = {edges.m_edgeV0V1Angle, edges.m_edgeV1V2Angle, edges.m_edgeV2V0Angle};
  const btVector3 own_front = is_behind ? -front : front;
  for (const int edge : {corner, (corner + 2) % 3}) {
    if (angles[edge] >= SIMD_2_PI) continue;  // open
    const bool is_convex = ((edges.m_flags & TRI_INFO_V0V1_CONVEX << edge) != 0) != is_behind;
    const btVector3 along = triangle.getVertexPtr((edge + 1) % 3) - triangle.getVertexPtr(edge),
                    outward = along.cross(own_front).normalized();
    const btScalar turn = is_convex ? btFabs(angles[edge]) : btScalar(0);
    if (btAtan2(outward.dot(normal), front.dot(normal)) > turn + kSlack) return false;
  }
  return true;
}

/// Corrects the normal of a contact with a triangle by Bullet's utility, which expects bodies in
/// front of it, or a flag. `front`: the triangle's normal on the side of the body.
void AdjustNormal(btManifoldPoint& contact, const btCollisionObjectWrapper* body,
                  const btCollisionObjectWrapper* triangle, int part, int index,
                  const btVector3& front, bool is_behind) {
  const auto adjust = [&](btManifoldPoint& point) {
    btAdjustInternalEdgeContacts(point, triangle, body, part, index,
                                 is_behind ? BT_TRIANGLE_CONVEX_BACKFACE_MODE : 0);
  };
  adjust(contact);
  // It leaves alone what would push the body through the surface: the shortest way out of this
  // triangle, if it is deep in the body. Past a sharp or an open edge that may be right, unless the
  // utility takes the mirrored normal for that of a hit on another edge.
  const btScalar away = front.dot(contact.m_normalWorldOnB);
  if (away >= 0) return;
  btManifoldPoint mirrored = contact;
  mirrored.m_normalWorldOnB -= 2 * away * front;
  adjust(mirrored);
  if (front.dot(mirrored.m_normalWorldOnB) <= 1 - 100 * SIMD_EPSILON) {
    if (!HasBluntEdges(*triangle->getCollisionObject()->getCollisionShape(), index)) return;
    mirrored.m_normalWorldOnB = front;
    mirrored.m_positionWorldOnB = mirrored.m_positionWorldOnA - mirrored.m_distance1 * front;
    mirrored.m_localPointB = triangle->getWorldTransform().invXform(mirrored.m_positionWorldOnB);
  }
  contact = mirrored;
}

/// Corrects the normal of a ball's contact with a triangle, by no more than rounding errors. False
/// if it is another: the ball is nearest to another triangle, whose contact it has as well, and
/// here it would touch beside its lowest point, and spin. Bullet's utility looks at one edge, and
/// at a corner there are two.
bool AdjustOfBall(btManifoldPoint& contact, const btCollisionObjectWrapper* ball,
                  const btCollisionObjectWrapper* triangle, int part, int index,
                  const btVector3& front, bool is_behind) {
  const auto& corners = static_cast<const btTriangleShape&>(*triangle->getCollisionShape());
  const btTransform& pose = triangle->getWorldTransform();
  const int corner = CornerAt(corners, pose.invXform(contact.m_positionWorldOnB));
  const btTriangleInfo* edges =
      EdgesOf(*triangle->getCollisionObject()->getCollisionShape(), index);
  if (corner >= 0 && edges != nullptr)
    return MayTouchCorner(corners, *edges, corner, front * pose.getBasis(), is_behind,
                          contact.m_normalWorldOnB * pose.getBasis());
  constexpr btScalar kTurned(1e-3);
  const btVector3 before = contact.m_normalWorldOnB;
  AdjustNormal(contact, ball, triangle, part, index, front, is_behind);
  return (contact.m_normalWorldOnB - before).length() <= kTurned;
}

/// The legal contacts of the ball that Bullet is at work on. Bullet takes a contact for that of an
/// earlier triangle, and overwrites it, if they are near each other on the body: near a corner, a
/// false contact would take the place of the true one.
class LegalContacts {
 public:
  /// Forgets those of another pair, and of one whose body has moved.
  void Begin(const btCollisionObject& body, const btCollisionObject& surface) {
    if (body_ == &body && surface_ == &surface && pose_ == body.getWorldTransform()) return;
    body_ = &body;
    surface_ = &surface;
    pose_ = body.getWorldTransform();
    nearest_ = std::min(
        body.getCollisionShape()->getContactBreakingThreshold(gContactBreakingThreshold),
        surface.getCollisionShape()->getContactBreakingThreshold(gContactBreakingThreshold));
    contacts_.clear();
  }
  /// In place of that of the same triangle, if the body has not moved since.
  void Add(const btManifoldPoint& contact) {
    for (btManifoldPoint& legal : contacts_)
      if (legal.m_index1 == contact.m_index1 && legal.m_partId1 == contact.m_partId1) {
        legal = contact;
        return;
      }
    contacts_.push_back(contact);
  }
  /// Gives the contact the place of the legal one that it has overwritten. False if there is none.
  bool PutBack(btManifoldPoint& contact) const {
    const btManifoldPoint* found = nullptr;
    btScalar least = nearest_ * nearest_;
    for (const btManifoldPoint& legal : contacts_) {
      const btScalar square = legal.m_localPointA.distance2(contact.m_localPointA);
      if (square >= least) continue;
      least = square;
      found = &legal;
    }
    if (found == nullptr) return false;
    contact.m_localPointA = found->m_localPointA;
    contact.m_localPointB = found->m_localPointB;
    contact.m_positionWorldOnA = found->m_positionWorldOnA;
    contact.m_positionWorldOnB = found->m_positionWorldOnB;
    contact.m_normalWorldOnB = found->m_normalWorldOnB;
    contact.m_distance1 = found->m_distance1;
    contact.m_partId1 = found->m_partId1;
    contact.m_index1 = found->m_index1;
    return true;
  }

 private:
  const btCollisionObject *body_ = nullptr, *surface_ = nullptr;
  btTransform pose_ = btTransform::getIdentity();
  btScalar nearest_ = 0;
  std::vector<btManifoldPoint> contacts_;
};

/// Separates the points of a contact, so that it has no impulse and Bullet removes it.
void Drop(const btTransform& surface, btScalar gap, btManifoldPoint& contact) {
  contact.m_distance1 = gap;
  contact.m_positionWorldOnB = contact.m_positionWorldOnA - gap * contact.m_normalWorldOnB;
  contact.m_localPointB = surface.invXform(contact.m_positionWorldOnB);
  contact.m_appliedImpulse = contact.m_appliedImpulseLateral1 = contact.m_appliedImpulseLateral2 =
      0;
}

}  // namespace

void FindEdges(const objects::Compound& surface, btBvhTriangleMeshShape& shape,
               btTriangleInfoMap& edges) {
  SetLimits(surface, edges);
  btGenerateInternalEdgeInfo(&shape, &edges);
}

void FindEdges(const objects::Compound& surface, NumberedHeights& shape, btTriangleInfoMap& edges) {
  SetLimits(surface, edges);
  if (surface.form().heights->grid().cells() > kMostCellsAtOnce) {
    shape.setTriangleInfoMap(&edges);
  } else {
    btGenerateInternalEdgeInfo(&shape, &edges);
  }
}

void NumberedHeights::processAllTriangles(btTriangleCallback* callback, const btVector3& lower,
                                          const btVector3& upper) const {
  struct Numbering final : btTriangleCallback {
    Numbering(btTriangleCallback& to, int triangles_in_row, int wanted)
        : callback(to), triangles(triangles_in_row), triangle(wanted) {}
    void processTriangle(btVector3* corners, int column, int line) override {
      const int number = line * triangles + column;
      if (triangle < 0 || triangle == number) callback.processTriangle(corners, 0, number);
    }
    btTriangleCallback& callback;
    const int triangles, triangle;
  };
  const int row = 2 * (m_heightStickWidth - 1), only = std::exchange(only_, -1);
  Numbering numbering(*callback, row, only);
  if (only < 0) {
    btHeightfieldTerrainShape::processAllTriangles(&numbering, lower, upper);
    return;
  }
  btVector3 corner, least, most;
  getVertex(only % row / 2, only / row, least);
  most = least;
  for (const auto& [right, below] : {std::pair(1, 0), std::pair(0, 1), std::pair(1, 1)}) {
    getVertex(only % row / 2 + right, only / row + below, corner);
    least.setMin(corner);
    most.setMax(corner);
  }
  btHeightfieldTerrainShape::processAllTriangles(&numbering, least, most);
}

void NumberedHeights::FindEdgesOf(int triangle) {
  btTriangleInfoMap* edges = getTriangleInfoMap();
  if (edges == nullptr || edges->find(btHashInt(triangle)) != nullptr) return;
  setTriangleInfoMap(nullptr);
  only_ = triangle;
  btGenerateInternalEdgeInfo(this, edges);
}

// In a manifold of Bullet's, the surface is always the second body.
bool AdjustAtEdges(btManifoldPoint& contact, const btCollisionObjectWrapper* a, int, int,
                   const btCollisionObjectWrapper* b, int part_b, int triangle_b) {
  if (b->getCollisionShape()->getShapeType() != TRIANGLE_SHAPE_PROXYTYPE) return false;
  const auto& triangle = static_cast<const btTriangleShape&>(*b->getCollisionShape());
  const btTransform& pose = b->getWorldTransform();
  btVector3 front;
  triangle.calcNormal(front);
  front = pose.getBasis() * front;
  const btVector3 centre = a->getCollisionObject()->getWorldTransform().getOrigin();
  const bool is_behind = front.dot(centre - pose * triangle.getVertexPtr(0)) < 0;
  // Bullet hands out what it was given as constant.
  auto& surface = const_cast<btCollisionShape&>(*b->getCollisionObject()->getCollisionShape());
  if (surface.getShapeType() == TERRAIN_SHAPE_PROXYTYPE)
    static_cast<NumberedHeights&>(surface).FindEdgesOf(triangle_b);
  if (is_behind) front = -front;
  if (a->getCollisionShape()->getShapeType() != SPHERE_SHAPE_PROXYTYPE) {
    AdjustNormal(contact, a, b, part_b, triangle_b, front, is_behind);
    return true;
  }
  thread_local LegalContacts legal;
  legal.Begin(*a->getCollisionObject(), *b->getCollisionObject());
  if (AdjustOfBall(contact, a, b, part_b, triangle_b, front, is_behind))
    legal.Add(contact);
  else if (!legal.PutBack(contact))
    Drop(pose, 1 + 4 * a->getCollisionShape()->getMargin(), contact);
  return true;
}

}  // namespace cdb::world
