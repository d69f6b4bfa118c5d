// Shapes as a line meets them: closed forms, the planes of convex pieces, the triangles of
// surfaces.
//
// In the axes of the body, in single or double precision. A solid of several pieces is met where a
// piece is, as its contacts are those of its pieces: a line enters each piece by itself. Threads:
// any, once made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "library/objects/solid.h"
#include "library/queries/chord.h"
#include "library/queries/wide_tree.h"

namespace cdb::queries {

template <typename Real>
class LineShape {
 public:
  explicit LineShape(const objects::Solid& solid);

  /// Half extents of a box around it, and its middle.
  const Vec<Real>& half() const { return half_; }
  const Vec<Real>& middle() const { return middle_; }
  bool IsEllipsoid() const { return kind_ == Kind::kEllipsoid; }

  /// Calls `visit(chord, margin)` for each piece that the line through `from` meets, whether it is
  /// on the ray or not. `margin`: of a triangle, the least barycentric coordinate; 1 otherwise.
  template <typename Visit>
  void ForEveryChord(const Vec<Real>& from, const Vec<Real>& along, Visit visit) const {
    if (kind_ != Kind::kPieces && kind_ != Kind::kTriangles) {
      if (const Chord<Real> chord = ClosedForm(from, along); !chord.IsNone()) visit(chord, Real(1));
      return;
    }
    for (std::size_t piece = 0; piece < PieceCount(); ++piece) Visit1(piece, from, along, visit);
  }

  /// The same for the pieces whose boxes the ray meets before `limit`, which a call may reduce, the
  /// nearest first.
  template <typename Visit>
  void ForChordsOnRay(const Vec<Real>& from, const Vec<Real>& along, const float& limit,
                      Visit visit) const {
    if (tree_.IsEmpty()) return ForEveryChord(from, along, visit);
    const WideTree::Ray ray(from.template cast<double>(), along.template cast<double>(),
                            static_cast<double>(limit));
    tree_.ForRay(ray, limit, [&](std::size_t piece) {
      Visit1(piece, from, along, visit);
      return false;
    });
  }

 private:
  enum class Kind {
    kEllipsoid,
    kCuboid,
    kCylinder,
    kCone,
    kCapsule,
    kTetrahedron,
    kSuperellipsoid,
    kPieces,
    kTriangles
  };
  struct Plane {
    Vec<Real> normal;
    Real offset;
  };

  std::size_t PieceCount() const {
    return kind_ == Kind::kPieces ? first_plane_.size() - 1 : corners_.size() / 3;
  }
  Chord<Real> ClosedForm(const Vec<Real>& from, const Vec<Real>& along) const;
  Chord<Real> PieceChord(std::size_t piece, const Vec<Real>& from, const Vec<Real>& along) const;
  void AddPieces(const objects::Compound& compound);
  void AddTriangles(const objects::Compound& surface);
  /// `all` is around the boxes of the pieces.
  void SetBoxes(const std::vector<FloatBox>& boxes, const Eigen::AlignedBox3d& all);

  template <typename Visit>
  void Visit1(std::size_t piece, const Vec<Real>& from, const Vec<Real>& along,
              Visit& visit) const {
    Real margin = 1;
    const Chord<Real> chord = kind_ == Kind::kPieces
                                  ? PieceChord(piece, from, along)
                                  : TriangleChord(corners_[3 * piece], corners_[3 * piece + 1],
                                                  corners_[3 * piece + 2], from, along, &margin);
    if (!chord.IsNone()) visit(chord, margin);
  }

  Kind kind_;
  Vec<Real> half_, middle_ = Vec<Real>::Zero();
  Vec<Real> sides_half_;  ///< of the closed form
  Real straight_ = 0;     ///< of a capsule
  Real e1_, e2_;          ///< of a superellipsoid
  std::vector<Plane> planes_;
  std::vector<std::uint32_t> first_plane_;  ///< of each piece, and one more
  std::vector<Vec<Real>> corners_;          ///< three for each triangle
  WideTree tree_;                           ///< of the pieces; empty if they are few
};

extern template class LineShape<float>;
extern template class LineShape<double>;

/// Makes and owns shapes; equal solids share one. Not thread-safe.
template <typename Real>
class LineShapes {
 public:
  const LineShape<Real>& Get(const objects::Solid& solid) {
    auto& shape = shapes_[{solid.shape, solid.compound.get(), solid.sides.x(), solid.sides.y(),
                           solid.sides.z(), solid.exponents.x(), solid.exponents.y()}];
    if (shape == nullptr) shape = std::make_unique<LineShape<Real>>(solid);
    return *shape;
  }

 private:
  std::map<
      std::tuple<objects::Shape, const objects::Compound*, double, double, double, double, double>,
      std::unique_ptr<LineShape<Real>>>
      shapes_;
};

}  // namespace cdb::queries
