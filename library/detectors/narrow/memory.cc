#include "library/detectors/narrow/memory.h"

#include <algorithm>
#include <cmath>

#include "library/detectors/narrow/manifold.h"

namespace cdb::narrow {
namespace {

/// Squares of the sines of angles within which a face is across the normal. A search knows the
/// normal of pieces with curved surfaces less well.
constexpr double kAcross = 1e-12, kAcrossCurved = 1e-6;
/// In radii of the smaller piece: of two ways out whose lengths differ by less, rounding decides.
constexpr double kTie = 1e-9;

/// What features give.
struct Given {
  Separation separation = {};
  /// m: how far the origin's foot is from the boundary of the face of the difference that the
  /// features make. Not negative: the points nearest to each other are in the features, and a gap
  /// is the distance of the pieces.
  double inset = -1;
  bool is_valid = false;  ///< along the normal, no vertex is farther than they are

  bool IsInside() const { return inset >= 0; }
};

Edge EdgeOf(const Couple& couple, int which, const std::uint16_t (&of)[2]) {
  return of[0] == Features::kAxis ? AxisOf(couple, which) : EdgeOf(couple, which, of[0], of[1]);
}

Given Of(const Couple& couple, const Features& features) {
  Given given;
  switch (features.kind) {
    case Features::Kind::kFaceOfA:
      given.inset = MeetFace(couple, 1, couple.a.faces[features.face], given.separation);
      given.is_valid = true;
      break;
    case Features::Kind::kFaceOfB:
      given.inset = MeetFace(couple, -1, couple.b.faces[features.face], given.separation);
      given.is_valid = true;
      break;
    case Features::Kind::kEdges: {
      const Edge a = EdgeOf(couple, 1, features.of_a), b = EdgeOf(couple, -1, features.of_b);
      const Vec3 across = Cross(a.along, b.along);
      given.inset =
          CrossEdges(couple, a, b, features.is_opposite ? across : -across, given.separation);
      given.is_valid = given.IsInside();
      break;
    }
    case Features::Kind::kNone:
      break;
  }
  return given;
}

/// The face across a direction, if there is one.
bool FindFace(const Piece& piece, const Vec3& direction, double square_sine, std::uint16_t& index) {
  if (piece.faces.empty() || piece.faces.size() > 0xffff) return false;
  const FlatFace& face = FacingFace(piece, direction);
  index = static_cast<std::uint16_t>(&face - piece.faces.data());
  return SquaredNorm(Cross(face.normal, direction)) <= square_sine &&
         Dot(face.normal, direction) > 0;
}

/// The edges that cross. Two vertices may be opposite corners of the face that they make.
bool SetEdges(const Couple& couple, const DifferenceVertex* simplex, int count, const Vec3& normal,
              Features& found) {
  if (count < 2) return false;
  const Edges edges(couple, simplex[0], simplex[1], simplex[count - 1]);
  const Edge &a = edges.of[0], &b = edges.of[1];
  if (edges.count != 2 || a.piece == b.piece) return false;
  const auto set = [](const Edge& edge, std::uint16_t(&of)[2]) {
    of[0] = edge.is_axis ? Features::kAxis : static_cast<std::uint16_t>(edge.low);
    of[1] = edge.is_axis ? Features::kAxis : static_cast<std::uint16_t>(edge.high);
  };
  set(a, found.of_a);
  set(b, found.of_b);
  found.is_opposite = Dot(Cross(a.along, b.along), normal) < 0;
  return true;
}

/// Whether the least overlap of the pieces is `depth`, along `up` in the difference, and no other
/// way out is as short: all triangles of the surface are farther from the origin, except those in
/// the face that is nearest to it.
bool IsProven(const Couple& couple, const Shell& shell, const Vec3& up, double depth) {
  constexpr double kSamePlane = 1 - 1e-10;
  const double near = depth - 4 * couple.skin,
               far = depth + kTie * std::min(couple.a.bound, couple.b.bound);
  if (shell.vertex_count == 0 || !(near > 0)) return false;
  Vec3 at[Shell::kMostVertices];
  for (std::uint32_t i = 0; i < shell.vertex_count; ++i)
    at[i] = couple.a.Vertex(shell.of_a[i]) - couple.ToA(couple.b.Vertex(shell.of_b[i]));
  for (std::uint32_t i = 0; i < shell.face_count; ++i) {
    const auto [a, b, c] = shell.corners[i];
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

/// Whether a face that is not one of the features is across the normal.
bool IsParallel(const Couple& couple, Features::Kind kind, const Vec3& normal) {
  const double across = couple.is_curved ? kAcrossCurved : kAcross;
  std::uint16_t face;
  return (kind != Features::Kind::kFaceOfA && FindFace(couple.a, -normal, across, face)) ||
         (kind != Features::Kind::kFaceOfB &&
          FindFace(couple.b, Inverse(couple.turn, normal), across, face));
}

}  // namespace

bool SetFeatures(const Couple& couple, const DifferenceVertex* simplex, int count,
                 Features& features, Separation& separation) {
  features.kind = Features::Kind::kNone;
  if (std::max(couple.a.count, couple.b.count) >= Features::kAxis) return false;
  const double slop = couple.is_curved ? 1e3 * couple.rounding : couple.skin;
  const Vec3 normal = separation.normal;
  Features found;
  const auto is_given = [&](Features::Kind kind) {
    found.kind = kind;
    const Given given = Of(couple, found);
    if (!given.is_valid || !(given.separation.gap >= separation.gap - slop)) return false;
    if (couple.is_curved && !given.IsInside()) return false;
    separation.normal = given.separation.normal;
    separation.gap = given.separation.gap;
    if (given.IsInside()) separation = given.separation;
    return true;
  };
  const double across = couple.is_curved ? kAcrossCurved : kAcross;
  std::uint16_t face_of_b = 0;
  const bool is_across_a = FindFace(couple.a, -normal, across, found.face),
             is_across_b = FindFace(couple.b, Inverse(couple.turn, normal), across, face_of_b);
  if (is_across_a || is_across_b) {
    const bool is_of_a = is_across_a && is_given(Features::Kind::kFaceOfA);
    if (!is_of_a) found.face = face_of_b;
    if (!is_of_a && !(is_across_b && is_given(Features::Kind::kFaceOfB))) return false;
    // Of parallel faces, rounding decides which is found.
    if (is_across_a && is_across_b) return false;
  } else if (!SetEdges(couple, simplex, count, normal, found) ||
             !is_given(Features::Kind::kEdges)) {
    return false;
  }
  features = found;
  return true;
}

Recalled Recall(const Couple& couple, const Memory& memory, double reach) {
  const Given given = Of(couple, memory.features);
  const Separation& separation = given.separation;
  Recalled recalled{.separation = separation, .has_points = given.IsInside()};
  if (!given.is_valid ||
      (separation.gap <= reach && IsParallel(couple, memory.features.kind, separation.normal)))
    return recalled;
  if (couple.is_curved) {
    // So far inside, no normal nearby has less overlap.
    constexpr double kInset = 0.08;
    recalled.is_proven = separation.gap > reach ||
                         (given.inset >= std::max(0.0, -kInset * separation.gap) &&
                          std::abs(separation.gap) > couple.skin && IsSolved(couple, separation));
    return recalled;
  }
  // Within rounding errors of touching, a search may find others.
  const double touching = kTouching * couple.rounding;
  if (separation.gap > 2 * touching)
    recalled.is_proven = given.IsInside() || separation.gap > reach;
  else if (separation.gap < -touching)
    recalled.is_proven = IsProven(couple, memory.shell, -separation.normal, -separation.gap);
  return recalled;
}

}  // namespace cdb::narrow
