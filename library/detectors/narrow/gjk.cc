// The distance of two convex cores: Gilbert, Johnson & Keerthi, A fast procedure for computing the
// distance between complex objects in three-dimensional space, 1988. The nearest points of a
// simplex are found by its Voronoi regions: Ericson, Real-Time Collision Detection, 2005, section
// 5.1.
#include <algorithm>
#include <limits>

#include "library/detectors/narrow/manifold.h"
#include "library/detectors/narrow/memory.h"

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

/// The separation as its features give it, which are kept.
Separation Kept(const Couple& couple, const Simplex& simplex, Memory* memory,
                Separation separation) {
  if (memory != nullptr)
    SetFeatures(couple, simplex.vertex, simplex.count, memory->features, separation);
  return separation;
}

/// Of cores whose difference is nearest to the origin in a point of the simplex.
Separation Apart(const Couple& couple, const Simplex& simplex, const Vec3& nearest,
                 Memory* memory) {
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
  if (couple.is_curved) Polish(couple, {}, 6, found);
  // Within a skin, whose normals differ: those of a polytope do not.
  if (couple.is_curved && !(found.gap > 0))
    return Expand(couple, simplex.vertex, simplex.count, {}, memory);
  return Kept(couple, simplex, memory, found);
}

/// The gap of a point of one piece and a face of the other, if it is over that face. `direction`:
/// about that from a to b; `facing`: least cosine of it and the face.
bool TryFace(const Couple& couple, const Vec3& direction, double facing, Separation& found) {
  for (const int which : {1, -1}) {
    const Piece& piece = which > 0 ? couple.a : couple.b;
    if (piece.faces.empty()) continue;
    const Vec3 way = which > 0 ? direction : Inverse(couple.turn, -direction);
    const FlatFace& face = FacingFace(piece, way);
    Separation separation;
    if (!(Dot(face.normal, way) > facing) || !(MeetFace(couple, which, face, separation) >= 0))
      continue;
    found = separation;
    return true;
  }
  return false;
}

/// Of pieces with curved surfaces: guesses from a simplex about the nearest where their gap is
/// greatest.
void MakeGuess(const Couple& couple, const Simplex& simplex, const Vec3& nearest, Guess& guess) {
  const Vec3 direction = -Normalized(nearest);
  guess = {};
  constexpr double kFacing = 0.9;
  guess.is_least = TryFace(couple, direction, kFacing, guess.separation);
  if (guess.is_least) return;
  const DifferenceVertex* corners = simplex.vertex;
  const Edges edges(couple, corners[0], corners[simplex.count > 1 ? 1 : 0],
                    corners[simplex.count > 2 ? 2 : 0]);
  if (edges.count == 2)
    guess.is_least = CrossEdges(couple, edges.of[0], edges.of[1], direction, guess.separation) >= 0;
  if (edges.count >= 2) return;
  guess.edge = edges.of[0];
  guess.separation.normal = -direction;
  guess.is_least = Polish(couple, guess.edge, 8, guess.separation).is_least;
}

/// A polytope in the difference of two pieces: between the point of its surface at the least
/// overlap nearby, some around that, and one far below.
class Crown {
 public:
  Crown(const Couple& couple, const Separation& least)
      : couple_(couple), up_(-least.normal), depth_(-least.gap), below_(couple.Support(-up_).at) {}

  /// Whether no face is nearer to the origin than the point at its top, but for those around that.
  bool IsFar() const {
    constexpr int kMostSplits = 3;
    const Vec3 u = UnitAcross(up_), v = Cross(up_, u);
    const Vec3 around[4] = {Beside(u), Beside(v), Beside(-u), Beside(-v)};
    for (int k = 0; k < 4; ++k)
      if (!IsFar(around[k], around[(k + 1) % 4], kMostSplits)) return false;
    return true;
  }

 private:
  Vec3 Beside(const Vec3& way) const {
    constexpr double kTilt = 0.14;
    return couple_.Support(up_ + kTilt * way).at;
  }
  /// From one point around to the next. More between them where the polytope is too small.
  bool IsFar(const Vec3& a, const Vec3& b, int splits) const {
    constexpr double kNearby = 0.99, kFarther = 1 + 1e-6;
    const Vec3 along = b - a;
    if (along.x == 0 && along.y == 0 && along.z == 0) return true;
    const Vec3 side = Cross(below_ - a, along), lid = Cross(a - depth_ * up_, b - depth_ * up_);
    if (Dot(side, a) >= kFarther * depth_ * Norm(side) && Dot(lid, up_) >= kNearby * Norm(lid))
      return true;
    const Vec3 out = Cross(along, up_);
    const double square = SquaredNorm(out);
    if (splits == 0 || !(square > 0)) return false;
    const Vec3 between = Beside(1 / std::sqrt(square) * out);
    if (!(Dot(out, between) > std::max(Dot(out, a), Dot(out, b)))) return false;
    return IsFar(a, between, splits - 1) && IsFar(between, b, splits - 1);
  }

  const Couple& couple_;
  const Vec3 up_;
  const double depth_;
  const Vec3 below_;
};

constexpr int kMostSteps = 100;

}  // namespace

double MeetFace(const Couple& couple, int which, const FlatFace& face, Separation& found) {
  const bool is_of_a = which > 0;
  const Piece &piece = is_of_a ? couple.a : couple.b, &other = is_of_a ? couple.b : couple.a;
  const Rotation turn = is_of_a ? couple.turn : couple.TurnOfA();
  const Vec3 place = is_of_a ? couple.place : couple.PlaceOfA();
  const Vec3 deepest = turn * FarthestPoint(other, Inverse(turn, -face.normal)) + place;
  const double gap = Dot(face.normal, deepest) - face.offset;
  if (is_of_a) {
    found = {-face.normal, gap, deepest - gap * face.normal, deepest};
  } else {
    const Vec3 on_a = couple.ToA(deepest), normal = couple.turn * face.normal;
    found = {normal, gap, on_a, on_a - gap * normal};
  }
  return InsetOf(piece, face, deepest);
}

double CrossEdges(const Couple& couple, const Edge& one, const Edge& other, const Vec3& direction,
                  Separation& found) {
  if (one.piece == other.piece || (one.is_slant && other.is_slant)) return -1;
  const Edge first = LineAcross(couple, one, other, direction),
             second = LineAcross(couple, other, one, direction);
  const Vec3 across = Cross(first.along, second.along);
  const double square = SquaredNorm(across);
  if (!(square > 1e-6 * SquaredNorm(first.along) * SquaredNorm(second.along))) return -1;
  Vec3 way = 1 / std::sqrt(square) * across;
  if (Dot(way, direction) < 0) way = -way;
  const DifferenceVertex vertex = couple.Support(way);
  if (!first.EndsIn(vertex.on_a) || !second.EndsIn(vertex.on_b)) return -1;
  // From the middle of each edge to where they cross, in edges.
  const auto middle = [&](const Edge& edge, const Vec3& end) {
    return end - Dot(end - edge.middle, edge.along) / SquaredNorm(edge.along) * edge.along;
  };
  const Vec3 on_a = middle(first, vertex.on_a), on_b = middle(second, vertex.on_b),
             between = on_b - on_a;
  const double s = Dot(Cross(between, second.along), across) / square,
               t = Dot(Cross(between, first.along), across) / square;
  const double length_a = Norm(first.along), length_b = Norm(second.along);
  const double inset =
      std::sqrt(square) * std::min((0.5 - std::abs(s)) / length_b, (0.5 - std::abs(t)) / length_a);
  if (!(inset >= 0)) return -1;
  found = {-way, -Dot(vertex.at, way), on_a + s * first.along, on_b + t * second.along};
  return inset;
}

bool IsSolved(const Couple& couple, const Separation& greatest) {
  return greatest.gap > 0 || Crown(couple, greatest).IsFar();
}

Separation Separate(const Couple& couple, const Vec3& axis, double reach, Memory* memory) {
  Simplex simplex;
  Guess guess;
  Vec3 nearest = axis;
  double square = std::numeric_limits<double>::infinity();
  if (couple.is_curved) {
    constexpr double kFacing = 0.4;
    guess.is_least = TryFace(couple, -Normalized(axis), kFacing, guess.separation);
    if (guess.is_least && IsSolved(couple, guess.separation))
      return Kept(couple, simplex, memory, guess.separation);
  }
  if (couple.a.kind == Kind::kRound && couple.b.kind == Kind::kRound) {
    guess.separation.normal = Normalized(axis);
    guess.is_least = Polish(couple, {}, 8, guess.separation).is_least;
    if (guess.is_least && IsSolved(couple, guess.separation))
      return Kept(couple, simplex, memory, guess.separation);
  }
  for (int step = 0; step < kMostSteps; ++step) {
    const DifferenceVertex vertex = couple.Support(-nearest);
    const double length = Norm(nearest), along = Dot(vertex.at, nearest) / length;
    if (along > reach)
      return {.normal = 1 / length * nearest, .gap = along, .on_a = {}, .on_b = {}};
    // No vertex is closer to the origin along the way: the nearest point is the nearest of all.
    if (simplex.count > 0 && (length - along <= couple.skin / 4 || Holds(simplex, vertex.at)))
      return Apart(couple, simplex, nearest, memory);
    simplex.vertex[simplex.count++] = vertex;
    const Part part = NearestOf(simplex);
    const Vec3 next = simplex.PointOf(part);
    const double next_square = SquaredNorm(next);
    if (part.count == 0 || next_square <= kTouching * kTouching * couple.rounding * couple.rounding)
      return Expand(couple, simplex.vertex, simplex.count, guess, memory);
    if (!(next_square < square)) {  // by rounding
      --simplex.count;
      if (couple.is_curved && length - along > couple.skin)
        return Expand(couple, simplex.vertex, simplex.count, guess, memory);
      return Apart(couple, simplex, nearest, memory);
    }
    simplex.Keep(part);
    square = next_square;
    nearest = next;
    if (!couple.is_curved || step % 3 != 2) continue;
    Guess other;
    MakeGuess(couple, simplex, nearest, other);
    if (!other.is_least || !(other.separation.gap > guess.separation.gap)) continue;
    guess = other;
    if (IsSolved(couple, guess.separation)) return Kept(couple, simplex, memory, guess.separation);
  }
  return Apart(couple, simplex, nearest, memory);
}

}  // namespace cdb::narrow
