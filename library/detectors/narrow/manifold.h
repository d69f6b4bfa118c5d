// Contact points of two bodies: a manifold.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "library/detectors/narrow/couple.h"

namespace cdb::narrow {

/// A contact point of two pieces.
struct Point {
  Vec3 on_b;
  Vec3 normal;  ///< unit, from b to a
  double gap;   ///< m: negative if they overlap
};

/// At most so many points are kept, as Bullet does.
inline constexpr std::size_t kMostPoints = 4;

/// Largest sine of the angle between the tangent plane and a capsule's axis or a straight line on a
/// curved surface at which it lies on the other body rather than stands.
inline constexpr double kLying = 0.1;

/// In sizes of the smaller piece: gaps that differ by less are equal. In single precision, the axes
/// of a pose are orthogonal to about a third of it.
inline constexpr double kSameGap = 3e-7;

/// The points of a pair of pieces, and the memory to find them.
class Manifold {
 public:
  void Clear() { size_ = 0; }
  void Add(const Vec3& on_b, const Vec3& normal, double gap) {
    if (size_ == points_.size()) points_.resize(2 * size_ + 8);
    points_[size_++] = {on_b, normal, gap};
  }
  std::span<Point> points() { return {points_.data(), size_}; }
  std::span<const Point> points() const { return {points_.data(), size_}; }

  /// Keeps four points that hold the bodies as all of them would: the deepest, the farthest from
  /// it, and those with which they span the largest area. All have about the same normal. Points
  /// within `slop` m of the deepest count as equally deep, so that the choice is stable. Source:
  /// Gregorius, Robust contact creation for physics simulations, GDC 2015.
  void Reduce(double slop);

 private:
  std::vector<Point> points_;
  std::size_t size_ = 0;
};

/// The face whose normal is nearest to `direction`, of a piece that has faces.
const FlatFace& FacingFace(const Piece& piece, const Vec3& direction);

/// m: how far a point, in the frame of the piece, is from the boundary of one of its flat faces,
/// seen along the normal, or somewhat less; negative if it is not over the face.
double InsetOf(const Piece& piece, const FlatFace& face, const Vec3& point);

/// The flat feature of a piece that faces along a unit vector: a face, a line or neither.
struct Facing {
  const FlatFace* face = nullptr;
  bool is_line = false;
  Vec3 from = {}, to = {};  ///< of the line, on the surface
};
Facing FacingOf(const Piece& piece, const Vec3& direction);

/// Adds the points of two pieces whose cores have this separation, in the frame of a: the facing
/// features, seen along the normal, intersect in a polygon, and its corners are points if their gap
/// is at most kNear. False if none of them has the gap of the separation. Ignores its nearest
/// points.
bool AddFacingPoints(const Couple& couple, const Separation& separation, Manifold& manifold);

/// Adds a point that is deeper than all others, in place of one that is close to it.
void AddDeepest(const Vec3& on_b, const Vec3& normal, double gap, double beside,
                Manifold& manifold);

/// m: points of a manifold less than this from a deeper one add nothing to it.
double BesideOf(const Piece& piece);

/// In radii of the smaller piece: how far a contact is from the surface of a curved one at most, if
/// features that touch there can be found.
inline constexpr double kSamePlace = 1e-4;

/// Moves the points of a separation, of which normal and gap are known, to where the facing
/// features touch, and to the distance of the gap along the normal, if they are not there.
void Meet(const Couple& couple, Separation& separation);

/// Adds its nearest points.
void AddNearest(const Couple& couple, const Separation& separation, Manifold& manifold);

}  // namespace cdb::narrow
