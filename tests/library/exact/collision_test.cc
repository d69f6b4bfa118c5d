// Collisions of moving vertices, edges and triangles, without rounding.
#include "library/exact/collision.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
#include <vector>

#include "library/exact/dyadic.h"
#include "library/exact/polynomial_roots.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using exact::Dyadic;
using exact::MovingPoints;
using exact::Polynomial;

TEST(Dyadic, AddsAndMultipliesWithoutRounding) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> mantissa(-1, 1);
  std::uniform_int_distribution<int> exponent(-1000, 1000);
  const auto draw = [&] { return Dyadic(std::ldexp(mantissa(random), exponent(random))); };
  for (int i = 0; i < 2000; ++i) {
    const Dyadic a = draw(), b = draw(), c = draw();
    EXPECT_EQ((a + b - a - b).Sign(), 0);
    EXPECT_EQ(((a + b) * c - a * c - b * c).Sign(), 0);
    EXPECT_EQ(((a - b) * (a + b) - a * a + b * b).Sign(), 0);
    EXPECT_EQ((a - b).Sign(), -(b - a).Sign());
    EXPECT_EQ((a * b).Sign(), a.Sign() * b.Sign());
  }
  const Dyadic tiny(std::numeric_limits<double>::denorm_min());
  const Dyadic huge(std::numeric_limits<double>::max());
  EXPECT_EQ((huge + tiny - huge - tiny).Sign(), 0);
  EXPECT_EQ((huge + tiny - huge).Sign(), 1);
  EXPECT_EQ((Dyadic(3) * Dyadic(0.5) - Dyadic(1.5)).Sign(), 0);
  EXPECT_EQ(Dyadic(-0.0).Sign(), 0);
  EXPECT_EQ((-Dyadic(2)).Sign(), -1);
}

/// With whole coefficients, from the constant one on.
Polynomial Of(const std::vector<double>& coefficients) {
  std::vector<Dyadic> exact;
  for (const double value : coefficients) exact.emplace_back(value);
  return Polynomial(exact);
}

TEST(PolynomialRoots, AreFoundOnceEachAboveZeroAndUpToOne) {
  const auto count = [](const Polynomial& polynomial) { return RootsOf(polynomial).size(); };
  const Polynomial half = Of({-1, 2}), third = Of({-1, 3}), zero = Of({0, 1}), one = Of({-1, 1}),
                   two = Of({-2, 1});
  EXPECT_EQ(count(half * third * two), 2u);
  EXPECT_EQ(count(half * half * third), 2u);
  EXPECT_EQ(count(third * third * third), 1u);
  EXPECT_EQ(count(zero * half * one), 2u) << "0 is not one of them";
  EXPECT_EQ(count(zero * zero * zero), 0u);
  EXPECT_EQ(count(one * one), 1u);
  EXPECT_EQ(count(Of({1, 0, 1})), 0u);
  EXPECT_EQ(count(Of({3})), 0u);
  // Two roots that differ by 2^-60.
  const double near = std::ldexp(1, -60);
  EXPECT_EQ(count(Polynomial({Dyadic(-1), Dyadic(2)}) *
                  Polynomial({Dyadic(-1) - Dyadic(near), Dyadic(2)})),
            2u);
}

TEST(PolynomialRoots, HaveTheSignsOfOtherPolynomials) {
  auto roots = RootsOf(Of({-1, 0, 2}));  // the root of 1/2
  ASSERT_EQ(roots.size(), 1u);
  exact::Time& root = roots[0];
  EXPECT_EQ(root.SignOf(Of({-1, 0, 2})), 0);
  EXPECT_EQ(root.SignOf(Of({-1, 0, 2}) * Of({-1, 3})), 0);
  EXPECT_EQ(root.SignOf(Of({-1, 1, 2})), 1);
  EXPECT_EQ(root.SignOf(Polynomial()), 0);
  // The doubles next to it.
  const double below = 0.70710678118654746, above = 0.70710678118654757;
  ASSERT_LT(below * below, 0.5);
  ASSERT_EQ(std::nextafter(below, 1), above);
  EXPECT_EQ(root.SignOf(Polynomial({Dyadic(-below), Dyadic(1)})), 1);
  EXPECT_EQ(root.SignOf(Polynomial({Dyadic(-above), Dyadic(1)})), -1);
}

// Points on a coarse lattice, where most of what is degenerate happens.

class Lattice {
 public:
  explicit Lattice(unsigned seed) : random_(seed) {}
  int Whole(int least, int most) {
    return std::uniform_int_distribution<int>(least, most)(random_);
  }
  Vector3d Point(int size) { return {Coordinate(size), Coordinate(size), Coordinate(size)}; }
  MovingPoints Moving(int size) {
    MovingPoints points;
    const int kind = Whole(0, 5);
    for (std::size_t i = 0; i < 4; ++i) {
      points.from[i] = Point(size);
      points.to[i] = kind == 0 ? points.from[i] : Point(size);
      // All in one plane, or on one line.
      for (const int axis : {0, 1})
        if (kind == 1 + axis || (kind == 3 && axis == 0) || kind == 3)
          points.from[i][axis] = points.to[i][axis] = 0;
    }
    // Two vertices in the same place.
    if (kind == 4) points.from[3] = points.from[2];
    if (kind == 4) points.to[3] = points.to[2];
    return points;
  }

 private:
  double Coordinate(int size) { return Whole(-size, size); }
  std::mt19937 random_;
};

/// The same motion after a map of space that keeps lines and planes, as it is without rounding.
MovingPoints Mapped(const MovingPoints& points, Lattice& lattice) {
  Eigen::Matrix3d map;
  do {
    for (int i = 0; i < 9; ++i) map.data()[i] = lattice.Whole(-2, 2);
  } while (std::abs(map.determinant()) < 0.5);
  const Vector3d start = lattice.Point(9), end = lattice.Point(9);
  MovingPoints mapped;
  for (std::size_t i = 0; i < 4; ++i) {
    mapped.from[i] = map * points.from[i] + start;
    mapped.to[i] = map * points.to[i] + end;
  }
  return mapped;
}

MovingPoints Permuted(const MovingPoints& points, const std::array<std::size_t, 4>& order) {
  MovingPoints permuted;
  for (std::size_t i = 0; i < 4; ++i) {
    permuted.from[i] = points.from[order[i]];
    permuted.to[i] = points.to[order[i]];
  }
  return permuted;
}

MovingPoints Reversed(const MovingPoints& points) { return {points.to, points.from}; }

/// The answer, which the filter must not contradict.
bool MeetVertexFace(const MovingPoints& points) {
  const bool meet = exact::DecideVertexFace(points);
  EXPECT_EQ(exact::FilterVertexFace(points).value_or(meet), meet);
  EXPECT_EQ(exact::VertexMeetsFace(points), meet);
  return meet;
}
bool MeetEdges(const MovingPoints& points) {
  const bool meet = exact::DecideEdges(points);
  EXPECT_EQ(exact::FilterEdges(points).value_or(meet), meet);
  EXPECT_EQ(exact::EdgesMeet(points), meet);
  return meet;
}

TEST(Collision, DoesNotDependOnOrderNorOnTheFrameOfReference) {
  Lattice lattice(1);
  int met = 0;
  for (int i = 0; i < 1000; ++i) {
    const MovingPoints points = lattice.Moving(1 + i % 3);
    const bool face = MeetVertexFace(points), edges = MeetEdges(points);
    met += face + edges;
    ASSERT_EQ(MeetVertexFace(Permuted(points, {0, 2, 3, 1})), face) << i;
    ASSERT_EQ(MeetVertexFace(Permuted(points, {0, 3, 2, 1})), face) << i;
    ASSERT_EQ(MeetEdges(Permuted(points, {1, 0, 2, 3})), edges) << i;
    ASSERT_EQ(MeetEdges(Permuted(points, {2, 3, 0, 1})), edges) << i;
    ASSERT_EQ(MeetVertexFace(Reversed(points)), face) << i;
    ASSERT_EQ(MeetEdges(Reversed(points)), edges) << i;
    const MovingPoints mapped = Mapped(points, lattice);
    ASSERT_EQ(MeetVertexFace(mapped), face) << i;
    ASSERT_EQ(MeetEdges(mapped), edges) << i;
  }
  EXPECT_GT(met, 400);
  EXPECT_LT(met, 1600);
}

TEST(Collision, OfATriangleThatIsAnEdgeIsThatOfTheEdge) {
  Lattice lattice(2);
  int met = 0;
  for (int i = 0; i < 1000; ++i) {
    const MovingPoints points = lattice.Moving(1 + i % 3);
    const bool edges = MeetEdges(Permuted(points, {0, 0, 1, 2}));
    met += edges;
    ASSERT_EQ(MeetVertexFace(Permuted(points, {0, 1, 2, 2})), edges) << i;
    ASSERT_EQ(MeetVertexFace(Permuted(points, {0, 1, 2, 1})), edges) << i;
  }
  EXPECT_GT(met, 70);
}

/// The segment is the path of a vertex, the triangle at rest.
bool SegmentMeetsTriangle(const Vector3d& from, const Vector3d& to,
                          const std::array<Vector3d, 3>& triangle) {
  return MeetVertexFace(
      {{from, triangle[0], triangle[1], triangle[2]}, {to, triangle[0], triangle[1], triangle[2]}});
}

TEST(Collision, OfTrianglesIsThatOfAVertexAlongTheirEdges) {
  Lattice lattice(3);
  int met = 0;
  for (int i = 0; i < 4000; ++i) {
    std::array<Vector3d, 3> a, b;
    for (auto* triangle : {&a, &b})
      for (Vector3d& corner : *triangle) {
        corner = lattice.Point(1 + i % 4);
        if (i % 5 == 0) corner.z() = 0;
      }
    bool expected = false;
    for (std::size_t side = 0; side < 3; ++side)
      expected = expected || SegmentMeetsTriangle(a[side], a[(side + 1) % 3], b) ||
                 SegmentMeetsTriangle(b[side], b[(side + 1) % 3], a);
    met += expected;
    ASSERT_EQ(exact::TrianglesMeet(a, b), expected) << i;
    ASSERT_EQ(exact::TrianglesMeet(b, {a[2], a[1], a[0]}), expected) << i;
  }
  EXPECT_GT(met, 1000);
  EXPECT_LT(met, 3500);
}

// An independent proof of either answer, in whole numbers: a time at which they meet, or planes
// between them for the whole step.

constexpr int kParts = 64;

/// Points at part / kParts of the step, times kParts: all coordinates are whole.
std::array<Vector3d, 4> At(const MovingPoints& points, int part) {
  std::array<Vector3d, 4> at;
  for (std::size_t i = 0; i < 4; ++i)
    at[i] = (kParts - part) * points.from[i] + part * points.to[i];
  return at;
}

/// The first point lies in the triangle of the others, by weights of their sum. All products are
/// whole and far below 2^53.
bool IsInside(const std::array<Vector3d, 4>& at) {
  const Vector3d ab = at[2] - at[1], ac = at[3] - at[1], ap = at[0] - at[1];
  const Vector3d normal = ab.cross(ac);
  if (normal.isZero(0) || normal.dot(ap) != 0) return false;
  const double b = ap.cross(ac).dot(normal), c = ab.cross(ap).dot(normal);
  return b >= 0 && c >= 0 && b + c <= normal.squaredNorm();
}

/// The two edges cross in one point.
bool DoCross(const std::array<Vector3d, 4>& at) {
  const Vector3d first = at[1] - at[0], second = at[3] - at[2], way = at[2] - at[0];
  const Vector3d normal = first.cross(second);
  if (normal.isZero(0) || normal.dot(way) != 0) return false;
  const double along_first = way.cross(second).dot(normal),
               along_second = way.cross(first).dot(normal), whole = normal.squaredNorm();
  return along_first >= 0 && along_first <= whole && along_second >= 0 && along_second <= whole;
}

/// In each part of the step, a plane lies between the first `count` points and the others.
bool AreSeparate(const MovingPoints& points, std::size_t count) {
  for (int part = 0; part < kParts; ++part) {
    bool is_separate = false;
    for (int i = 0; i < 7 * 7 * 7 && !is_separate; ++i) {
      const Vector3d direction(i % 7 - 3, i / 7 % 7 - 3, i / 49 - 3);
      // The plane moves with the points: as the differences of points are linear in time, it is
      // enough that none changes its sign.
      is_separate = true;
      for (std::size_t a = 0; a < count && is_separate; ++a)
        for (std::size_t b = count; b < 4 && is_separate; ++b)
          for (const int end : {part, part + 1}) {
            const auto at = At(points, end);
            is_separate = is_separate && direction.dot(at[b] - at[a]) > 0;
          }
    }
    if (!is_separate) return false;
  }
  return true;
}

TEST(Collision, AgreesWithProofsInWholeNumbers) {
  Lattice lattice(4);
  int proven_yes = 0, proven_no = 0;
  constexpr int kCases = 1200;
  for (int i = 0; i < kCases; ++i) {
    const MovingPoints points = lattice.Moving(1 + i % 5);
    bool is_inside = false, do_cross = false;
    for (int part = 0; part <= kParts; ++part) {
      is_inside = is_inside || IsInside(At(points, part));
      do_cross = do_cross || DoCross(At(points, part));
    }
    const bool is_apart = !is_inside && AreSeparate(points, 1);
    const bool are_apart = !do_cross && AreSeparate(points, 2);
    const bool face = MeetVertexFace(points), edges = MeetEdges(points);
    ASSERT_TRUE(face ? !is_apart : !is_inside) << i;
    ASSERT_TRUE(edges ? !are_apart : !do_cross) << i;
    proven_yes += is_inside + do_cross;
    proven_no += is_apart + are_apart;
  }
  EXPECT_GT(proven_yes, kCases / 8);
  EXPECT_GT(proven_no, kCases / 2);
}

// Collisions by construction.

TEST(Collision, IsFoundWhereverAVertexTouchesAFace) {
  Lattice lattice(5);
  int undecided = 0;
  for (int i = 0; i < 1000; ++i) {
    // At a time of 64ths, the vertex is at a mean of the corners by 64ths, which may be 0.
    const double time = lattice.Whole(0, 64) / 64.0;
    double b = lattice.Whole(0, 64), c = lattice.Whole(0, 64 - static_cast<int>(b));
    if (i % 4 == 0) b = c = 0;
    if (i % 4 == 1) c = 64 - b;
    MovingPoints points;
    for (std::size_t corner = 1; corner < 4; ++corner) {
      const Vector3d middle = lattice.Point(1000), way = lattice.Point(1000);
      points.from[corner] = middle - time * way;
      points.to[corner] = middle + (1 - time) * way;
    }
    exact::FourPoints at;
    for (std::size_t corner = 1; corner < 4; ++corner)
      at[corner] = points.from[corner] + time * (points.to[corner] - points.from[corner]);
    const Vector3d place = at[1] + b / 64 * (at[2] - at[1]) + c / 64 * (at[3] - at[1]);
    const Vector3d way = lattice.Point(1000);
    points.from[0] = place - time * way;
    points.to[0] = place + (1 - time) * way;
    ASSERT_TRUE(MeetVertexFace(points)) << i;
    undecided += !exact::FilterVertexFace(points).has_value();
  }
  EXPECT_GT(undecided, 300) << "touches at corners, edges and ends are beyond the filter";
}

TEST(Collision, IsNoneBesideAPlaneByTheLeastDistance) {
  Lattice lattice(6);
  for (int i = 0; i < 2000; ++i) {
    // The corners are at z <= 0 at both ends, and the vertex at the least z above.
    MovingPoints points;
    for (auto* at : {&points.from, &points.to})
      for (Vector3d& point : *at) {
        point = lattice.Point(3);
        point.z() = -lattice.Whole(0, 2);
      }
    const double least = i % 50 == 0 ? std::numeric_limits<double>::denorm_min() : 0x1p-40;
    points.from[0].z() = points.to[0].z() = least;
    ASSERT_FALSE(MeetVertexFace(points)) << i;
    points.from[1].z() = points.to[1].z() = least;
    ASSERT_FALSE(MeetEdges(points)) << i;
  }
}

TEST(Collision, IsFoundInMotionsWithinAPlane) {
  // A vertex slides into a triangle in its plane, and stops at, before or behind its edge.
  for (const double stop : {0.5, 1.0, 1.0 + 0x1p-50, 3.0}) {
    const MovingPoints points = {{Vector3d(5, 0, 0), {0, -1, 0}, {1, 0, 0}, {0, 1, 0}},
                                 {Vector3d(stop, 0, 0), {0, -1, 0}, {1, 0, 0}, {0, 1, 0}}};
    EXPECT_EQ(MeetVertexFace(points), stop <= 1) << stop;
    EXPECT_EQ(MeetEdges(Permuted(points, {1, 2, 0, 0})), stop <= 1) << stop;
  }
  // It flies through the place of the triangle while that is a point.
  MovingPoints points = {{Vector3d(-1, 0, 0), {-1, -1, 0}, {1, -1, 0}, {0, 1, 0}},
                         {Vector3d(1, 0, 0), {1, 1, 0}, {-1, 1, 0}, {0, -1, 0}}};
  EXPECT_TRUE(MeetVertexFace(points));
  points.from[0].z() = points.to[0].z() = 0x1p-1000;
  EXPECT_FALSE(MeetVertexFace(points));
  // Parallel edges, one moving onto the other sideways, and along their line.
  const auto edges = [](const Vector3d& way) {
    return MovingPoints{
        {Vector3d(0, 0, 0), {1, 0, 0}, {3, 2, 0}, {4, 2, 0}},
        {Vector3d(0, 0, 0), {1, 0, 0}, Vector3d(3, 2, 0) + way, Vector3d(4, 2, 0) + way}};
  };
  EXPECT_FALSE(MeetEdges(edges({0, -2, 0})));
  EXPECT_TRUE(MeetEdges(edges({-2, -2, 0})));
  EXPECT_TRUE(MeetEdges(edges({-4, -2, 0})));
  EXPECT_TRUE(MeetEdges(edges({-8, -4, 0}))) << "they touch halfway, from end to end";
}

TEST(Collision, IsExactFarFromTheOriginAndForAnySize) {
  Lattice lattice(8);
  const auto scaled = [](const MovingPoints& points, double scale) {
    MovingPoints result = points;
    for (auto* at : {&result.from, &result.to})
      for (Vector3d& point : *at) point *= scale;
    return result;
  };
  for (int i = 0; i < 300; ++i) {
    const MovingPoints points = lattice.Moving(2);
    const bool face = MeetVertexFace(points), edges = MeetEdges(points);
    for (const double scale : {0x1p-1070, 0x1p-400, 0x1p400, 0x1p1020}) {
      ASSERT_EQ(MeetVertexFace(scaled(points, scale)), face) << scale;
      ASSERT_EQ(MeetEdges(scaled(points, scale)), edges) << scale;
    }
    MovingPoints far = points;
    for (auto* at : {&far.from, &far.to})
      for (Vector3d& point : *at) point += Vector3d(0x1p50, -0x1p49, 0x1p50);
    ASSERT_EQ(MeetVertexFace(far), face);
    ASSERT_EQ(MeetEdges(far), edges);
  }
  for (const double scale : {0x1p-1070, 1.0, 0x1p1020})
    EXPECT_TRUE(exact::TrianglesMeet(
        {scale * Vector3d(0, 0, 0), scale * Vector3d(2, 0, 0), scale * Vector3d(0, 2, 0)},
        {scale * Vector3d(1, 1, 0), scale * Vector3d(1, 1, 1), scale * Vector3d(2, 2, 1)}));
}

}  // namespace
}  // namespace cdb::tests
