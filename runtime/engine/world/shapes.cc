#include "runtime/engine/world/shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "library/scene_error.h"
#include "runtime/engine/world/conversions.h"

namespace cdb::world {
namespace {

using objects::Shape;
using objects::Solid;

/// The schema's default; a margin that is written as 0.04 means the same.
constexpr double kBulletMargin = 0.04;

/// The point farthest along `direction` on the ellipse in the x-z plane with the half axes of
/// `half`.
btVector3 EllipsePoint(const btVector3& half, const btVector3& direction) {
  const btScalar x = half.x() * direction.x();
  const btScalar z = half.z() * direction.z();
  const btScalar length = btSqrt(x * x + z * z);
  if (!(length > 0)) return {half.x(), 0, 0};
  return {half.x() * (x / length), 0, half.z() * (z / length)};
}

/// The scalar products of a direction with the corners of a tetrahedron: with the one in the octant
/// of all positive coordinates, and with those of which only one coordinate is positive. To the
/// bit: each sum has the order of a scalar product.
struct CornerDots {
  btScalar all, x, y, z;

  CornerDots(const btVector3& half, const btVector3& direction) {
    const btVector3 at = direction * half;
    all = at.x() + at.y() + at.z();
    x = at.x() - at.y() - at.z();
    y = -at.x() + at.y() - at.z();
    z = -at.x() - at.y() + at.z();
  }
};

/// The first corner of a tetrahedron that is farthest along `direction`. Looked up, as branches
/// could not be predicted.
btVector3 FarthestCorner(const btVector3& half, const btVector3& direction) {
  static constexpr btScalar kAll[] = {1, 1, 1}, kX[] = {1, -1, -1}, kY[] = {-1, 1, -1},
                            kZ[] = {-1, -1, 1};
  /// By whether the dot of x, of y and of z exceeds those before it.
  static constexpr const btScalar* kCorners[] = {kAll, kX, kY, kY, kZ, kZ, kZ, kZ};
  const CornerDots dots(half, direction);
  const btScalar most = std::max(dots.all, dots.x);
  const unsigned exceeding = unsigned{dots.x > dots.all} | unsigned{dots.y > most} << 1 |
                             unsigned{dots.z > std::max(most, dots.y)} << 2;
  const btScalar* sign = kCorners[exceeding];
  return {sign[0] * half.x(), sign[1] * half.y(), sign[2] * half.z()};
}

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

bool IsRoundCapsule(const Solid& solid) {
  return solid.shape == Shape::kCapsule && solid.sides.x() == solid.sides.z() &&
         solid.sides.y() >= solid.sides.x();
}

double EffectiveMargin(const Solid& solid, double margin) {
  // Bullet's sphere and capsule consist of margin only.
  if (solid.IsBall() || IsRoundCapsule(solid)) return 0;
  if (solid.IsSurface()) return 0;
  const double least = solid.LeastHalfExtent();
  if (margin == kBulletMargin) return std::min(margin, least / 10);
  if (margin >= least)
    throw library::SceneError(
        fmt::format("margin {:.6g} m is too large for an object whose least half extent is {:.6g} "
                    "m; make it smaller",
                    margin, least));
  return margin;
}

}  // namespace

SolidShape::SolidShape(const Solid& solid, btScalar margin)
    : solid_(solid),
      core_(ToBullet(solid.HalfExtents()) - btVector3(margin, margin, margin)),
      core_shift_(static_cast<btScalar>(solid.BoxCentre())) {
  m_shapeType = CUSTOM_CONVEX_SHAPE_TYPE;
  m_implicitShapeDimensions = core_;
  btConvexInternalShape::setMargin(margin);
}

btVector3 SolidShape::localGetSupportingVertexWithoutMargin(const btVector3& direction) const {
  switch (solid_.shape) {
    case Shape::kEllipsoid: {
      const btVector3 scaled = core_ * direction;
      const btScalar length = scaled.length();
      if (!(length > 0)) return {core_.x(), 0, 0};
      return core_ * (scaled / length);
    }
    case Shape::kCylinder: {
      btVector3 point = EllipsePoint(core_, direction);
      point.setY(direction.y() < 0 ? -core_.y() : core_.y());
      return point;
    }
    case Shape::kCone: {
      const btVector3 tip(0, core_shift_ + core_.y(), 0);
      btVector3 rim = EllipsePoint(core_, direction);
      rim.setY(core_shift_ - core_.y());
      return direction.dot(tip) > direction.dot(rim) ? tip : rim;
    }
    case Shape::kCapsule: {
      const btScalar straight = static_cast<btScalar>(solid_.StraightHalf());
      const btVector3 caps(core_.x(), core_.y() - straight, core_.z());
      const btVector3 scaled = caps * direction;
      const btScalar length = scaled.length();
      btVector3 point = length > 0 ? caps * (scaled / length) : btVector3(caps.x(), 0, 0);
      point.setY(point.y() + (direction.y() < 0 ? -straight : straight));
      return point;
    }
    case Shape::kTetrahedron:
      return FarthestCorner(core_, direction);
    case Shape::kCuboid:
    case Shape::kCompound:  // made by MakeCompound
      break;
  }
  return {direction.x() < 0 ? -core_.x() : core_.x(), direction.y() < 0 ? -core_.y() : core_.y(),
          direction.z() < 0 ? -core_.z() : core_.z()};
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
SolidShape::Extent SolidShape::ExtentAlong(const btVector3& direction) const {
  switch (solid_.shape) {
    case Shape::kTetrahedron: {
      const CornerDots dots(core_, direction);
      const auto [least, most] = std::minmax({dots.all, dots.x, dots.y, dots.z});
      return {least, most};
    }
    case Shape::kCone: {
      const btScalar tip = direction.y() * (core_shift_ + core_.y());
      const btScalar base = direction.y() * (core_shift_ - core_.y());
      const btVector3 rim = EllipsePoint(core_, direction);
      const btScalar x = direction.x() * rim.x(), z = direction.z() * rim.z();
      return {std::min(-x + base - z, tip), std::max(x + base + z, tip)};
    }
    default:
      break;
  }
  const auto farthest = [&](const btVector3& along) {
    return direction.dot(SolidShape::localGetSupportingVertexWithoutMargin(along));
  };
  const btScalar most = farthest(direction);
  // Every other solid has equal extents on both sides, unless a support point is arbitrary.
  return {most > 0 ? -most : farthest(-direction), most};
}

void SolidShape::getAabb(const btTransform& pose, btVector3& lower, btVector3& upper) const {
  const btMatrix3x3& basis = pose.getBasis();
  const btScalar margin = getMarginNV();
  for (int axis = 0; axis < 3; ++axis) {
    // A row of the basis is the world's axis in the body's frame.
    const Extent extent = ExtentAlong(basis[axis]);
    const btScalar origin = pose.getOrigin()[axis];
    upper[axis] = origin + extent.most + margin;
    lower[axis] = origin + extent.least - margin;
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
                                                         btScalar margin) {
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
  return shape;
}

std::unique_ptr<btCollisionShape> ShapePool::MakeHeights(const objects::Compound& surface,
                                                         btScalar margin) {
  const meshes::HeightGrid& grid = *surface.form().heights;
  const auto [low, high] = std::ranges::minmax(grid.heights);
  const double middle = low + (high - low) / 2,
               scale = high > low ? surface.sides().y() / (high - low) : 0;
  std::vector<btScalar>& heights = triangles_.emplace_back(std::make_unique<Triangles>())->heights;
  for (const double height : grid.heights)
    heights.push_back(static_cast<btScalar>((height - middle) * scale));
  const auto [least, most] = std::ranges::minmax(heights);
  auto shape = std::make_unique<btHeightfieldTerrainShape>(static_cast<int>(grid.columns),
                                                           static_cast<int>(grid.rows),
                                                           heights.data(), least, most, 1, false);
  const auto cells = [](std::size_t lines) { return static_cast<double>(lines - 1); };
  shape->setLocalScaling(ToBullet(Eigen::Vector3d(surface.sides().x() / cells(grid.columns), 1,
                                                  surface.sides().z() / cells(grid.rows))));
  shape->setMargin(margin);
  return shape;
}

btCollisionShape* ShapePool::Get(const Solid& solid, double margin) {
  const double effective = EffectiveMargin(solid, margin);
  auto& shape = shapes_[{solid.shape, solid.compound.get(), solid.sides.x(), solid.sides.y(),
                         solid.sides.z(), effective}];
  if (shape != nullptr) return shape.get();
  const btVector3 half = ToBullet(solid.HalfExtents());
  const auto bullet_margin = static_cast<btScalar>(effective);
  if (solid.IsSurface()) {
    shape = solid.compound->form().heights != nullptr ? MakeHeights(*solid.compound, bullet_margin)
                                                      : MakeSurface(*solid.compound, bullet_margin);
  } else if (solid.compound != nullptr) {
    shape = MakeCompound(*solid.compound, bullet_margin);
  } else if (solid.IsBall()) {
    shape = std::make_unique<btSphereShape>(half.x());
  } else if (IsRoundCapsule(solid)) {
    shape =
        std::make_unique<btCapsuleShape>(half.x(), static_cast<btScalar>(2 * solid.StraightHalf()));
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

}  // namespace cdb::world
