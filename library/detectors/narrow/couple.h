// Two convex pieces, and the Minkowski difference of their cores.
#pragma once

#include <algorithm>
#include <cmath>

#include "library/detectors/kernels/simd.h"
#include "library/detectors/narrow/curved.h"
#include "library/detectors/narrow/pieces.h"

namespace cdb::narrow {
namespace {  // simd.h needs internal linkage

inline kernels::Doubles Greatest(kernels::Doubles a, kernels::Doubles b) {
#if defined(__AVX2__)
  return _mm256_max_pd(a, b);
#elif defined(__SSE2__)
  return _mm_max_pd(a, b);
#else
  return a > b ? a : b;
#endif
}

/// Writes the products of `direction` with at most `kBlock` vectors in columns, from `first` on.
/// Returns the greatest.
constexpr std::uint32_t kBlock = 64;
[[gnu::always_inline]] inline double ProductsOf(const double* columns, std::uint32_t padded,
                                                const Vec3& direction, std::uint32_t first,
                                                double* products) {
  using kernels::Doubles;
  const double *x = columns, *y = x + padded, *z = y + padded;
  const Doubles dx = Doubles{} + direction.x, dy = Doubles{} + direction.y,
                dz = Doubles{} + direction.z;
  Doubles most = Doubles{} - kernels::kInfinity;
  const std::uint32_t end = std::min(padded, first + kBlock);
  for (std::uint32_t i = first; i < end; i += kernels::kDoubles) {
    const Doubles along = kernels::Load<Doubles>(x + i) * dx + kernels::Load<Doubles>(y + i) * dy +
                          kernels::Load<Doubles>(z + i) * dz;
    kernels::Store(along, products + (i - first));
    most = Greatest(along, most);
  }
  double extent = most[0];
  for (std::size_t k = 1; k < kernels::kDoubles; ++k) extent = std::max(extent, most[k]);
  return extent;
}

/// The index of the vector in columns that is farthest along `direction`; the first of several.
inline std::uint32_t FarthestOf(const double* columns, std::uint32_t padded,
                                const Vec3& direction) {
  std::uint32_t best = 0;
  double most = -kernels::kInfinity;
  for (std::uint32_t first = 0; first < padded; first += kBlock) {
    double products[kBlock];
    const double extent = ProductsOf(columns, padded, direction, first, products);
    if (!(extent > most)) continue;
    most = extent;
    best = 0;
    while (products[best] != extent) ++best;
    best += first;
  }
  return best;
}

/// The index of the vertex of a core without curved surfaces that is farthest along `direction`;
/// the first of several.
inline std::uint32_t FarthestVertex(const Piece& piece, const Vec3& direction) {
  if (piece.kind == Kind::kBox)
    return (direction.x > 0 ? 1u : 0u) | (direction.y > 0 ? 2u : 0u) | (direction.z > 0 ? 4u : 0u);
  if (piece.count <= 2) return piece.count == 2 && direction.y > 0 ? 1 : 0;
  return FarthestOf(piece.columns.data(), piece.padded, direction);
}

/// The point of the core that is farthest along `direction`.
inline Vec3 FarthestPoint(const Piece& piece, const Vec3& direction) {
  return IsCurved(piece.kind) ? FarthestOnCurved(piece, direction)
                              : piece.Vertex(FarthestVertex(piece, direction));
}

/// How far the core extends along `direction`.
inline double Extent(const Piece& piece, const Vec3& direction) {
  if (IsCurved(piece.kind)) return ExtentOfCurved(piece, direction);
  if (piece.kind == Kind::kBox)
    return std::abs(direction.x) * piece.half.x + std::abs(direction.y) * piece.half.y +
           std::abs(direction.z) * piece.half.z;
  if (piece.count <= 2) return std::abs(direction.y) * piece.half.y;
  double extent = -kernels::kInfinity, products[kBlock];
  for (std::uint32_t first = 0; first < piece.padded; first += kBlock)
    extent = std::max(extent,
                      ProductsOf(piece.columns.data(), piece.padded, direction, first, products));
  return extent;
}

}  // namespace

/// A vertex of the difference a - b, of two vertices or points of curved surfaces, in the frame of
/// a.
struct DifferenceVertex {
  Vec3 at, on_a, on_b;
  std::uint32_t vertex_a = 0, vertex_b = 0;  ///< by number; 0 of a curved surface
};

/// In radii of the smaller piece. Polish finds what is below it.
inline constexpr double kSkin = 2e-7;

/// In rounding errors: cores that are no farther apart touch. Of a shorter distance the direction
/// is not known, and an expanding polytope finds the normal better.
inline constexpr double kTouching = 2e6;

/// A pair of pieces, neither a plane, in the frame of the first's body.
struct Couple {
  const Piece &a, &b;
  Rotation turn;  ///< of the second
  Vec3 place;
  /// m: lengths below this are rounding errors, and the normal of such a gap is not known from it.
  double rounding;
  /// m: the difference has a surface where a plane that touches it is no farther away. More than
  /// rounding errors if the surface is curved.
  double skin;
  bool is_curved;

  Couple(const Piece& first, const Pose& pose_a, const Piece& second, const Pose& pose_b)
      : a(first), b(second) {
    const Rotation axes = AxesOf(pose_a);
    turn = {Inverse(axes, pose_b.x), Inverse(axes, pose_b.y), Inverse(axes, pose_b.z)};
    place = Inverse(axes, pose_b.position - pose_a.position);
    rounding =
        2e-15 * (std::abs(place.x) + std::abs(place.y) + std::abs(place.z) + a.reach + b.reach);
    skin = 4 * rounding;
    is_curved = IsCurved(a.kind) || IsCurved(b.kind);
    if (is_curved) skin = std::max(skin, kSkin * std::min(a.bound, b.bound));
  }

  Vec3 ToA(const Vec3& of_b) const { return turn * of_b + place; }
  /// The frame of a in that of b.
  Rotation TurnOfA() const {
    return {{turn.x.x, turn.y.x, turn.z.x},
            {turn.x.y, turn.y.y, turn.z.y},
            {turn.x.z, turn.y.z, turn.z.z}};
  }
  Vec3 PlaceOfA() const { return -Inverse(turn, place); }
  /// The farthest vertex along `direction`.
  DifferenceVertex Support(const Vec3& direction) const {
    DifferenceVertex vertex;
    vertex.on_a = Farthest(a, direction, vertex.vertex_a);
    vertex.on_b = ToA(Farthest(b, Inverse(turn, -direction), vertex.vertex_b));
    vertex.at = vertex.on_a - vertex.on_b;
    return vertex;
  }
  /// m: of the cores along `normal`, unit, from b to a; negative if they overlap along it.
  double Gap(const Vec3& normal) const {
    return Dot(normal, -place) - Extent(a, -normal) - Extent(b, Inverse(turn, normal));
  }

 private:
  static Vec3 Farthest(const Piece& piece, const Vec3& direction, std::uint32_t& number) {
    if (IsCurved(piece.kind)) return FarthestOnCurved(piece, direction);
    number = FarthestVertex(piece, direction);
    return piece.Vertex(number);
  }
};

struct Memory;

/// The shortest translation that separates two cores, or their distance.
struct Separation {
  Vec3 normal;      ///< unit, from b to a
  double gap;       ///< along the normal; negative if they overlap
  Vec3 on_a, on_b;  ///< the points nearest to each other, or deepest in the other
};

/// The distance of the cores by the algorithm of Gilbert, Johnson and Keerthi (1988), or their
/// depth by an expanding polytope (van den Bergen 2001). If they are farther apart than `reach`,
/// the normal and gap are those of an axis along which they are. `axis`: a direction from b to a to
/// begin with, not zero. `memory`: null, or what is kept for the next cycle.
Separation Separate(const Couple& couple, const Vec3& axis, double reach, Memory* memory);

/// A straight edge or line on a surface, in the frame of a: of a if `piece` is 1, of b if it is -1;
/// 0: none.
struct Edge {
  int piece = 0;
  /// From end to end, and the middle; of a line on a curved surface that AxisOf returns, those of
  /// the axis.
  Vec3 along = {0, 0, 0}, middle = {0, 0, 0};
  bool is_axis = false;             ///< a line on a curved surface
  bool is_slant = false;            ///< a line on a cone; which one depends on the normal
  std::uint32_t low = 0, high = 0;  ///< the vertices, if it is not

  /// Whether it ends in this point, or a line parallel to it does.
  bool EndsIn(const Vec3& point) const {
    const Vec3 from = point - middle, half = (Dot(from, along) > 0 ? 0.5 : -0.5) * along;
    return is_axis || SquaredNorm(from - half) <= 1e-20 * SquaredNorm(along);
  }
};

/// Any line on the curved surface of a piece, and the edge between two vertices. `which`: as
/// Edge::piece.
Edge AxisOf(const Couple& couple, int which);
Edge EdgeOf(const Couple& couple, int which, std::uint32_t from, std::uint32_t to);

/// LineAlong: the line on the cone whose normal is nearest to `direction`, from a to b. LineAcross:
/// of the lines whose normal is perpendicular to `other`, the one whose normal is nearest to
/// `direction`; no edge if there is none. Both return other edges unchanged.
Edge LineAlong(const Couple& couple, const Edge& edge, const Vec3& direction);
Edge LineAcross(const Couple& couple, const Edge& edge, const Edge& other, const Vec3& direction);

/// The edges along which the corners of a triangle of the difference lie. Of none or one, the
/// triangle is on a smooth part, or on one that is smooth across the edge; otherwise it is on a
/// flat part, as far as its corners tell.
struct Edges {
  int count = 0;  ///< 3 for more
  Edge of[2];

  Edges(const Couple& couple, const DifferenceVertex& a, const DifferenceVertex& b,
        const DifferenceVertex& c);
};

/// The separation of a face of one piece, `which` as Edge::piece, and the point of the other that
/// is deepest behind it. Returns how far, m, this point is from the boundary of the face, seen
/// along its normal, or somewhat less; negative if it is not over the face.
double MeetFace(const Couple& couple, int which, const FlatFace& face, Separation& found);

/// The separation of an edge of each piece, if they are nearest, or overlap least of all nearby,
/// where they cross; then returns how far, m, the origin's foot is from the boundary of the face of
/// the difference that they make, else -1. A line on a curved surface is where that touches a plane
/// along the other edge. `direction`: about that from a to b.
double CrossEdges(const Couple& couple, const Edge& one, const Edge& other, const Vec3& direction,
                  Separation& found);

/// Whether the greatest gap of all normals nearby is that of all. The gap of pieces that are apart
/// is concave.
bool IsSolved(const Couple& couple, const Separation& greatest);

/// An overlap along a normal, which may be the least.
struct Guess {
  Separation separation = {{0, 1, 0}, -kernels::kInfinity, {}, {}};
  bool is_least = false;  ///< no normal nearby has less overlap
  Edge edge;              ///< across which the normal is
};

/// The same where the cores are known to overlap or to touch, from a simplex of `count` vertices of
/// their difference. `guess`: what is known already.
Separation Expand(const Couple& couple, const DifferenceVertex* simplex, int count,
                  const Guess& guess, Memory* memory);

/// What Polish finds.
struct Polished {
  DifferenceVertex vertex;  ///< the farthest along the normal
  bool is_least;            ///< no normal nearby has a greater gap
};

/// Of pieces with curved surfaces: turns the normal to the nearest one along which the gap is
/// greatest, by some steps of Newton's method, and only across the edge if there is one.
Polished Polish(const Couple& couple, const Edge& edge, int steps, Separation& separation);

/// What Settle finds.
struct Settled {
  Separation separation = {};
  bool is_valid = false;    ///< no normal nearby has a greater gap
  bool is_certain = false;  ///< any normal nearby gives the same separation, to the bit
};

/// As Polish, but to the end of Newton's method, from a normal. The result is that of the normal
/// rounded to 4e-9, so that it does not depend on where the method began.
Settled Settle(const Couple& couple, const Edge& edge, const Vec3& normal);

}  // namespace cdb::narrow
