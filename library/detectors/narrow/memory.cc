#include "library/detectors/narrow/memory.h"

#include <algorithm>
#include <cmath>

#include "library/detectors/narrow/manifold.h"

namespace cdb::narrow {
namespace {

/// Squares of the sines of angles within which a face is across the normal, and edges are parallel.
constexpr double kAcross = 1e-14, kParallel = 1e-12;
/// In radii of the smaller piece: of two ways out whose lengths differ by less, rounding decides.
constexpr double kTie = 1e-9;

/// What features give.
struct Given {
  Separation separation;
  bool is_valid;  ///< along the normal, no vertex is farther than they are
  /// The points nearest to each other are in the features: a gap is the distance of the pieces.
  bool is_inside;
};

Given OfFace(const Piece& piece, const Piece& other, std::uint16_t index, const Rotation& turn,
             const Vec3& place) {
  const FlatFace& face = piece.faces[index];
  const Vec3 deepest =
      turn * other.Vertex(FarthestVertex(other, Inverse(turn, -face.normal))) + place;
  const double gap = Dot(face.normal, deepest) - face.offset;
  return {
      {face.normal, gap, deepest - gap * face.normal, deepest}, true, IsOver(piece, face, deepest)};
}

Given OfFace(const Couple& couple, const Features& features) {
  if (features.kind == Features::Kind::kFaceOfA) {
    Given given = OfFace(couple.a, couple.b, features.face, couple.turn, couple.place);
    given.separation.normal = -given.separation.normal;
    return given;
  }
  Given given = OfFace(couple.b, couple.a, features.face, couple.TurnOfA(), couple.PlaceOfA());
  const auto& [normal, gap, on_face, deepest] = given.separation;
  given.separation = {couple.turn * normal, gap, couple.ToA(deepest), couple.ToA(on_face)};
  return given;
}

Given OfEdges(const Couple& couple, const Features& features) {
  const Vec3 a = couple.a.Vertex(features.of_a[0]), along_a = couple.a.Vertex(features.of_a[1]) - a,
             b = couple.ToA(couple.b.Vertex(features.of_b[0])),
             along_b = couple.ToA(couple.b.Vertex(features.of_b[1])) - b;
  const Vec3 across = Cross(along_a, along_b), between = b - a;
  const double square = SquaredNorm(across);
  if (!(square > kParallel * SquaredNorm(along_a) * SquaredNorm(along_b)))
    return {{}, false, false};
  const Vec3 normal = (features.is_opposite ? -1 : 1) / std::sqrt(square) * across;
  const double gap = couple.Gap(normal), of_edges = -Dot(normal, between);
  const double s = Dot(Cross(between, along_b), across) / square,
               t = Dot(Cross(between, along_a), across) / square;
  return {{normal, gap, a + s * along_a, b + t * along_b},
          of_edges - gap <= couple.skin,
          s >= 0 && s <= 1 && t >= 0 && t <= 1};
}

Given OfPoints(const Couple& couple, const Features& features) {
  Vec3 on_a = couple.a.Vertex(features.of_a[0]),
       on_b = couple.ToA(couple.b.Vertex(features.of_b[0]));
  double part = 0.5;
  const auto slide = [&](Vec3& from, const Vec3& to, const Vec3& point) {
    const Vec3 along = to - from;
    part = Dot(point - from, along) / SquaredNorm(along);
    from = from + part * along;
  };
  if (features.of_a[0] != features.of_a[1]) slide(on_a, couple.a.Vertex(features.of_a[1]), on_b);
  if (features.of_b[0] != features.of_b[1])
    slide(on_b, couple.ToA(couple.b.Vertex(features.of_b[1])), on_a);
  const Vec3 between = on_a - on_b;
  const double distance = Norm(between);
  const Vec3 normal = Normalized(between);
  const double gap = couple.Gap(normal);
  return {{normal, gap, on_a, on_b}, distance - gap <= couple.skin, part > 0 && part < 1};
}

Given Of(const Couple& couple, const Features& features) {
  switch (features.kind) {
    case Features::Kind::kFaceOfA:
    case Features::Kind::kFaceOfB:
      return OfFace(couple, features);
    case Features::Kind::kEdges:
      return OfEdges(couple, features);
    case Features::Kind::kPoints:
      return OfPoints(couple, features);
    case Features::Kind::kNone:
      break;
  }
  return {{}, false, false};
}

/// The face across a direction, if there is one.
bool FindFace(const Piece& piece, const Vec3& direction, std::uint16_t& index) {
  if (piece.faces.empty()) return false;
  const FlatFace& face = FacingFace(piece, direction);
  index = static_cast<std::uint16_t>(&face - piece.faces.data());
  return SquaredNorm(Cross(face.normal, direction)) <= kAcross && Dot(face.normal, direction) > 0;
}

/// The different numbers of at most three, ascending, if they are at most two.
bool SetPair(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint16_t (&pair)[2]) {
  const auto [least, most] = std::minmax({a, b, c});
  pair[0] = static_cast<std::uint16_t>(least);
  pair[1] = static_cast<std::uint16_t>(most);
  return (a == least || a == most) && (b == least || b == most) && (c == least || c == most);
}

/// Whether the least overlap of the pieces is `depth`, along `up` in the difference, and no other
/// way out is as short: all triangles of the surface are farther from the origin, except those in
/// the face that is nearest to it.
bool IsProven(const Couple& couple, const Hull3& hull, const Vec3& up, double depth) {
  constexpr double kSamePlane = 1 - 1e-10;
  const double near = depth - 4 * couple.skin,
               far = depth + kTie * std::min(couple.a.bound, couple.b.bound);
  if (hull.vertex_count == 0 || !(near > 0)) return false;
  Vec3 at[Hull3::kMostVertices];
  for (std::uint32_t i = 0; i < hull.vertex_count; ++i)
    at[i] = couple.a.Vertex(hull.of_a[i]) - couple.ToA(couple.b.Vertex(hull.of_b[i]));
  for (std::uint32_t i = 0; i < hull.face_count; ++i) {
    const auto [a, b, c] = hull.corners[i];
    const Vec3 across = Cross(at[b] - at[a], at[c] - at[a]);
    const double along = Dot(across, at[a]), square = SquaredNorm(across);
    if (!(along > 0)) return false;
    if (along * along >= far * far * square) continue;
    if (!(along * along >= near * near * square)) return false;
    const double cosine = Dot(across, up);
    if (!(cosine > 0 && cosine * cosine >= kSamePlane * kSamePlane * square)) return false;
  }
  return true;
}

}  // namespace

bool SetFeatures(const Couple& couple, const DifferenceVertex* simplex, int count,
                 Features& features, Separation& separation) {
  if (std::max(couple.a.count, couple.b.count) > 0xffff) return false;
  const auto is_given = [&](const Features& found) {
    const Given given = Of(couple, found);
    if (!given.is_valid || !(given.separation.gap >= separation.gap - couple.skin)) return false;
    features = found;
    separation.normal = given.separation.normal;
    separation.gap = given.separation.gap;
    if (given.is_inside) separation = given.separation;
    return true;
  };
  const Vec3 normal = separation.normal;
  Features found;
  if (FindFace(couple.a, -normal, found.face)) {
    found.kind = Features::Kind::kFaceOfA;
    if (is_given(found)) return true;
  }
  if (FindFace(couple.b, Inverse(couple.turn, normal), found.face)) {
    found.kind = Features::Kind::kFaceOfB;
    if (is_given(found)) return true;
  }
  const DifferenceVertex &one = simplex[0], &two = simplex[std::min(1, count - 1)],
                         &three = simplex[count - 1];
  if (!SetPair(one.vertex_a, two.vertex_a, three.vertex_a, found.of_a) ||
      !SetPair(one.vertex_b, two.vertex_b, three.vertex_b, found.of_b))
    return false;
  const bool are_edges = found.of_a[0] != found.of_a[1] && found.of_b[0] != found.of_b[1];
  found.kind = are_edges ? Features::Kind::kEdges : Features::Kind::kPoints;
  if (are_edges) {
    const Vec3 along_a = couple.a.Vertex(found.of_a[1]) - couple.a.Vertex(found.of_a[0]),
               along_b = couple.b.Vertex(found.of_b[1]) - couple.b.Vertex(found.of_b[0]);
    found.is_opposite = Dot(Cross(along_a, couple.turn * along_b), normal) < 0;
  }
  return is_given(found);
}

Recalled Recall(const Couple& couple, const Memory& memory, double reach) {
  const Given given = Of(couple, memory.features);
  const Separation& separation = given.separation;
  Recalled recalled{.separation = separation, .has_points = given.is_inside};
  if (!given.is_valid) return recalled;
  // Within rounding errors of touching, a search may find others.
  const double touching = kTouching * couple.rounding;
  if (separation.gap > 2 * touching)
    recalled.is_proven = given.is_inside || separation.gap > reach;
  else if (separation.gap < -touching)
    recalled.is_proven = IsProven(couple, memory.hull, -separation.normal, -separation.gap);
  return recalled;
}

}  // namespace cdb::narrow
