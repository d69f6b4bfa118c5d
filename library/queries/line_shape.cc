#include "library/queries/line_shape.h"

#include <algorithm>

#include "dsl/text/check.h"
#include "library/objects/shapes/capsule.h"

namespace cdb::queries {
namespace {

using Eigen::Vector3d;
using objects::Shape;

/// A test of fewer pieces one by one takes no longer than a tree.
constexpr std::size_t kFewPieces = 4;

/// Faces of a hull are triangles: those in one plane count once.
bool AreSame(const Vector3d& normal, double offset, const Vector3d& other, double other_offset,
             double size) {
  return (normal - other).squaredNorm() < 1e-20 && std::fabs(offset - other_offset) < 1e-12 * size;
}

}  // namespace

template <typename Real>
LineShape<Real>::LineShape(const objects::Solid& solid)
    : half_(solid.HalfExtents().cast<Real>()),
      sides_half_(half_),
      e1_(static_cast<Real>(solid.exponents.x())),
      e2_(static_cast<Real>(solid.exponents.y())) {
  switch (solid.shape) {
    case Shape::kEllipsoid:
      kind_ = Kind::kEllipsoid;
      break;
    case Shape::kCuboid:
      kind_ = Kind::kCuboid;
      break;
    case Shape::kCylinder:
      kind_ = Kind::kCylinder;
      break;
    case Shape::kCone:
      kind_ = Kind::kCone;
      middle_.y() = static_cast<Real>(solid.BoxCentre());
      break;
    case Shape::kCapsule:
      kind_ = Kind::kCapsule;
      straight_ = static_cast<Real>(shapes::Capsule::StraightHalf(solid.sides));
      break;
    case Shape::kTetrahedron:
      kind_ = Kind::kTetrahedron;
      break;
    case Shape::kSuperellipsoid:
      kind_ = Kind::kSuperellipsoid;
      break;
    case Shape::kCompound:
      kind_ = solid.IsSurface() ? Kind::kTriangles : Kind::kPieces;
      if (solid.IsSurface())
        AddTriangles(*solid.compound);
      else
        AddPieces(*solid.compound);
      break;
  }
}

template <typename Real>
Chord<Real> LineShape<Real>::ClosedForm(const Vec<Real>& from, const Vec<Real>& along) const {
  switch (kind_) {
    case Kind::kEllipsoid:
      return EllipsoidChord(sides_half_, from, along);
    case Kind::kCuboid:
      return CuboidChord(sides_half_, from, along);
    case Kind::kCylinder:
      return CylinderChord(sides_half_, from, along);
    case Kind::kCone:
      return ConeChord(sides_half_, from, along);
    case Kind::kCapsule:
      return CapsuleChord(sides_half_, straight_, from, along);
    case Kind::kTetrahedron:
      return TetrahedronChord(sides_half_, from, along);
    case Kind::kSuperellipsoid:
      return SuperellipsoidChord(sides_half_, e1_, e2_, from, along);
    case Kind::kPieces:
    case Kind::kTriangles:
      break;
  }
  CDB_CHECK(false);
}

template <typename Real>
Chord<Real> LineShape<Real>::PieceChord(std::size_t piece, const Vec<Real>& from,
                                        const Vec<Real>& along) const {
  Chord<Real> chord;
  for (std::uint32_t i = first_plane_[piece]; i < first_plane_[piece + 1]; ++i) {
    chord.Cut(from, along, planes_[i].normal, planes_[i].offset);
    if (chord.IsNone()) break;
  }
  return chord;
}

template <typename Real>
void LineShape<Real>::AddPieces(const objects::Compound& compound) {
  std::vector<FloatBox> boxes;
  Eigen::AlignedBox3d all;
  const double size = compound.sides().maxCoeff();
  first_plane_.push_back(0);
  for (std::size_t piece = 0; piece < compound.form().pieces.size(); ++piece) {
    const objects::ConvexPiece& form = compound.form().pieces[piece];
    Eigen::AlignedBox3d box;
    for (std::size_t i = 0; i < form.vertices.size(); ++i) box.extend(compound.Corner(piece, i));
    std::vector<std::pair<Vector3d, double>> planes;
    for (const meshes::Triangle& face : form.faces) {
      const Vector3d a = compound.Corner(piece, face[0]), b = compound.Corner(piece, face[1]),
                     c = compound.Corner(piece, face[2]);
      const Vector3d normal = (b - a).cross(c - a).normalized();
      // A face without area, between others.
      if (!(normal.squaredNorm() > 0.5)) continue;
      // No corner is beyond, whatever the rounding.
      double offset = normal.dot(a);
      for (std::size_t i = 0; i < form.vertices.size(); ++i)
        offset = std::max(offset, normal.dot(compound.Corner(piece, i)));
      const bool is_known = std::ranges::any_of(planes, [&](const auto& plane) {
        return AreSame(normal, offset, plane.first, plane.second, size);
      });
      if (!is_known) planes.emplace_back(normal, offset);
    }
    for (const auto& [normal, offset] : planes)
      planes_.push_back({normal.template cast<Real>(), static_cast<Real>(offset)});
    first_plane_.push_back(static_cast<std::uint32_t>(planes_.size()));
    boxes.push_back(BoxAround(box.min(), box.max()));
    all.extend(box);
  }
  SetBoxes(boxes, all);
}

template <typename Real>
void LineShape<Real>::AddTriangles(const objects::Compound& surface) {
  std::vector<FloatBox> boxes;
  Eigen::AlignedBox3d all;
  const std::size_t count = surface.form().PieceCount();
  corners_.reserve(3 * count);
  boxes.reserve(count);
  for (std::size_t triangle = 0; triangle < count; ++triangle) {
    Eigen::AlignedBox3d box;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vector3d point = surface.Corner(triangle, corner);
      corners_.push_back(point.template cast<Real>());
      box.extend(point);
    }
    boxes.push_back(BoxAround(box.min(), box.max()));
    all.extend(box);
  }
  SetBoxes(boxes, all);
}

template <typename Real>
void LineShape<Real>::SetBoxes(const std::vector<FloatBox>& boxes, const Eigen::AlignedBox3d& all) {
  half_ = (all.sizes() / 2).template cast<Real>();
  middle_ = all.center().template cast<Real>();
  if (boxes.size() > kFewPieces) tree_.Build(boxes);
}

template class LineShape<float>;
template class LineShape<double>;

}  // namespace cdb::queries
