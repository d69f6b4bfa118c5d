// The distance of two convex cores: Gilbert, Johnson & Keerthi, A fast procedure for computing the
// distance between complex objects in three-dimensional space, 1988. The nearest points of a
// simplex are found by its Voronoi regions: Ericson, Real-Time Collision Detection, 2005, section
// 5.1.
#include <algorithm>
#include <limits>

#include "library/detectors/narrow/couple.h"

namespace cdb::narrow {
namespace {

/// Up to four vertices of the difference, and the point of their hull that is nearest to the
/// origin: the sum of the vertices by weight.
struct Simplex {
  DifferenceVertex vertex[4];
  double weight[4];
  int count = 0;

  Vec3 Nearest() const {
    Vec3 sum = {};
    for (int i = 0; i < count; ++i) sum = sum + weight[i] * vertex[i].at;
    return sum;
  }
  void Keep(std::initializer_list<int> kept, std::initializer_list<double> weights) {
    DifferenceVertex copy[3];
    int at = 0;
    for (const int i : kept) copy[at++] = vertex[i];
    std::copy_n(copy, at, vertex);
    std::copy(weights.begin(), weights.end(), weight);
    count = at;
  }
};

void ReduceSegment(Simplex& simplex) {
  const Vec3 &a = simplex.vertex[0].at, &b = simplex.vertex[1].at, along = b - a;
  const double t = -Dot(a, along), square = SquaredNorm(along);
  if (t <= 0 || !(square > 0)) return simplex.Keep({0}, {1});
  if (t >= square) return simplex.Keep({1}, {1});
  simplex.Keep({0, 1}, {1 - t / square, t / square});
}

void ReduceTriangle(Simplex& simplex) {
  const Vec3 &a = simplex.vertex[0].at, &b = simplex.vertex[1].at, &c = simplex.vertex[2].at;
  const Vec3 ab = b - a, ac = c - a;
  const double d1 = -Dot(ab, a), d2 = -Dot(ac, a);
  if (d1 <= 0 && d2 <= 0) return simplex.Keep({0}, {1});
  const double d3 = -Dot(ab, b), d4 = -Dot(ac, b);
  if (d3 >= 0 && d4 <= d3) return simplex.Keep({1}, {1});
  const double d5 = -Dot(ab, c), d6 = -Dot(ac, c);
  if (d6 >= 0 && d5 <= d6) return simplex.Keep({2}, {1});
  // The areas of the triangles that the origin's projection forms with the sides.
  const Vec3 across = Cross(ab, ac);
  const double of_c = Dot(across, Cross(a, b)), of_a = Dot(across, Cross(b, c)),
               of_b = Dot(across, Cross(c, a));
  if (of_c <= 0 && d1 >= 0 && d3 <= 0) {
    const double t = d1 / (d1 - d3);
    return simplex.Keep({0, 1}, {1 - t, t});
  }
  if (of_b <= 0 && d2 >= 0 && d6 <= 0) {
    const double t = d2 / (d2 - d6);
    return simplex.Keep({0, 2}, {1 - t, t});
  }
  if (of_a <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return simplex.Keep({1, 2}, {1 - t, t});
  }
  const double sum = of_a + of_b + of_c;
  simplex.Keep({0, 1, 2}, {of_a / sum, of_b / sum, of_c / sum});
}

/// False if the origin is inside.
bool ReduceTetrahedron(Simplex& simplex) {
  constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}};
  Simplex best;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& face : kFaces) {
    const Vec3 &a = simplex.vertex[face[0]].at, &b = simplex.vertex[face[1]].at,
               &c = simplex.vertex[face[2]].at, &other = simplex.vertex[face[3]].at;
    const Vec3 across = Cross(b - a, c - a);
    const double of_origin = -Dot(across, a), of_other = Dot(across, other - a);
    if (of_origin * of_other > 0) continue;  // on the inner side
    Simplex reduced = simplex;
    reduced.Keep({face[0], face[1], face[2]}, {});
    ReduceTriangle(reduced);
    const double square = SquaredNorm(reduced.Nearest());
    if (square >= least) continue;
    least = square;
    best = reduced;
  }
  if (least == std::numeric_limits<double>::infinity()) return false;
  simplex = best;
  return true;
}

/// False if the origin is inside.
bool Reduce(Simplex& simplex) {
  switch (simplex.count) {
    case 1:
      simplex.weight[0] = 1;
      return true;
    case 2:
      ReduceSegment(simplex);
      return true;
    case 3:
      ReduceTriangle(simplex);
      return true;
    default:
      return ReduceTetrahedron(simplex);
  }
}

bool Holds(const Simplex& simplex, const Vec3& at) {
  for (int i = 0; i < simplex.count; ++i) {
    const Vec3& vertex = simplex.vertex[i].at;
    if (vertex.x == at.x && vertex.y == at.y && vertex.z == at.z) return true;
  }
  return false;
}

Separation Apart(const Couple& couple, const Simplex& simplex, const Vec3& nearest) {
  Separation found{.normal = Normalized(nearest), .gap = Norm(nearest), .on_a = {}, .on_b = {}};
  // Of a face, the normal does not suffer from a short distance.
  if (simplex.count == 3) {
    const Vec3& a = simplex.vertex[0].at;
    const Vec3 across =
        Normalized(Cross(simplex.vertex[1].at - a, simplex.vertex[2].at - a));
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
    const Simplex last = simplex;
    simplex.vertex[simplex.count++] = vertex;
    const Simplex grown = simplex;
    if (!Reduce(simplex)) return Expand(couple, grown.vertex, grown.count);
    const Vec3 next = simplex.Nearest();
    const double next_square = SquaredNorm(next);
    if (next_square <= 1e6 * couple.rounding * couple.rounding)
      return Expand(couple, grown.vertex, grown.count);
    if (!(next_square < square)) return Apart(couple, last, nearest);  // by rounding
    square = next_square;
    nearest = next;
  }
  return Apart(couple, simplex, nearest);
}

}  // namespace cdb::narrow
