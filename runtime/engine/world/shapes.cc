#include "runtime/engine/world/shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "library/scene_error.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/internal_edges.h"

namespace cdb::world {
namespace {

using objects::Shape;
using objects::Solid;

/// The schema's default; a margin that is written as 0.04 means the same.
constexpr double kBulletMargin = 0.04;

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
      offset_(static_cast<btScalar>(objects::OffsetOf(solid.shape, solid.sides))) {
  m_shapeType = CUSTOM_CONVEX_SHAPE_TYPE;
  m_implicitShapeDimensions = core_;
  btConvexInternalShape::setMargin(margin);
}

btVector3 SolidShape::localGetSupportingVertexWithoutMargin(const btVector3& direction) const {
  return objects::Visit(solid_.shape, [&](auto form) {
    return form.Support(BulletPoints(), core_, offset_, direction);
  });
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
  return objects::Visit(solid_.shape, [&](auto form) -> std::pair<btScalar, btScalar> {
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
  const meshes::HeightGrid& grid = *surface.form().heights;
  const auto [low, high] = std::ranges::minmax(grid.heights);
  const double middle = low + (high - low) / 2,
               scale = high > low ? surface.sides().y() / (high - low) : 0;
  Triangles& triangles = *triangles_.emplace_back(std::make_unique<Triangles>());
  std::vector<btScalar>& heights = triangles.heights;
  for (const double height : grid.heights)
    heights.push_back(static_cast<btScalar>((height - middle) * scale));
  const auto [least, most] = std::ranges::minmax(heights);
  const auto make =
      [&]<typename Form>(std::type_identity<Form>) -> std::unique_ptr<btHeightfieldTerrainShape> {
    return std::make_unique<Form>(static_cast<int>(grid.columns), static_cast<int>(grid.rows),
                                  heights.data(), least, most, 1, false);
  };
  auto shape = smooth_edges ? make(std::type_identity<NumberedHeights>())
                            : make(std::type_identity<btHeightfieldTerrainShape>());
  const auto cells = [](std::size_t lines) { return static_cast<double>(lines - 1); };
  shape->setLocalScaling(ToBullet(Eigen::Vector3d(surface.sides().x() / cells(grid.columns), 1,
                                                  surface.sides().z() / cells(grid.rows))));
  shape->setMargin(margin);
  if (smooth_edges) FindEdges(surface, *shape, triangles.edges);
  return shape;
}

btCollisionShape* ShapePool::Get(const Solid& solid, double margin, bool smooth_edges) {
  const double effective = EffectiveMargin(solid, margin);
  auto& shape = shapes_[{solid.shape, solid.compound.get(), solid.sides.x(), solid.sides.y(),
                         solid.sides.z(), effective, smooth_edges}];
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
  } else if (IsRoundCapsule(solid)) {
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

namespace {

using Eigen::Vector3d;

/// Bullet's own spring limits the stiffness, aims at a velocity that ignores other forces, and
/// drops the spring where the damper is stronger. Here its first row, the axis x, is the force
/// itself.
class PlainSpring : public btGeneric6DofSpring2Constraint {
 public:
  PlainSpring(btRigidBody& a, btRigidBody& b, const btTransform& in_a, const btTransform& in_b,
              btScalar stiffness, btScalar damping)
      : btGeneric6DofSpring2Constraint(a, b, in_a, in_b), stiffness_(stiffness), damping_(damping) {
    setLimit(0, 1, -1);  // free
    enableSpring(0, true);
    calculateTransforms();
    length_ = getRelativePivotPosition(0);
  }

  void getInfo2(btConstraintInfo2* info) override {
    btGeneric6DofSpring2Constraint::getInfo2(info);
    const btVector3 line(info->m_J1linearAxis[0], info->m_J1linearAxis[1], info->m_J1linearAxis[2]);
    const btScalar stretch = getRelativePivotPosition(0) - length_;
    const btScalar rate =
        line.dot(getRigidBodyB().getLinearVelocity() - getRigidBodyA().getLinearVelocity());
    info->m_constraintError[0] = 0;
    info->m_lowerLimit[0] = info->m_upperLimit[0] =
        (stiffness_ * stretch + damping_ * rate) / info->fps;
  }

 private:
  const btScalar stiffness_, damping_;
  btScalar length_;
};

/// A frame at `origin` with x along `line`, a unit vector.
btTransform FrameAlong(const btVector3& line, const btVector3& origin) {
  btVector3 y, z;
  btPlaneSpace1(line, y, z);
  return btTransform(
      btMatrix3x3(line.x(), y.x(), z.x(), line.y(), y.y(), z.y(), line.z(), y.z(), z.z()), origin);
}

btVector3 InBody(const btRigidBody& body, const btVector3& point) {
  return body.getWorldTransform().invXform(point);
}

}  // namespace

Links::Links(const plan::Scene& scene, const layouts::InitialState& state,
             const std::vector<std::unique_ptr<btRigidBody>>& objects,
             btDiscreteDynamicsWorld& world)
    : world_(world) {
  std::size_t first = 0;
  for (const plan::Group& group : scene.groups) {
    const std::size_t end = first + group.settings.Count("quantity");
    if (group.HasLinks()) {
      const auto place = [&](std::size_t i) { return objects[i]->getWorldTransform().getOrigin(); };
      if (group.settings.On("links.anchor")) {
        const layouts::ObjectState& object = state.objects[first];
        const double height = objects::Bounds(object.solid, object.pose.orientation).upper.y();
        const btVector3 from = end - first > 1 ? 2 * place(first) - place(first + 1)
                                               : place(first) + ToBullet({0, 2 * height, 0});
        Add(group.settings, btTypedConstraint::getFixedBody(), *objects[first], from);
      }
      for (std::size_t i = first; i + 1 < end; ++i)
        Add(group.settings, *objects[i], *objects[i + 1], place(i));
    }
    first = end;
  }
}

Links::~Links() {
  for (const Link& link : links_) world_.removeConstraint(link.constraint.get());
}

void Links::Add(const plan::GroupSettings& settings, btRigidBody& first, btRigidBody& second,
                const btVector3& from) {
  if (first.isStaticOrKinematicObject() && second.isStaticOrKinematicObject()) return;
  const std::string_view type = settings.WordOr("links.type");
  const btVector3 to = second.getWorldTransform().getOrigin();
  Link link;
  link.first = &first;
  link.second = &second;
  link.line_in_first.setZero();
  const btVector3 pivot = (from + to) / 2;
  link.pivot_in_first = InBody(first, pivot);
  link.pivot_in_second = InBody(second, pivot);
  if (type == "ball") {
    link.constraint = std::make_unique<btPoint2PointConstraint>(first, second, link.pivot_in_first,
                                                                link.pivot_in_second);
  } else if (type == "hinge") {
    const btVector3 axis(0, 0, 1);
    link.constraint = std::make_unique<btHingeConstraint>(
        first, second, link.pivot_in_first, link.pivot_in_second,
        axis * first.getWorldTransform().getBasis(), axis * second.getWorldTransform().getBasis());
  } else if (type == "fixed") {
    const btTransform frame(btMatrix3x3::getIdentity(), pivot);
    link.constraint = std::make_unique<btFixedConstraint>(
        first, second, first.getWorldTransform().inverse() * frame,
        second.getWorldTransform().inverse() * frame);
  } else {
    const btVector3 way = to - from;
    if (!(way.length2() > 0))
      throw library::SceneError(
          fmt::format("object {} begins at the position of the previous object, so their spring "
                      "has no direction; use another layout",
                      second.getUserIndex() + 1));
    const btVector3 line = way.normalized();
    link.stiffness = settings.Real("links.stiffness");
    link.length = static_cast<double>(way.length());
    link.line_in_first = line * first.getWorldTransform().getBasis();
    link.pivot_in_first = InBody(first, from);
    link.pivot_in_second.setZero();
    link.constraint = std::make_unique<PlainSpring>(
        first, second, first.getWorldTransform().inverse() * FrameAlong(line, from),
        second.getWorldTransform().inverse() * FrameAlong(line, to),
        static_cast<btScalar>(link.stiffness),
        static_cast<btScalar>(settings.Real("links.damping")));
  }
  joints_ = joints_ || link.stiffness == 0;
  // The body that represents the world is shared and must not keep references to our constraints.
  const bool between_objects = &first != &btTypedConstraint::getFixedBody();
  world_.addConstraint(link.constraint.get(), between_objects);
  links_.push_back(std::move(link));
}

void Links::MarkHeld(std::vector<char>& marks, char mark) const {
  for (const Link& link : links_)
    for (const btRigidBody* body : {link.first, link.second})
      if (body->getUserIndex() >= 0) marks[static_cast<std::size_t>(body->getUserIndex())] = mark;
}

double Links::LargestGap() const {
  double largest = 0;
  for (const Link& link : links_) {
    if (link.stiffness != 0) continue;
    const Vector3d first = ToEigen(link.first->getWorldTransform() * link.pivot_in_first);
    const Vector3d second = ToEigen(link.second->getWorldTransform() * link.pivot_in_second);
    largest = std::max(largest, (second - first).norm());
  }
  return largest;
}

double Links::SpringEnergy(double timestep) const {
  double energy = 0;
  for (const Link& link : links_) {
    if (link.stiffness == 0) continue;
    const btTransform& first = link.first->getWorldTransform();
    const Vector3d line = ToEigen(first.getBasis() * link.line_in_first);
    const Vector3d way = ToEigen(link.second->getWorldTransform().getOrigin()) -
                         ToEigen(first * link.pivot_in_first);
    const Vector3d velocity =
        ToEigen(link.second->getLinearVelocity()) - ToEigen(link.first->getLinearVelocity());
    const double stretch = line.dot(way) - link.length;
    // With the force F = -k x, x and v stay on the ellipse k x^2/2 + m v^2/2 - dt k x v/2.
    energy += link.stiffness * stretch * (stretch - timestep * line.dot(velocity)) / 2;
  }
  return energy;
}

}  // namespace cdb::world
