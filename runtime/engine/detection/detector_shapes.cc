#include "runtime/engine/detection/detector_shapes.h"

#include <algorithm>
#include <utility>

namespace cdb::detection {
namespace {

using Eigen::Vector3d;
using objects::Solid;

Vec3 ToVec3(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ShapeKind KindOf(const Solid& solid) {
  if (!solid.compound)
    return objects::Visit(solid, [&](auto form) { return form.KindOf(solid.sides); });
  if (solid.IsSurface()) return ShapeKind::kSurface;
  return solid.PieceCount() == 1 ? ShapeKind::kHull : ShapeKind::kCompound;
}

/// The flat faces of a shape as a hull; faces of more than three corners are divided.
std::pair<std::vector<Vec3>, std::vector<Face>> HullOf(const std::vector<shapes::FlatFace>& faces,
                                                       const Vector3d& sides) {
  std::vector<Vector3d> corners;
  std::vector<Face> triangles;
  const auto index = [&](const Vector3d& corner) {
    const auto found = std::ranges::find(corners, corner);
    if (found == corners.end()) corners.push_back(corner);
    return static_cast<std::uint32_t>(std::ranges::find(corners, corner) - corners.begin());
  };
  for (const shapes::FlatFace& face : faces)
    for (std::size_t i = 2; i < face.size(); ++i) {
      const std::uint32_t first = index(face[0]), second = index(face[i - 1]);
      triangles.push_back({first, second, index(face[i])});
    }
  std::vector<Vec3> vertices;
  for (const Vector3d& corner : corners) vertices.push_back(ToVec3(corner.cwiseProduct(sides)));
  return {std::move(vertices), std::move(triangles)};
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
      pieces_.try_emplace({solid.shape, solid.compound.get(), sides.x(), sides.y(), sides.z()});
  Pieces& pieces = place->second;
  if (!is_new) return pieces;
  if (solid.compound == nullptr) {
    objects::Visit(solid, [&](auto form) {
      if constexpr (requires { form.Faces(); }) {
        auto [vertices, faces] = HullOf(form.Faces(), sides);
        pieces.Add(std::move(vertices), std::move(faces));
      }
    });
    return pieces;
  }
  const objects::Compound& compound = *solid.compound;
  // A height field has none.
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
                 .hulls = {},
                 .e1 = solid.exponents.x(),
                 .e2 = solid.exponents.y()};
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
