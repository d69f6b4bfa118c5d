// The last digits of the separation of curved surfaces. The extent of a convex set along a unit
// vector is least where its gradient on the sphere, the part of the support point across the
// vector, is zero; its second derivatives are the radii of curvature less the extent. Source:
// Schneider, Convex Bodies: The Brunn-Minkowski Theory, 2014, section 2.5.
#include <algorithm>
#include <cmath>

#include "library/detectors/narrow/couple.h"

namespace cdb::narrow {
namespace {

/// How the support point of a piece moves as the direction turns: a symmetric form.
struct Bend {
  const Piece& piece;
  Vec3 square = {}, along = {};
  double part = 0;

  Bend(const Piece& of, const Vec3& direction) : piece(of) {
    if (!IsCurved(piece.kind) || IsTip(direction)) return;
    const Vec3& half = piece.half;
    square = {half.x * half.x, piece.kind == Kind::kRound ? half.y * half.y : 0, half.z * half.z};
    along = {square.x * direction.x, square.y * direction.y, square.z * direction.z};
    const double length = std::sqrt(Dot(along, direction));
    if (length > 1e-150) part = 1 / length;
  }
  double Of(const Vec3& u, const Vec3& v) const {
    const double straight = u.x * square.x * v.x + u.y * square.y * v.y + u.z * square.z * v.z;
    return part * (straight - part * part * Dot(along, u) * Dot(along, v));
  }

 private:
  bool IsTip(const Vec3& direction) const {
    return piece.kind == Kind::kCone &&
           2 * piece.half.y * direction.y > RimOf(piece, direction).length;
  }
};

/// The second derivatives of the extent of the difference along a unit vector that turns.
class Curvature {
 public:
  Curvature(const Couple& couple, const Vec3& direction, double extent)
      : turn_(couple.turn),
        of_a_(couple.a, direction),
        of_b_(couple.b, Inverse(couple.turn, -direction)),
        extent_(extent) {}
  /// Of unit vectors across the direction, with each other.
  double Of(const Vec3& u) const {
    const Vec3 local = Inverse(turn_, u);
    return of_a_.Of(u, u) + of_b_.Of(local, local) - extent_;
  }
  double OfBoth(const Vec3& u, const Vec3& v) const {
    return of_a_.Of(u, v) + of_b_.Of(Inverse(turn_, u), Inverse(turn_, v));
  }

 private:
  const Rotation& turn_;
  const Bend of_a_, of_b_;
  const double extent_;
};

/// Sets the step across the direction to where the extent is least: Newton's along directions in
/// which it is curved upwards, none along others. False if there are others.
bool StepFrom(const Curvature& curvature, const Vec3& direction, const Vec3& point, double least,
              Vec3& step) {
  const Vec3 u = UnitAcross(direction), v = Cross(direction, u);
  const double uu = curvature.Of(u), uv = curvature.OfBoth(u, v), vv = curvature.Of(v);
  const double slope_u = Dot(point, u), slope_v = Dot(point, v);
  // The eigenvalues, and the direction of the greater one.
  const double middle = (uu + vv) / 2, difference = (uu - vv) / 2,
               radius = std::sqrt(difference * difference + uv * uv);
  if (middle - radius > least) {
    const double part = 1 / (uu * vv - uv * uv);
    step = part * ((uv * slope_v - vv * slope_u) * u + (uv * slope_u - uu * slope_v) * v);
    return true;
  }
  if (middle + radius <= least) return false;
  const Vec3 most =
      difference > 0 ? (difference + radius) * u + uv * v : uv * u + (radius - difference) * v;
  const double square = SquaredNorm(most);
  if (square > 0) step = -Dot(point, most) / (square * (middle + radius)) * most;
  return false;
}

/// The same, and only across the edge.
bool StepAcross(const Curvature& curvature, const Vec3& edge, const Vec3& direction,
                const Vec3& point, double least, Vec3& step) {
  const Vec3 way = Normalized(Cross(direction, edge));
  const double curved = curvature.Of(way);
  if (!(curved > least)) return false;
  step = -Dot(point, way) / curved * way;
  return true;
}

/// Adds the edge or line of a piece along which these three of its points lie. `which`: as
/// Edge::piece.
void AddEdge(const Couple& couple, int which, const Vec3 (&at)[3], const std::uint32_t (&vertex)[3],
             Edges& edges) {
  const Piece& piece = which > 0 ? couple.a : couple.b;
  Edge edge;
  if (IsCurved(piece.kind)) {
    edge = AxisOf(couple, which);
    const auto is_above = [&](const Vec3& v) { return Dot(edge.along, v - edge.middle) > 0; };
    const bool is_first = is_above(at[0]);
    if (!(SquaredNorm(edge.along) > 0) ||
        (is_above(at[1]) == is_first && is_above(at[2]) == is_first))
      return;
    if (piece.kind == Kind::kCone) edges.count = 3;
  } else {
    const std::uint32_t other = vertex[1] != vertex[0] ? vertex[1] : vertex[2];
    if (other == vertex[0]) return;
    if (vertex[2] != vertex[0] && vertex[2] != other) edges.count = 3;
    edge = EdgeOf(couple, which, vertex[0], other);
  }
  if (edges.count < 2) edges.of[edges.count] = edge;
  edges.count = std::min(edges.count + 1, 3);
}

/// Moves the nearest points along the edge to below the origin. False if that is beyond
/// an end, or if they are not on it.
bool SlideAlong(const Edge& edge, const DifferenceVertex& vertex, Separation& separation) {
  const double square = SquaredNorm(edge.along), sign = edge.piece,
               place = sign * Dot(vertex.at, edge.along) / square;
  const Vec3 shift = -sign * place * edge.along;
  Vec3& end = edge.piece > 0 ? separation.on_a : separation.on_b;
  if (!edge.EndsIn(end)) return false;
  const bool is_top = Dot(end - edge.middle, edge.along) > 0;
  end = end + sign * shift;
  return is_top ? place >= 0 && place <= 1 : place <= 0 && place >= -1;
}

}  // namespace

Edge AxisOf(const Couple& couple, int which) {
  const Piece& piece = which > 0 ? couple.a : couple.b;
  const double straight = piece.kind == Kind::kRound ? piece.straight : piece.half.y;
  return {.piece = which,
          .along = 2 * straight * (which > 0 ? Vec3{0, 1, 0} : couple.turn.y),
          .middle = which > 0 ? Vec3{0, 0, 0} : couple.place,
          .is_axis = true};
}

Edge EdgeOf(const Couple& couple, int which, std::uint32_t from, std::uint32_t to) {
  const auto [low, high] = std::minmax({from, to});
  const auto at = [&](std::uint32_t i) {
    return which > 0 ? couple.a.Vertex(i) : couple.ToA(couple.b.Vertex(i));
  };
  Edge edge{
      .piece = which, .along = at(high) - at(low), .middle = at(low), .low = low, .high = high};
  edge.middle = edge.middle + 0.5 * edge.along;
  return edge;
}

Edges::Edges(const Couple& couple, const DifferenceVertex& a, const DifferenceVertex& b,
             const DifferenceVertex& c) {
  AddEdge(couple, 1, {a.on_a, b.on_a, c.on_a}, {a.vertex_a, b.vertex_a, c.vertex_a}, *this);
  AddEdge(couple, -1, {a.on_b, b.on_b, c.on_b}, {a.vertex_b, b.vertex_b, c.vertex_b}, *this);
}

Polished Polish(const Couple& couple, const Edge& edge, int steps, Separation& separation) {
  constexpr double kLargest = 0.3, kLeast = 1e-8, kClose = 1e-5;  // rad
  const double least = 1e-3 * std::min(couple.a.bound, couple.b.bound);
  Vec3 direction = -separation.normal;
  if (edge.piece != 0)
    direction =
        Normalized(direction - Dot(direction, edge.along) / SquaredNorm(edge.along) * edge.along);
  DifferenceVertex vertex = couple.Support(direction);
  double extent = Dot(vertex.at, direction), angle = 1;
  bool is_smooth = false;
  for (int i = 0; i < steps; ++i) {
    const Curvature curvature(couple, direction, extent);
    Vec3 step = {0, 0, 0};
    if (edge.piece != 0) {
      is_smooth = StepAcross(curvature, edge.along, direction, vertex.at, least, step);
    } else {
      is_smooth = StepFrom(curvature, direction, vertex.at, least, step);
    }
    angle = Norm(step);
    if (!(angle > kLeast)) break;
    if (angle > kLargest) step = kLargest / angle * step;
    const Vec3 next = Normalized(direction + step);
    const DifferenceVertex there = couple.Support(next);
    const double less = Dot(there.at, next);
    if (!(less < extent)) break;
    direction = next;
    vertex = there;
    extent = less;
  }
  if (!(-extent > separation.gap)) return {vertex, false};
  separation = {-direction, -extent, separation.on_a, separation.on_b};
  // Newton's steps end at the square of the last one.
  if (!is_smooth || angle > kClose) return {vertex, false};
  Separation touching = {-direction, -extent, vertex.on_a, vertex.on_b};
  if (edge.piece != 0 && !SlideAlong(edge, vertex, touching)) return {vertex, false};
  separation = touching;
  return {vertex, true};
}

}  // namespace cdb::narrow
