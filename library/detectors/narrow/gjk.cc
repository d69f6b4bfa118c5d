// The distance of two convex cores: Gilbert, Johnson & Keerthi, A fast procedure for computing the
// distance between complex objects in three-dimensional space, 1988. The nearest points of a
// simplex are found by its Voronoi regions: Ericson, Real-Time Collision Detection, 2005, section
// 5.1.
#include <algorithm>
#include <limits>

#include "library/detectors/narrow/couple.h"

namespace cdb::narrow {
namespace {

/// Up to three vertices of a simplex, by index, and the weights of those in its point that is
/// nearest to the origin.
struct Part {
  int vertex[3] = {};
  double weight[3] = {};
  int count = 0;  ///< 0: the origin is inside
};

struct Simplex {
  DifferenceVertex vertex[4];
  double weight[4];
  int count = 0;

  const Vec3& At(int i) const { return vertex[i].at; }
  Vec3 PointOf(const Part& part) const {
    Vec3 sum = {};
    for (int i = 0; i < part.count; ++i) sum = sum + part.weight[i] * vertex[part.vertex[i]].at;
    return sum;
  }
  void Keep(const Part& part) {
    DifferenceVertex kept[3];
    for (int i = 0; i < part.count; ++i) kept[i] = vertex[part.vertex[i]];
    std::copy_n(kept, part.count, vertex);
    std::copy_n(part.weight, part.count, weight);
    count = part.count;
  }
};

Part NearestOfSegment(const Simplex& simplex) {
  const Vec3 &a = simplex.At(0), along = simplex.At(1) - a;
  const double t = -Dot(a, along), square = SquaredNorm(along);
  if (t <= 0 || !(square > 0)) return {{0}, {1}, 1};
  if (t >= square) return {{1}, {1}, 1};
  return {{0, 1}, {1 - t / square, t / square}, 2};
}

Part NearestOfTriangle(const Simplex& simplex, int i, int j, int k) {
  const Vec3 &a = simplex.At(i), &b = simplex.At(j), &c = simplex.At(k);
  const Vec3 ab = b - a, ac = c - a;
  const double d1 = -Dot(ab, a), d2 = -Dot(ac, a);
  if (d1 <= 0 && d2 <= 0) return {{i}, {1}, 1};
  const double d3 = -Dot(ab, b), d4 = -Dot(ac, b);
  if (d3 >= 0 && d4 <= d3) return {{j}, {1}, 1};
  const double d5 = -Dot(ab, c), d6 = -Dot(ac, c);
  if (d6 >= 0 && d5 <= d6) return {{k}, {1}, 1};
  // The areas of the triangles that the origin's projection forms with the sides.
  const Vec3 across = Cross(ab, ac);
  const double of_c = Dot(across, Cross(a, b)), of_a = Dot(across, Cross(b, c)),
               of_b = Dot(across, Cross(c, a));
  if (of_c <= 0 && d1 >= 0 && d3 <= 0) {
    const double t = d1 / (d1 - d3);
    return {{i, j}, {1 - t, t}, 2};
  }
  if (of_b <= 0 && d2 >= 0 && d6 <= 0) {
    const double t = d2 / (d2 - d6);
    return {{i, k}, {1 - t, t}, 2};
  }
  if (of_a <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {{j, k}, {1 - t, t}, 2};
  }
  const double sum = of_a + of_b + of_c;
  return {{i, j, k}, {of_a / sum, of_b / sum, of_c / sum}, 3};
}

Part NearestOfTetrahedron(const Simplex& simplex) {
  constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 1, 3, 2}, {1, 2, 3, 0}};
  Part best;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [i, j, k, other] : kFaces) {
    const Vec3& a = simplex.At(i);
    const Vec3 across = Cross(simplex.At(j) - a, simplex.At(k) - a);
    const double of_origin = -Dot(across, a), of_other = Dot(across, simplex.At(other) - a);
    if (of_origin * of_other > 0) continue;  // on the inner side
    const Part part = NearestOfTriangle(simplex, i, j, k);
    const double square = SquaredNorm(simplex.PointOf(part));
    if (square >= least) continue;
    least = square;
    best = part;
  }
  return best;
}

Part NearestOf(const Simplex& simplex) {
  switch (simplex.count) {
    case 1:
      return {{0}, {1}, 1};
    case 2:
      return NearestOfSegment(simplex);
    case 3:
      return NearestOfTriangle(simplex, 0, 1, 2);
    default:
      return NearestOfTetrahedron(simplex);
  }
}

bool Holds(const Simplex& simplex, const Vec3& at) {
  for (int i = 0; i < simplex.count; ++i) {
    const Vec3& vertex = simplex.At(i);
    if (vertex.x == at.x && vertex.y == at.y && vertex.z == at.z) return true;
  }
  return false;
}

Separation Apart(const Couple& couple, const Simplex& simplex, const Vec3& nearest) {
  Separation found{.normal = Normalized(nearest), .gap = Norm(nearest), .on_a = {}, .on_b = {}};
  // Of a face, the normal does not suffer from a short distance.
  if (simplex.count == 3) {
    const Vec3& a = simplex.vertex[0].at;
    const Vec3 across = Normalized(Cross(simplex.vertex[1].at - a, simplex.vertex[2].at - a));
    const Vec3 normal = Dot(across, nearest) < 0 ? -across : across;
    if (couple.Gap(normal) >= couple.Gap(found.normal)) found.normal = normal;
  }
  found.gap = couple.Gap(found.normal);
  for (int i = 0; i < simplex.count; ++i) {
    found.on_a = found.on_a + simplex.weight[i] * simplex.vertex[i].on_a;
    found.on_b = found.on_b + simplex.weight[i] * simplex.vertex[i].on_b;
  }
  return found;
}

/// In rounding errors: cores that are no farther apart touch. Of a shorter distance the direction
/// is not known, and an expanding polytope finds the normal better.
constexpr double kTouching = 2e6;
constexpr int kMostSteps = 100;

}  // namespace

Separation Separate(const Couple& couple, const Vec3& axis, double reach) {
  Simplex simplex;
  Vec3 nearest = axis;
  double square = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kMostSteps; ++step) {
    const DifferenceVertex vertex = couple.Support(-nearest);
    const double length = Norm(nearest), along = Dot(vertex.at, nearest) / length;
    if (along > reach)
      return {.normal = 1 / length * nearest, .gap = along, .on_a = {}, .on_b = {}};
    // No vertex is closer to the origin along the way: the nearest point is the nearest of all.
    if (simplex.count > 0 && (length - along <= couple.rounding || Holds(simplex, vertex.at)))
      return Apart(couple, simplex, nearest);
    simplex.vertex[simplex.count++] = vertex;
    const Part part = NearestOf(simplex);
    const Vec3 next = simplex.PointOf(part);
    const double next_square = SquaredNorm(next);
    if (part.count == 0 || next_square <= kTouching * kTouching * couple.rounding * couple.rounding)
      return Expand(couple, simplex.vertex, simplex.count);
    if (!(next_square < square)) {  // by rounding
      --simplex.count;
      return Apart(couple, simplex, nearest);
    }
    simplex.Keep(part);
    square = next_square;
    nearest = next;
  }
  return Apart(couple, simplex, nearest);
}

}  // namespace cdb::narrow
