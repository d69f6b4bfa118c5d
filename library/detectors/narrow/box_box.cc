// Two boxes. Their shortest separating translation is along the normal of a face or across two
// edges: Gottschalk, Lin & Manocha, OBBTree, 1996. The points are those of the facing faces.
#include <algorithm>
#include <cmath>

#include "library/detectors/narrow/kernels.h"

namespace cdb::narrow {
namespace {

// The axes: 0 to 2 of the faces of a, 3 to 5 of those of b, 6 + 3 i + j across edges i of a and j
// of b.
constexpr int kAxes = 15;
/// Edges whose angle has a sine with a smaller square count as parallel.
constexpr double kParallel = 1e-16;

/// The numbers of a vector.
inline const double* Of(const Vec3& v) { return &v.x; }

/// Whether the boxes are too far apart along an axis.
bool AreApart(const Placed& a, const Placed& b, int axis) {
  const Rotation of_a = AxesOf(a.pose), of_b = AxesOf(b.pose);
  const Vec3* columns[] = {&of_a.x, &of_b.x};
  const Vec3 way = axis < 3   ? columns[0][axis]
                   : axis < 6 ? columns[1][axis - 3]
                              : Cross(columns[0][(axis - 6) / 3], columns[1][(axis - 6) % 3]);
  const double gap = std::abs(Dot(way, b.pose.position - a.pose.position)) -
                     Extent(a.piece, Inverse(of_a, way)) - Extent(b.piece, Inverse(of_b, way));
  const double square = axis < 6 ? 1 : SquaredNorm(way);
  return gap > 0 && gap * gap > kNear * kNear * square * (1 + 1e-6);
}

/// The axis along which the boxes overlap the least or are the farthest apart.
struct Best {
  int axis = -1;
  double gap = -kernels::kInfinity;
  void Offer(int of, double other) {
    if (other > gap) gap = other, axis = of;
  }
};

class Test {
 public:
  explicit Test(const Couple& couple)
      : couple_(couple), half_a_(couple.a.half), half_b_(couple.b.half) {
    const Vec3* columns = &couple.turn.x;
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        turn_[i][j] = Of(columns[j])[i];
        size_[i][j] = std::abs(turn_[i][j]);
      }
  }

  /// Stops at the first axis along which they are farther apart than kNear.
  Best FindBest() const {
    Best best;
    const double *half_a = Of(half_a_), *half_b = Of(half_b_), *place = Of(couple_.place);
    for (int i = 0; i < 3; ++i)
      best.Offer(i, std::abs(place[i]) - half_a[i] - size_[i][0] * half_b[0] -
                        size_[i][1] * half_b[1] - size_[i][2] * half_b[2]);
    if (best.gap > kNear) return best;
    for (int j = 0; j < 3; ++j)
      best.Offer(3 + j, std::abs(Dot((&couple_.turn.x)[j], couple_.place)) - half_b[j] -
                            size_[0][j] * half_a[0] - size_[1][j] * half_a[1] -
                            size_[2][j] * half_a[2]);
    if (best.gap > kNear) return best;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) OfferEdges(i, j, best);
    return best;
  }

  /// The unit axis in the frame of a, from b to a.
  Vec3 NormalOf(int axis) const {
    Vec3 way = {0, 0, 0};
    if (axis < 3)
      (&way.x)[axis] = 1;
    else if (axis < 6)
      way = (&couple_.turn.x)[axis - 3];
    else
      way = Normalized(Across((axis - 6) / 3, (axis - 6) % 3));
    return Dot(way, couple_.place) > 0 ? -way : way;
  }

  /// The nearest points of the two edges that face each other; false if they are beyond the ends.
  bool EdgePoints(int i, int j, Separation& separation) const {
    const Vec3 in_b = Inverse(couple_.turn, separation.normal);
    Vec3 on_a, corner_b;
    for (int k = 0; k < 3; ++k) {
      (&on_a.x)[k] = k == i ? 0 : std::copysign(Of(half_a_)[k], -Of(separation.normal)[k]);
      (&corner_b.x)[k] = k == j ? 0 : std::copysign(Of(half_b_)[k], Of(in_b)[k]);
    }
    const Vec3 on_b = couple_.ToA(corner_b), along_b = (&couple_.turn.x)[j], between = on_b - on_a;
    // Along edge i of a, s; along edge j of b, t.
    const double cosine = turn_[i][j], d = Of(between)[i], e = Dot(along_b, between);
    const double s = (d - cosine * e) / (1 - cosine * cosine), t = cosine * s - e;
    separation.on_a = on_a;
    (&separation.on_a.x)[i] = std::clamp(s, -Of(half_a_)[i], Of(half_a_)[i]);
    const double held = std::clamp(t, -Of(half_b_)[j], Of(half_b_)[j]);
    separation.on_b = on_b + held * along_b;
    const double slop = 1e-9 * couple_.a.bound;
    return std::abs(s) <= Of(half_a_)[i] + slop && std::abs(t) <= Of(half_b_)[j] + slop;
  }

 private:
  Vec3 Across(int i, int j) const {
    Vec3 unit = {0, 0, 0};
    (&unit.x)[i] = 1;
    return Cross(unit, (&couple_.turn.x)[j]);
  }

  /// The sizes of b along the axis are computed rather than read from the table: in single precision
  /// its axes are not quite orthogonal, which matters where edges are nearly parallel.
  void OfferEdges(int i, int j, Best& best) const {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    const double square = turn_[i1][j] * turn_[i1][j] + turn_[i2][j] * turn_[i2][j];
    if (square < kParallel) return;
    const double *half_a = Of(half_a_), *half_b = Of(half_b_), *place = Of(couple_.place);
    const auto along = [&](double first, double second) {
      return std::abs(second * turn_[i1][j] - first * turn_[i2][j]);
    };
    const double gap = along(place[i1], place[i2]) - half_a[i1] * size_[i2][j] -
                       half_a[i2] * size_[i1][j] - half_b[j1] * along(turn_[i1][j1], turn_[i2][j1]) -
                       half_b[j2] * along(turn_[i1][j2], turn_[i2][j2]);
    best.Offer(6 + 3 * i + j, gap / std::sqrt(square));
  }

  const Couple& couple_;
  const Vec3 half_a_, half_b_;
  double turn_[3][3], size_[3][3];  ///< products of axis i of a with axis j of b, and their sizes
};

/// Adds the points of boxes that are farther apart than along each of the axes, as none of their
/// features face each other.
void AddSideBySide(const Couple& couple, const Vec3& axis, Manifold& manifold) {
  manifold.Clear();
  const Separation separation = Separate(couple, axis, kNear);
  if (separation.gap > kNear) return;
  if (!AddFacingPoints(couple, separation, manifold)) AddNearest(couple, separation, manifold);
}

}  // namespace

void BoxBox(const Placed& a, const Placed& b, Hint& hint, Manifold& manifold) {
  if (hint.box_axis >= 0 && AreApart(a, b, hint.box_axis)) return;
  const Couple couple(a.piece, a.pose, b.piece, b.pose);
  const Test test(couple);
  const Best best = test.FindBest();
  hint.box_axis = best.axis;
  if (best.gap > kNear) return;
  Separation separation{test.NormalOf(best.axis), best.gap, {}, {}};
  if (!AddFacingPoints(couple, separation, manifold)) {
    const bool has_edges =
        best.axis >= 6 && test.EdgePoints((best.axis - 6) / 3, (best.axis - 6) % 3, separation);
    if (has_edges)
      AddNearest(couple, separation, manifold);
    else
      AddSideBySide(couple, separation.normal, manifold);
  }
  manifold.Reduce(1e-3 * std::min(a.piece.bound, b.piece.bound));
  TurnIntoWorld(a.pose, manifold);
}

}  // namespace cdb::narrow
