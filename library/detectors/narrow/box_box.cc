// Two boxes. Of the faces that face each other one is the reference, and the other is clipped at
// its sides: Gregorius, The separating axis test between convex polyhedra, GDC 2013.
#include <algorithm>
#include <cmath>

#include "library/detectors/narrow/box_axes.h"
#include "library/detectors/narrow/kernels.h"

namespace cdb::narrow {
namespace {

/// Least cosine of faces and the normal of two edges at which the faces lie on each other.
constexpr double kFlat = 0.98;

/// A corner of the incident face, in the axes of the reference face: along its sides, and above the
/// centre of its box.
struct Corner {
  double at[3];
};

/// The part of the polygon with |at[side]| at most `half`. Returns the number of its corners.
template <int side>
std::size_t ClipAtSides(Corner* corners, std::size_t count, double half) {
  Corner clipped[10];
  for (const double sign : {1.0, -1.0}) {
    std::size_t made = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const Corner &here = corners[i], &next = corners[i + 1 == count ? 0 : i + 1];
      const double out_here = sign * here.at[side] - half, out_next = sign * next.at[side] - half;
      if (out_here <= 0) clipped[made++] = here;
      if ((out_here < 0 && out_next > 0) || (out_here > 0 && out_next < 0)) {
        const double part = out_here / (out_here - out_next);
        Corner& corner = clipped[made++];
        for (int k = 0; k < 3; ++k) corner.at[k] = here.at[k] + part * (next.at[k] - here.at[k]);
        corner.at[side] = sign * half;
      }
    }
    std::copy_n(clipped, made, corners);
    count = made;
  }
  return count;
}

/// The face of the one box whose normal separates them best, and the other box.
struct Reference {
  const Placed &of, &incident;
  bool is_a;
  int axis;
  double sign;  ///< of the axis that points to the other box

  Vec3 Outwards() const { return sign * AxesIn(of.pose)[axis]; }
  Vec3 Normal() const { return is_a ? -Outwards() : Outwards(); }
};

/// The corners of the face of the incident box that faces the reference, clipped.
std::size_t IncidentCorners(const BoxAxes& axes, const Reference& reference, Corner* corners) {
  const int across[] = {(reference.axis + 1) % 3, (reference.axis + 2) % 3, reference.axis};
  const auto turn = [&](int of_reference, int of_incident) {
    return reference.is_a ? axes.Turn(of_reference, of_incident)
                          : axes.Turn(of_incident, of_reference);
  };
  int facing = 0;
  for (int m = 1; m < 3; ++m)
    if (std::abs(turn(reference.axis, m)) > std::abs(turn(reference.axis, facing))) facing = m;
  const double* half = Of(reference.incident.piece.half);
  const double side =
      half[facing] * (reference.sign * turn(reference.axis, facing) > 0 ? -1.0 : 1.0);
  const int m1 = (facing + 1) % 3, m2 = (facing + 2) % 3;
  double first[3], second[3], middle[3];
  for (int k = 0; k < 3; ++k) {
    const double sign = k == 2 ? reference.sign : 1;
    const double place = reference.is_a ? axes.InA(across[k]) : -axes.InB(across[k]);
    middle[k] = sign * (place + side * turn(across[k], facing));
    first[k] = sign * half[m1] * turn(across[k], m1);
    second[k] = sign * half[m2] * turn(across[k], m2);
  }
  for (int k = 0; k < 3; ++k) {
    corners[0].at[k] = middle[k] + first[k] + second[k];
    corners[1].at[k] = middle[k] - first[k] + second[k];
    corners[2].at[k] = middle[k] - first[k] - second[k];
    corners[3].at[k] = middle[k] + first[k] - second[k];
  }
  const double* sides = Of(reference.of.piece.half);
  const auto reaches = [&](int k) {
    return std::abs(middle[k]) + std::abs(first[k]) + std::abs(second[k]) > sides[across[k]];
  };
  std::size_t count = 4;
  if (reaches(0)) count = ClipAtSides<0>(corners, count, sides[across[0]]);
  if (reaches(1)) count = ClipAtSides<1>(corners, count, sides[across[1]]);
  return count;
}

/// Adds the points of a face. Returns the least gap.
double AddFacePoints(const BoxAxes& axes, const Reference& reference, Manifold& manifold) {
  Corner corners[12];
  const std::size_t count = IncidentCorners(axes, reference, corners);
  const Vec3* of = AxesIn(reference.of.pose);
  const Vec3 &u = of[(reference.axis + 1) % 3], &v = of[(reference.axis + 2) % 3];
  const Vec3 outwards = reference.Outwards(), normal = reference.Normal();
  const double half = Of(reference.of.piece.half)[reference.axis];
  double least = kernels::kInfinity;
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [x, y, z] = corners[i].at;
    const double gap = z - half;
    least = std::min(least, gap);
    if (gap > kNear) continue;
    // On the incident box, or below it on the reference, whichever is b.
    const Vec3 flat = x * u + y * v;
    manifold.Add(reference.is_a ? flat + z * outwards : axes.between() + flat + half * outwards,
                 normal, gap);
  }
  return least;
}

/// The nearest points of two edges, relative to a's position; false if they are beyond the ends.
bool FindEdgePoint(const BoxAxes& axes, const Placed& a, const Placed& b, int i, int j,
                   const Vec3& normal, Vec3& on_b) {
  const Vec3 *of_a = AxesIn(a.pose), *of_b = AxesIn(b.pose);
  const double *half_a = Of(a.piece.half), *half_b = Of(b.piece.half);
  Vec3 edge_a = {0, 0, 0}, edge_b = axes.between();
  for (int k = 0; k < 3; ++k) {
    if (k != i) edge_a = edge_a + std::copysign(half_a[k], -Dot(of_a[k], normal)) * of_a[k];
    if (k != j) edge_b = edge_b + std::copysign(half_b[k], Dot(of_b[k], normal)) * of_b[k];
  }
  // The sine by the cross product, as the cosine of nearly parallel edges does not tell.
  const Vec3 between = edge_b - edge_a;
  const double square_sine = SquaredNorm(Cross(of_a[i], of_b[j])), cosine = axes.Turn(i, j);
  const double d = Dot(of_a[i], between), e = Dot(of_b[j], between);
  const double s = (d - cosine * e) / square_sine, t = (cosine * d - e) / square_sine;
  on_b = edge_b + std::clamp(t, -half_b[j], half_b[j]) * of_b[j];
  const double slop = 1e-9 * a.piece.bound;
  return std::abs(s) <= half_a[i] + slop && std::abs(t) <= half_b[j] + slop;
}

bool AreFlat(const Placed& a, const Placed& b, const Vec3& normal) {
  double most_a = 0, most_b = 0;
  for (int k = 0; k < 3; ++k) {
    most_a = std::max(most_a, std::abs(Dot(AxesIn(a.pose)[k], normal)));
    most_b = std::max(most_b, std::abs(Dot(AxesIn(b.pose)[k], normal)));
  }
  return std::min(most_a, most_b) > kFlat;
}

/// Adds the points along any normal, in general; if there are none at the gap, as the features of
/// boxes that are apart face each other side by side, those along the exact one.
void AddInGeneral(const Placed& a, const Placed& b, const Vec3& normal, double gap, Hint& hint,
                  Manifold& manifold) {
  const Couple couple(a.piece, a.pose, b.piece, b.pose);
  Separation separation{Inverse(AxesOf(a.pose), normal), gap, {}, {}};
  if (!AddFacingPoints(couple, separation, manifold)) {
    manifold.Clear();
    separation = Separate(couple, separation.normal, kNear, nullptr);
    hint.Set(separation.normal);
    if (separation.gap > kNear) return;
    if (!AddFacingPoints(couple, separation, manifold)) AddNearest(couple, separation, manifold);
  }
  TurnIntoWorld(a.pose, manifold);
}

}  // namespace

void BoxBox(const Placed& a, const Placed& b, Hint& hint, Manifold& manifold) {
  if (hint.box_axis >= 0 && AreApart(a, b, hint.box_axis)) return;
  if (AreApartAlong(a, b, hint, kNear)) return;
  const BoxAxes axes(a, b);
  const Best best = axes.FindBest();
  hint.box_axis = best.gap > kNear ? best.axis : -1;
  hint.Set({0, 0, 0});
  if (best.gap > kNear || best.axis < 0) return;  // none of a pose that is not finite
  const double tolerance = kSameGap * std::min(a.piece.bound, b.piece.bound);
  if (best.axis < 6) {
    const bool is_a = best.axis < 3;
    const int axis = best.axis % 3;
    const double way = is_a ? axes.InA(axis) : -axes.InB(axis);
    const Reference reference = {is_a ? a : b, is_a ? b : a, is_a, axis, way > 0 ? 1.0 : -1.0};
    if (!(AddFacePoints(axes, reference, manifold) <= best.gap + tolerance)) {
      manifold.Clear();
      AddInGeneral(a, b, reference.Normal(), best.gap, hint, manifold);
    }
  } else {
    const Vec3 normal = axes.NormalOfEdges((best.axis - 6) / 3, (best.axis - 6) % 3);
    Vec3 on_b;
    const bool has_point =
        FindEdgePoint(axes, a, b, (best.axis - 6) / 3, (best.axis - 6) % 3, normal, on_b);
    if (!has_point || AreFlat(a, b, normal))
      AddInGeneral(a, b, normal, best.gap, hint, manifold);
    else
      manifold.Add(on_b, normal, best.gap);
  }
  manifold.Reduce(1e-3 * std::min(a.piece.bound, b.piece.bound));
}

}  // namespace cdb::narrow
