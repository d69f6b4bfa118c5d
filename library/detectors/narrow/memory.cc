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

/// `normal`: about theirs, such as that of the last cycle.
Given Of(const Couple& couple, const Features& features, const Vec3& normal) {
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
      // Of the lines on a cone, the normal tells which one.
      const Vec3 direction = a.is_slant || b.is_slant ? -normal
                             : features.is_opposite   ? across
                                                      : -across;
      given.inset = CrossEdges(couple, a, b, direction, given.separation);
      given.is_valid = given.IsInside();
      break;
    }
    case Features::Kind::kNone:
    case Features::Kind::kSmooth:
    case Features::Kind::kEdgeOfA:
    case Features::Kind::kEdgeOfB:
      break;
  }
  return given;
}

bool IsFace(Features::Kind kind) {
  return kind == Features::Kind::kFaceOfA || kind == Features::Kind::kFaceOfB;
}
bool IsSmooth(Features::Kind kind) { return kind >= Features::Kind::kSmooth; }

/// Across which the normal of smooth parts is.
Edge EdgeAcross(const Couple& couple, const Features& features) {
  if (features.kind == Features::Kind::kEdgeOfA) return EdgeOf(couple, 1, features.of_a);
  if (features.kind == Features::Kind::kEdgeOfB) return EdgeOf(couple, -1, features.of_b);
  return {};
}

void SetEdge(const Edge& edge, std::uint16_t (&of)[2]) {
  of[0] = edge.is_axis ? Features::kAxis : static_cast<std::uint16_t>(edge.low);
  of[1] = edge.is_axis ? Features::kAxis : static_cast<std::uint16_t>(edge.high);
}

/// Sets the face of a or b, as `kind` says, that is across the normal. False if there is none.
bool FindFace(const Couple& couple, Features::Kind kind, const Vec3& normal, Features& found) {
  const bool is_of_a = kind == Features::Kind::kFaceOfA;
  const Piece& piece = is_of_a ? couple.a : couple.b;
  if (piece.faces.empty() || piece.faces.size() > 0xffff) return false;
  const Vec3 direction = is_of_a ? -normal : Inverse(couple.turn, normal);
  const FlatFace& face = FacingFace(piece, direction);
  if (!(SquaredNorm(Cross(face.normal, direction)) <=
        (couple.is_curved ? kAcrossCurved : kAcross)) ||
      !(Dot(face.normal, direction) > 0))
    return false;
  found.kind = kind;
  found.face = static_cast<std::uint16_t>(&face - piece.faces.data());
  return true;
}
/// Of a, or of b if a has none.
bool FindFace(const Couple& couple, const Vec3& normal, Features& found) {
  return FindFace(couple, Features::Kind::kFaceOfA, normal, found) ||
         FindFace(couple, Features::Kind::kFaceOfB, normal, found);
}

/// The edges that cross. Two vertices may be opposite corners of the face that they make.
bool SetEdges(const Couple& couple, const DifferenceVertex* simplex, int count, const Vec3& normal,
              Features& found) {
  if (count < 2) return false;
  const Edges edges(couple, simplex[0], simplex[1], simplex[count - 1]);
  const Edge &a = edges.of[0], &b = edges.of[1];
  if (edges.count != 2 || a.piece == b.piece) return false;
  SetEdge(a, found.of_a);
  SetEdge(b, found.of_b);
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

/// The edge of a piece, in the frame of a, that is farthest along a direction, which is in the
/// frame of the piece, or the line on a curved surface. False if a face is.
bool FindEdge(const Couple& couple, int which, const Vec3& direction, Edge& edge) {
  const Piece& piece = which > 0 ? couple.a : couple.b;
  const double even = 1e-6 * piece.bound;
  if (IsCurved(piece.kind)) {
    const double straight = piece.kind == Kind::kRound ? piece.straight : piece.half.y;
    const double rise = 2 * straight *
                        (piece.kind == Kind::kCone ? direction.y : std::abs(direction.y)),
                 rim = piece.kind == Kind::kCone ? RimOf(piece, direction).length : 0;
    if (straight > 0 && std::abs(rise - rim) <= even) edge = AxisOf(couple, which);
    return true;
  }
  std::uint32_t farthest[2];
  int count = 0;
  const double extent = Extent(piece, direction);
  for (std::uint32_t i = 0; i < piece.count; ++i) {
    if (extent - Dot(piece.Vertex(i), direction) > even) continue;
    if (count == 2) return false;
    farthest[count++] = i;
  }
  if (count == 2) edge = EdgeOf(couple, which, farthest[0], farthest[1]);
  return true;
}

/// Puts a face of the other piece in the place of a face that it is parallel to, if the gap is
/// greater there; of about equal ones, the one with the points; of two of these, that of a.
void TakeParallel(const Couple& couple, Features& features, Given& given) {
  const bool is_of_a = features.kind == Features::Kind::kFaceOfA;
  const Vec3& normal = given.separation.normal;
  Features other;
  if (!FindFace(couple, is_of_a ? Features::Kind::kFaceOfB : Features::Kind::kFaceOfA, normal,
                other))
    return;
  const Given of_other = Of(couple, other, normal);
  const double more = of_other.separation.gap - given.separation.gap;
  const bool is_better =
      given.IsInside() != of_other.IsInside() && (couple.is_curved || std::abs(more) <= couple.skin)
          ? of_other.IsInside()
          : more > 0 || (more == 0 && !is_of_a);
  if (!is_better) return;
  features = other;
  given = of_other;
}

/// What the faces across a normal give.
Given OfFaces(const Couple& couple, const Vec3& normal, Features& found) {
  if (!FindFace(couple, normal, found)) return {};
  Given given = Of(couple, found, normal);
  TakeParallel(couple, found, given);
  return given;
}

/// The edge that is farthest along a normal, if there is one. False if a face is, or two edges are.
bool FindOnlyEdge(const Couple& couple, const Vec3& normal, Edge& edge) {
  Edge a, b;
  if (!FindEdge(couple, 1, -normal, a) || !FindEdge(couple, -1, Inverse(couple.turn, normal), b) ||
      (a.piece != 0 && b.piece != 0))
    return false;
  edge = a.piece != 0 ? a : b;
  return true;
}

/// Where parts that are curved together touch. The edge is found by the normal alone, so that it
/// does not depend on the search.
bool SetSmooth(const Couple& couple, double slop, Features& features, Separation& separation) {
  Edge edge;
  if (!FindOnlyEdge(couple, separation.normal, edge)) return false;
  const Settled settled = Settle(couple, edge, separation.normal);
  if (!settled.is_valid || !(settled.separation.gap >= separation.gap - slop)) return false;
  separation = settled.separation;
  features.kind = edge.piece == 0   ? Features::Kind::kSmooth
                  : edge.piece == 1 ? Features::Kind::kEdgeOfA
                                    : Features::Kind::kEdgeOfB;
  if (edge.piece != 0) SetEdge(edge, edge.piece == 1 ? features.of_a : features.of_b);
  return true;
}

/// Recall of such parts.
Recalled RecallSmooth(const Couple& couple, const Features& features, const Vec3& axis,
                      double reach) {
  const Edge edge = EdgeAcross(couple, features);
  const Settled settled = Settle(couple, edge, Normalized(axis));
  const Separation& separation = settled.separation;
  if (!settled.is_valid || !settled.is_certain || !(std::abs(separation.gap) > couple.skin))
    return {};
  if (separation.gap > reach) return {separation, true, true};
  // What a search would find by this normal.
  Edge farthest;
  Features faces;
  const bool is_found = FindOnlyEdge(couple, separation.normal, farthest) &&
                        farthest.piece == edge.piece && farthest.is_axis == edge.is_axis &&
                        farthest.low == edge.low && farthest.high == edge.high &&
                        !OfFaces(couple, separation.normal, faces).IsInside();
  return {separation, is_found && IsSolved(couple, separation), true};
}

}  // namespace

bool SetFeatures(const Couple& couple, const DifferenceVertex* simplex, int count,
                 Features& features, Separation& separation) {
  features.kind = Features::Kind::kNone;
  if (std::max(couple.a.count, couple.b.count) >= Features::kAxis) return false;
  const double slop = couple.is_curved ? 1e3 * couple.rounding : couple.skin;
  const Vec3 normal = separation.normal;
  Features found;
  Given given = OfFaces(couple, normal, found);
  const auto is_given = [&] {
    return given.is_valid && given.separation.gap >= separation.gap - slop &&
           (!couple.is_curved || given.IsInside());
  };
  if (found.kind == Features::Kind::kNone && SetEdges(couple, simplex, count, normal, found)) {
    found.kind = Features::Kind::kEdges;
    given = Of(couple, found, normal);
  }
  if (!is_given()) return couple.is_curved && SetSmooth(couple, slop, features, separation);
  separation.normal = given.separation.normal;
  separation.gap = given.separation.gap;
  if (given.IsInside()) separation = given.separation;
  features = found;
  return true;
}

Recalled Recall(const Couple& couple, const Memory& memory, const Vec3& axis, double reach) {
  Features features = memory.features;
  if (IsSmooth(features.kind)) return RecallSmooth(couple, features, axis, reach);
  Given given = Of(couple, features, axis);
  if (given.separation.gap <= reach && IsFace(features.kind)) TakeParallel(couple, features, given);
  const Separation& separation = given.separation;
  Recalled recalled{.separation = separation, .has_points = given.IsInside()};
  Features face;
  if (!given.is_valid || (separation.gap <= reach && features.kind == Features::Kind::kEdges &&
                          FindFace(couple, separation.normal, face)))
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
