// The fifteen axes that can separate two boxes: Gottschalk, Lin & Manocha, OBBTree, 1996.
#pragma once

#include <algorithm>
#include <cmath>

#include "library/detectors/narrow/kernels.h"
#include "library/detectors/narrow/lanes.h"

namespace cdb::narrow {
namespace {  // as lanes.h

/// Edges whose angle has a sine with a smaller square count as parallel.
constexpr double kParallel = 1e-16;

/// The coordinates of a vector, and the axes of a pose.
inline const double* Of(const Vec3& v) { return &v.x; }
inline const Vec3* AxesIn(const Pose& pose) { return &pose.x; }

/// An axis: 0 to 2 are the normals of the faces of a, 3 to 5 of those of b, and 6 + 3 i + j is
/// across edges i of a and j of b.
struct Best {
  int axis = -1;
  double gap = -kernels::kInfinity;  ///< m, along the axis
  void Offer(int of, double other) {
    if (other > gap) gap = other, axis = of;
  }
};

/// Two boxes, and the products of their axes.
class BoxAxes {
 public:
  BoxAxes(const Placed& a, const Placed& b)
      : a_(a), b_(b), between_(b.pose.position - a.pose.position) {
    const Vec3 *of_a = AxesIn(a.pose), &x = b.pose.x, &y = b.pose.y, &z = b.pose.z;
    const Lanes bx = Make(x.x, y.x, z.x), by = Make(x.y, y.y, z.y), bz = Make(x.z, y.z, z.z);
    for (int i = 0; i < 3; ++i) {
      rows_[i] = of_a[i].x * bx + of_a[i].y * by + of_a[i].z * bz;
      Store(rows_[i], turn_[i]);
      in_a_[i] = Dot(of_a[i], between_);
    }
    lanes_in_b_ = between_.x * bx + between_.y * by + between_.z * bz;
    Store(lanes_in_b_, in_b_);
  }

  /// The axis along which the boxes overlap the least or are the farthest apart; or the first found
  /// along which they are farther apart than kNear.
  Best FindBest() const {
    Best best;
    const double *half_a = Of(a_.piece.half), *half_b = Of(b_.piece.half);
    const Lanes sizes[] = {Abs(rows_[0]), Abs(rows_[1]), Abs(rows_[2])};
    const Lanes halves = Make(half_b[0], half_b[1], half_b[2]);
    for (int i = 0; i < 3; ++i) {
      double along[4];
      Store(sizes[i] * halves, along);
      best.Offer(i, std::abs(in_a_[i]) - half_a[i] - (along[0] + along[1] + along[2]));
    }
    double faces[4];
    Store(Abs(lanes_in_b_) - halves -
              (half_a[0] * sizes[0] + half_a[1] * sizes[1] + half_a[2] * sizes[2]),
          faces);
    for (int j = 0; j < 3; ++j) best.Offer(3 + j, faces[j]);
    // Of boxes that lie on each other, edges across them separate as well: faces are preferred.
    const double preference = kSameGap * std::min(a_.piece.bound, b_.piece.bound);
    best.gap += preference;
    const int of_face = best.axis;
    for (int i = 0; i < 3 && best.gap <= kNear; ++i)
      OfferEdges(i, sizes[(i + 1) % 3], sizes[(i + 2) % 3], halves, best);
    if (best.axis == of_face) best.gap -= preference;
    return best;
  }

  /// The unit normal across edges i of a and j of b, in world axes, from b to a.
  Vec3 NormalOfEdges(int i, int j) const {
    const Vec3 way = Normalized(Cross(AxesIn(a_.pose)[i], AxesIn(b_.pose)[j]));
    return Dot(way, between_) > 0 ? -way : way;
  }

  /// Axis i of a times axis j of b.
  double Turn(int i, int j) const { return turn_[i][j]; }
  /// From the position of a to that of b: in world axes, along an axis of a, and of b.
  const Vec3& between() const { return between_; }
  double InA(int i) const { return in_a_[i]; }
  double InB(int j) const { return in_b_[j]; }

 private:
  /// Those of edge i of a, across which p and q are axes of a, and all of b. The size of b is
  /// computed from its products with the axis: in single precision axes are not quite orthogonal,
  /// which matters where edges are nearly parallel.
  [[gnu::always_inline]] void OfferEdges(int i, const Lanes& size_p, const Lanes& size_q,
                                         const Lanes& halves, Best& best) const {
    const int ip = (i + 1) % 3, iq = (i + 2) % 3;
    const Lanes &p = rows_[ip], &q = rows_[iq];
    const Lanes of_next = Abs(Next(q) * p - Next(p) * q);
    const Lanes gap = Abs(in_a_[iq] * p - in_a_[ip] * q) - Of(a_.piece.half)[ip] * size_q -
                      Of(a_.piece.half)[iq] * size_p - Next(halves) * of_next -
                      Next(Next(halves)) * Next(Next(of_next));
    const Lanes square = p * p + q * q;
    const Doubles bound = Doubles{} + best.gap * best.gap, none = Doubles{};
    const bool is_apart = best.gap >= 0;
    unsigned better = Bits([&](std::size_t k) {
      const Doubles limit = bound * square.part[k], gaps = gap.part[k];
      const auto is_above = kernels::AtMost(none, gaps);
      const auto beyond = kernels::AtMost(limit, gaps * gaps);
      const auto within = kernels::AtMost(gaps * gaps, limit);
      return (is_apart ? is_above & beyond : is_above | within) &
             kernels::AtMost(none + kParallel, square.part[k]);
    });
    if (better == 0) return;
    double gaps[4], squares[4];
    Store(gap, gaps);
    Store(square, squares);
    for (; better != 0; better &= better - 1) {
      const int j = __builtin_ctz(better);
      best.Offer(6 + 3 * i + j, gaps[j] / std::sqrt(squares[j]));
    }
  }

  const Placed &a_, &b_;
  const Vec3 between_;
  Lanes rows_[3], lanes_in_b_;
  double turn_[3][4], in_a_[3], in_b_[4];
};

/// Half of a box's size along a direction, times the length of that.
inline double HalfSize(const Placed& box, const Vec3& direction) {
  const Vec3 *axes = AxesIn(box.pose), &half = box.piece.half;
  return half.x * std::abs(Dot(axes[0], direction)) + half.y * std::abs(Dot(axes[1], direction)) +
         half.z * std::abs(Dot(axes[2], direction));
}

/// Whether the boxes are too far apart along an axis of an earlier cycle.
inline bool AreApart(const Placed& a, const Placed& b, int axis) {
  const Vec3 between = b.pose.position - a.pose.position;
  if (axis < 6) {
    const Placed &of = axis < 3 ? a : b, &other = axis < 3 ? b : a;
    const Vec3& way = AxesIn(of.pose)[axis % 3];
    return std::abs(Dot(way, between)) - Of(of.piece.half)[axis % 3] - HalfSize(other, way) >
           kNear * (1 + 1e-6);
  }
  const Vec3 way = Cross(AxesIn(a.pose)[(axis - 6) / 3], AxesIn(b.pose)[(axis - 6) % 3]);
  const double gap = std::abs(Dot(way, between)) - HalfSize(a, way) - HalfSize(b, way);
  return gap > 0 && gap * gap > kNear * kNear * SquaredNorm(way) * (1 + 1e-6);
}

}  // namespace
}  // namespace cdb::narrow
