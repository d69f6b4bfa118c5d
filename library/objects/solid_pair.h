// The gap between the convex pieces of two solids with fixed orientations, for varying positions.
#pragma once

#include <Eigen/Core>
#include <array>

#include "library/objects/solid.h"

namespace cdb::objects {

struct Gap {
  double distance = 0;  ///< m; 0 if they touch or overlap
  /// Unit, from the nearest point of the first piece to that of the second; zero if they touch.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
};

/// The solids must outlive it. Threads: any.
class SolidPair {
 public:
  SolidPair(const Solid& a, const Eigen::Quaterniond& turn_a, const Solid& b,
            const Eigen::Quaterniond& turn_b);

  /// m: the scale of rounding.
  double size() const { return size_; }
  /// Whether they overlap or touch with b's centre of mass at `offset` from a's.
  bool Overlap(const Eigen::Vector3d& offset) const;
  /// Calls `visit(piece_a, piece_b)` until a call returns true; returns whether one did.
  template <typename Visit>
  bool AnyPieces(Visit visit) const {
    for (std::size_t i = 0; i < a_.PieceCount(); ++i)
      for (std::size_t j = 0; j < b_.PieceCount(); ++j)
        if (visit(i, j)) return true;
    return false;
  }
  /// Whether a pair of pieces overlaps or touches.
  bool PiecesOverlap(std::size_t piece_a, std::size_t piece_b, const Eigen::Vector3d& offset) const;
  /// Whether one of the two is a surface around solid cells, in which a piece of the other is
  /// without meeting a triangle; for pairs of which no pieces overlap.
  bool IsInCells(const Eigen::Vector3d& offset) const;
  Gap PieceGap(std::size_t piece_a, std::size_t piece_b, const Eigen::Vector3d& offset) const;

 private:
  /// For a pair of which one is a surface.
  bool SurfaceOverlaps(const Eigen::Vector3d& offset) const;
  enum class Goal { kWhetherApart, kDistance };
  bool AreBalls() const { return a_.IsBall() && b_.IsBall(); }
  /// The gap of convex parts, each given by its support function.
  template <typename PartOfA, typename PartOfB>
  Gap GapOf(const PartOfA& part_a, const PartOfB& part_b, const Eigen::Vector3d& offset,
            Goal goal) const;

  const Solid &a_, &b_;
  Eigen::Matrix3d turn_a_, turn_b_;
  double size_;
};

/// For a surface around solid cells: whether a point of a piece of `other`, whose centre of mass is
/// at `offset` from that of the surface, is in a cell. If the piece meets no triangle, all of it
/// is.
bool AnyPieceIsInCells(const Solid& surface, const Eigen::Matrix3d& turn, const Solid& other,
                       const Eigen::Matrix3d& other_turn, const Eigen::Vector3d& offset);

// The distance subalgorithm of GJK: the part of a simplex nearest to the origin.

/// One to four points.
struct Simplex {
  std::array<Eigen::Vector3d, 4> points;
  int size = 0;
};

/// The point of the convex hull of the simplex nearest to the origin; reduces the simplex to the
/// corners whose hull contains it. Zero, and all four corners, if the origin is inside a
/// tetrahedron. `noise`: the error of each coordinate; a flatter tetrahedron has no inside. Any
/// unit. Source: Voronoi regions as in C. Ericson, Real-Time Collision Detection, 5.1, decided at
/// the projected point, where little is lost in rounding.
Eigen::Vector3d ReduceToNearest(Simplex& simplex, double noise);

}  // namespace cdb::objects
