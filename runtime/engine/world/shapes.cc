#include "runtime/engine/world/shapes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dsl/text/check.h"
#include "library/layouts/initial_state.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/internal_edges.h"

namespace cdb::world {
namespace {

using objects::Shape;
using objects::Solid;

/// Support points in the engine's precision, as shapes::ExactPoints.
struct BulletPoints {
  static btVector3 Ellipsoid(const btVector3& half, const btVector3& direction) {
    const btVector3 scaled = half * direction;
    const btScalar length = scaled.length();
    if (!(length > 0)) return {half.x(), 0, 0};
    return half * (scaled / length);
  }
  static btVector3 Ellipse(const btVector3& half, const btVector3& direction) {
    const btScalar x = half.x() * direction.x();
    const btScalar z = half.z() * direction.z();
    const btScalar length = btSqrt(x * x + z * z);
    if (!(length > 0)) return {half.x(), 0, 0};
    return {half.x() * (x / length), 0, half.z() * (z / length)};
  }
  static btVector3 Corner(const btVector3& half, const btVector3& direction) {
    return {direction.x() < 0 ? -half.x() : half.x(), direction.y() < 0 ? -half.y() : half.y(),
            direction.z() < 0 ? -half.z() : half.z()};
  }
};

/// A hull that refers to its points. When asked for a single direction, as for contacts with
/// planes, Bullet's own shape ignores the scaling in its search for the farthest point.
class PieceShape : public btConvexPointCloudShape {
 public:
  BT_DECLARE_ALIGNED_ALLOCATOR();

  using btConvexPointCloudShape::btConvexPointCloudShape;

  btVector3 localGetSupportingVertexWithoutMargin(const btVector3& direction) const override {
    btScalar most = 0;
    const btVector3 scaled = direction * getLocalScalingNV();
    return getScaledPoint(
        static_cast<int>(scaled.maxDot(getUnscaledPoints(), getNumPoints(), most)));
  }
  void batchedUnitVectorGetSupportingVertexWithoutMargin(const btVector3* directions,
                                                         btVector3* points,
                                                         int count) const override {
    for (int i = 0; i < count; ++i)
      points[i] = localGetSupportingVertexWithoutMargin(directions[i]);
  }
};

std::unique_ptr<btCollisionShape> MakePiece(std::vector<btVector3>& points,
                                            const btVector3& scaling, btScalar margin) {
  auto piece =
      std::make_unique<PieceShape>(points.data(), static_cast<int>(points.size()), scaling, false);
  // Bullet adds the margin to the box that it keeps, and then again.
  piece->setMargin(0);
  piece->recalcLocalAabb();
  piece->setMargin(margin);
  return piece;
}

double EffectiveMargin(const Solid& solid, double margin) {
  if (!solid.HasMargin()) return 0;
  const double least = solid.LeastHalfExtent();
  if (margin == layouts::kBulletMargin) return std::min(margin, least / 10);
  CDB_CHECK(margin < least);  // layouts::DrawObjects
  return margin;
}

}  // namespace

SolidShape::SolidShape(const Solid& solid, btScalar margin)
    : solid_(solid),
      core_(ToBullet(solid.HalfExtents()) - btVector3(margin, margin, margin)),
      offset_(static_cast<btScalar>(objects::OffsetOf(solid.shape, solid.sides))) {
  m_shapeType = CUSTOM_CONVEX_SHAPE_TYPE;
  m_implicitShapeDimensions = core_;
  btConvexInternalShape::setMargin(margin);
}

btVector3 SolidShape::localGetSupportingVertexWithoutMargin(const btVector3& direction) const {
  return objects::Visit(
      solid_, [&](auto form) { return form.Support(BulletPoints(), core_, offset_, direction); });
}

btVector3 SolidShape::localGetSupportingVertex(const btVector3& direction) const {
  const btVector3 point = localGetSupportingVertexWithoutMargin(direction);
  const btScalar length = direction.length();
  if (!(length > 0)) return point;
  return point + direction * (getMarginNV() / length);
}

void SolidShape::batchedUnitVectorGetSupportingVertexWithoutMargin(const btVector3* directions,
                                                                   btVector3* points,
                                                                   int count) const {
  for (int i = 0; i < count; ++i) points[i] = localGetSupportingVertexWithoutMargin(directions[i]);
}

// The extents along an axis are the scalar products with the farthest points along it and against
// it, to the bit.
std::pair<btScalar, btScalar> SolidShape::ExtentAlong(const btVector3& direction) const {
  return objects::Visit(solid_, [&](auto form) -> std::pair<btScalar, btScalar> {
    if constexpr (requires { form.Extent(BulletPoints(), core_, offset_, direction); }) {
      return form.Extent(BulletPoints(), core_, offset_, direction);
    } else {
      const auto farthest = [&](const btVector3& along) {
        return direction.dot(form.Support(BulletPoints(), core_, offset_, along));
      };
      const btScalar most = farthest(direction);
      // Shapes without an Extent that are as far on both sides, unless a support point is
      // arbitrary.
      const bool is_symmetric = !requires { form.BoxCentre(solid_.sides); }
      &&!requires { form.Faces(); };
      return {is_symmetric && most > 0 ? -most : farthest(-direction), most};
    }
  });
}

void SolidShape::getAabb(const btTransform& pose, btVector3& lower, btVector3& upper) const {
  const btMatrix3x3& basis = pose.getBasis();
  const btScalar margin = getMarginNV();
  for (int axis = 0; axis < 3; ++axis) {
    // A row of the basis is the world's axis in the body's frame.
    const auto [least, most] = ExtentAlong(basis[axis]);
    const btScalar origin = pose.getOrigin()[axis];
    upper[axis] = origin + most + margin;
    lower[axis] = origin + least - margin;
  }
  upper.setW(0);
  lower.setW(0);
}

void SolidShape::calculateLocalInertia(btScalar mass, btVector3& inertia) const {
  inertia = mass * ToBullet(solid_.InertiaPerMass());
}

btVector3 FarthestPoint(const btCollisionShape& shape, const btVector3& direction) {
  if (shape.isConvex())
    return static_cast<const btConvexShape&>(shape).localGetSupportingVertex(direction);
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  btVector3 farthest(0, 0, 0);
  btScalar most = -BT_LARGE_FLOAT;
  for (int i = 0; i < compound.getNumChildShapes(); ++i) {
    const btTransform& pose = compound.getChildTransform(i);
    const btVector3 point =
        pose * FarthestPoint(*compound.getChildShape(i), direction * pose.getBasis());
    if (direction.dot(point) <= most) continue;
    most = direction.dot(point);
    farthest = point;
  }
  return farthest;
}

std::optional<exact::HalfSpace> PlaneOf(const btCollisionObject& wall) {
  if (wall.getCollisionShape()->getShapeType() != STATIC_PLANE_PROXYTYPE) return std::nullopt;
  const auto& plane = static_cast<const btStaticPlaneShape&>(*wall.getCollisionShape());
  const Eigen::Vector3d normal = ToEigen(plane.getPlaneNormal());
  return exact::HalfSpace{normal, normal.dot(ToEigen(wall.getWorldTransform().getOrigin()))};
}

Solid BoxWallSolid(const btCollisionObject& wall) {
  const auto& box = static_cast<const btBoxShape&>(*wall.getCollisionShape());
  return {Shape::kCuboid, 2 * ToEigen(box.getHalfExtentsWithMargin())};
}

std::vector<ShapePool::Points>& ShapePool::PointsOf(const objects::ConvexDecomposition& form) {
  std::vector<Points>& pieces = points_[&form];
  if (!pieces.empty()) return pieces;
  for (const objects::ConvexPiece& piece : form.pieces) {
    Points& points = pieces.emplace_back();
    points.reserve(piece.vertices.size());
    for (const Eigen::Vector3d& vertex : piece.vertices) points.push_back(ToBullet(vertex));
  }
  return pieces;
}

// The outside of each piece is kept: its vertices move inwards by the margin that Bullet adds.
std::unique_ptr<btCollisionShape> ShapePool::MakeCompound(const objects::Compound& compound,
                                                          btScalar margin) {
  std::vector<Points>& pieces = PointsOf(compound.form());
  const btMatrix3x3 basis = BasisOf(compound.from_mesh());
  const auto scaling_of = [&](std::size_t piece) {
    const btVector3 half =
        ToBullet(compound.form().pieces[piece].half.cwiseProduct(compound.sides()));
    return ToBullet(compound.sides()) * (half - btVector3(margin, margin, margin)) / half;
  };
  if (pieces.size() == 1) {
    // A single convex piece needs no compound, and is in the body's own frame.
    const btVector3 scaling = scaling_of(0), centre = ToBullet(compound.PieceCentre(0));
    Points& points = *own_points_.emplace_back(std::make_unique<Points>());
    for (const btVector3& point : pieces[0]) points.push_back(basis * (point * scaling) + centre);
    return MakePiece(points, btVector3(1, 1, 1), margin);
  }
  auto shape = std::make_unique<btCompoundShape>(true, static_cast<int>(pieces.size()));
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    pieces_.push_back(MakePiece(pieces[i], scaling_of(i), margin));
    shape->addChildShape(btTransform(basis, ToBullet(compound.PieceCentre(i))),
                         pieces_.back().get());
  }
  return shape;
}

std::unique_ptr<btCollisionShape> ShapePool::MakeSurface(const objects::Compound& surface,
                                                         btScalar margin, bool smooth_edges) {
  Triangles& triangles = *triangles_.emplace_back(std::make_unique<Triangles>());
  const std::size_t count = surface.form().pieces.size();
  for (std::size_t triangle = 0; triangle < count; ++triangle)
    for (std::size_t corner = 0; corner < 3; ++corner) {
      triangles.indices.push_back(static_cast<int>(triangles.corners.size()));
      triangles.corners.push_back(ToBullet(surface.Corner(triangle, corner)));
    }
  btIndexedMesh mesh;
  mesh.m_numTriangles = static_cast<int>(count);
  mesh.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(triangles.indices.data());
  mesh.m_triangleIndexStride = 3 * sizeof(int);
  mesh.m_numVertices = static_cast<int>(triangles.corners.size());
  mesh.m_vertexBase = reinterpret_cast<const unsigned char*>(triangles.corners.data());
  mesh.m_vertexStride = sizeof(btVector3);
  triangles.array.addIndexedMesh(mesh);
  auto shape = std::make_unique<btBvhTriangleMeshShape>(&triangles.array, true);
  shape->setMargin(margin);
  if (smooth_edges) FindEdges(surface, *shape, triangles.edges);
  return shape;
}

std::unique_ptr<btCollisionShape> ShapePool::MakeHeights(const objects::Compound& surface,
                                                         btScalar margin, bool smooth_edges) {
  const objects::HeightSurface& field = *surface.form().heights;
  const terrain::HeightGrid& grid = field.grid();
  const double low = field.lowest(), high = field.highest();
  const double middle = low + (high - low) / 2,
               scale = high > low ? surface.sides().y() / (high - low) : 0;
  Triangles& triangles = *triangles_.emplace_back(std::make_unique<Triangles>());
  std::vector<btScalar>& heights = triangles.heights;
  heights.reserve(grid.heights.size());
  for (const double height : grid.heights)
    heights.push_back(static_cast<btScalar>((height - middle) * scale));
  const auto [least, most] = std::ranges::minmax(heights);
  const auto make = [&]<typename Form>(std::type_identity<Form>) {
    return std::make_unique<Form>(static_cast<int>(grid.columns), static_cast<int>(grid.rows),
                                  heights.data(), least, most, 1, false);
  };
  std::unique_ptr<btHeightfieldTerrainShape> shape;
  NumberedHeights* numbered = nullptr;
  if (smooth_edges) {
    auto with_numbers = make(std::type_identity<NumberedHeights>());
    numbered = with_numbers.get();
    shape = std::move(with_numbers);
  } else {
    shape = make(std::type_identity<btHeightfieldTerrainShape>());
  }
  const auto cells = [](std::size_t lines) { return static_cast<double>(lines - 1); };
  shape->setLocalScaling(ToBullet(Eigen::Vector3d(surface.sides().x() / cells(grid.columns), 1,
                                                  surface.sides().z() / cells(grid.rows))));
  shape->setMargin(margin);
  if (numbered != nullptr) FindEdges(surface, *numbered, triangles.edges);
  return shape;
}

btCollisionShape* ShapePool::Get(const Solid& solid, double margin, bool smooth_edges) {
  const double effective = EffectiveMargin(solid, margin);
  auto& shape =
      shapes_[{solid.shape, solid.compound.get(), solid.sides.x(), solid.sides.y(), solid.sides.z(),
               solid.exponents.x(), solid.exponents.y(), effective, smooth_edges}];
  if (shape != nullptr) return shape.get();
  const btVector3 half = ToBullet(solid.HalfExtents());
  const auto bullet_margin = static_cast<btScalar>(effective);
  if (solid.IsSurface()) {
    shape = solid.compound->form().heights != nullptr
                ? MakeHeights(*solid.compound, bullet_margin, smooth_edges)
                : MakeSurface(*solid.compound, bullet_margin, smooth_edges);
  } else if (solid.compound != nullptr) {
    shape = MakeCompound(*solid.compound, bullet_margin);
  } else if (solid.IsBall()) {
    shape = std::make_unique<btSphereShape>(half.x());
  } else if (solid.IsRoundCapsule()) {
    shape = std::make_unique<btCapsuleShape>(
        half.x(), static_cast<btScalar>(2 * shapes::Capsule::StraightHalf(solid.sides)));
  } else if (solid.shape == Shape::kCuboid) {
    shape = std::make_unique<btBoxShape>(half);
    shape->setMargin(bullet_margin);  // moves the core, not the outside
  } else if (solid.shape == Shape::kCylinder && solid.sides.x() == solid.sides.z()) {
    shape = std::make_unique<btCylinderShape>(half);
    shape->setMargin(bullet_margin);
  } else {
    shape = std::make_unique<SolidShape>(solid, bullet_margin);
  }
  return shape.get();
}

std::unique_ptr<btRigidBody> MakeBody(const layouts::ObjectState& object, btCollisionShape* shape) {
  const auto mass = static_cast<btScalar>(object.mass);
  const btVector3 inertia = mass * ToBullet(object.solid.InertiaPerMass());
  const Eigen::Quaterniond& turn = object.pose.orientation;
  btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
  info.m_startWorldTransform.setRotation(
      {static_cast<btScalar>(turn.x()), static_cast<btScalar>(turn.y()),
       static_cast<btScalar>(turn.z()), static_cast<btScalar>(turn.w())});
  info.m_startWorldTransform.setOrigin(ToBullet(object.pose.position));
  info.m_friction = static_cast<btScalar>(object.numbers["friction"]);
  info.m_rollingFriction = static_cast<btScalar>(object.numbers["rolling_friction"]);
  info.m_spinningFriction = static_cast<btScalar>(object.numbers["spinning_friction"]);
  info.m_restitution = static_cast<btScalar>(object.numbers["restitution"]);
  info.m_linearDamping = static_cast<btScalar>(object.numbers["linear_damping"]);
  info.m_angularDamping = static_cast<btScalar>(object.numbers["angular_damping"]);
  auto body = std::make_unique<btRigidBody>(info);
  if (!object.IsFixed()) {
    body->setLinearVelocity(ToBullet(object.linear_velocity));
    body->setAngularVelocity(ToBullet(object.angular_velocity));
  }
  if (object.is_kinematic) {
    body->setCollisionFlags((body->getCollisionFlags() & ~btCollisionObject::CF_STATIC_OBJECT) |
                            btCollisionObject::CF_KINEMATIC_OBJECT);
    body->setActivationState(DISABLE_DEACTIVATION);
  }
  return body;
}

}  // namespace cdb::world
