#include "runtime/engine/detection/detector_shapes.h"

#include <array>
#include <utility>

namespace cdb::detection {
namespace {

using Eigen::Vector3d;
using objects::Solid;

Vec3 ToVec3(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ShapeKind KindOf(const Solid& solid) {
  switch (solid.shape) {
    case objects::Shape::kEllipsoid:
      return ShapeKind::kEllipsoid;
    case objects::Shape::kCuboid:
      return ShapeKind::kBox;
    case objects::Shape::kCylinder:
      return ShapeKind::kCylinder;
    case objects::Shape::kCone:
      return ShapeKind::kCone;
    case objects::Shape::kCapsule:
      // No higher than wide, it is an ellipsoid.
      return solid.StraightHalf() > 0 ? ShapeKind::kCapsule : ShapeKind::kEllipsoid;
    case objects::Shape::kTetrahedron:
      return ShapeKind::kHull;
    case objects::Shape::kCompound:
      break;
  }
  if (solid.IsSurface()) return ShapeKind::kSurface;
  return solid.PieceCount() == 1 ? ShapeKind::kHull : ShapeKind::kCompound;
}

/// Every other corner of the box, beginning with the one that is positive on all axes.
std::array<Vector3d, 4> TetrahedronCorners(const Vector3d& half) {
  std::array<Vector3d, 4> corners = {half, -half, -half, -half};
  for (std::size_t axis = 0; axis < 3; ++axis)
    corners[axis + 1][static_cast<Eigen::Index>(axis)] = half[static_cast<Eigen::Index>(axis)];
  return corners;
}

}  // namespace

void DetectorShapes::Pieces::Add(std::vector<Vec3> points, std::vector<Face> sides) {
  vertices.push_back(std::move(points));
  faces.push_back(std::move(sides));
  hulls.push_back({vertices.back(), faces.back()});
}

const DetectorShapes::Pieces& DetectorShapes::PiecesOf(const Solid& solid) {
  const Vector3d& sides = solid.sides;
  const auto [place, is_new] =
      pieces_.try_emplace({solid.compound.get(), sides.x(), sides.y(), sides.z()});
  Pieces& pieces = place->second;
  if (!is_new) return pieces;
  if (solid.compound == nullptr) {
    std::vector<Vec3> points;
    for (const Vector3d& corner : TetrahedronCorners(solid.HalfExtents()))
      points.push_back(ToVec3(corner));
    pieces.Add(std::move(points), {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
    return pieces;
  }
  const objects::Compound& compound = *solid.compound;
  for (std::size_t i = 0; i < compound.form().pieces.size(); ++i) {
    const objects::ConvexPiece& piece = compound.form().pieces[i];
    const Vector3d centre = compound.PieceCentre(i);
    std::vector<Vec3> points;
    for (const Vector3d& vertex : piece.vertices)
      points.push_back(
          ToVec3(centre + compound.from_mesh() * vertex.cwiseProduct(compound.sides())));
    std::vector<Face> faces;
    for (const auto& face : piece.faces)
      faces.push_back({static_cast<std::uint32_t>(face[0]), static_cast<std::uint32_t>(face[1]),
                       static_cast<std::uint32_t>(face[2])});
    pieces.Add(std::move(points), std::move(faces));
  }
  return pieces;
}

Shape DetectorShapes::Of(const Solid& solid) {
  const ShapeKind kind = KindOf(solid);
  Shape shape = {.kind = kind,
                 .half = ToVec3(solid.HalfExtents()),
                 .centre = {0, solid.BoxCentre(), 0},
                 .normal = {0, 0, 0},
                 .hulls = {}};
  if (kind != ShapeKind::kHull && kind != ShapeKind::kCompound && kind != ShapeKind::kSurface)
    return shape;
  shape.hulls = PiecesOf(solid).hulls;
  Vector3d lower, upper;
  for (int axis = 0; axis < 3; ++axis) {
    lower[axis] = solid.Support(-Vector3d::Unit(axis))[axis];
    upper[axis] = solid.Support(Vector3d::Unit(axis))[axis];
  }
  shape.half = ToVec3((upper - lower) / 2);
  shape.centre = ToVec3((upper + lower) / 2);
  return shape;
}

}  // namespace cdb::detection
