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
/// which it is curved upwards by more than `least`, none along others. Returns the least curvature.
double StepFrom(const Curvature& curvature, const Vec3& direction, const Vec3& point, double least,
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
    return middle - radius;
  }
  if (middle + radius <= least) return middle - radius;
  const Vec3 most =
      difference > 0 ? (difference + radius) * u + uv * v : uv * u + (radius - difference) * v;
  const double square = SquaredNorm(most);
  if (square > 0) step = -Dot(point, most) / (square * (middle + radius)) * most;
  return middle - radius;
}

/// The same, and only across the edge.
double StepAcross(const Curvature& curvature, const Vec3& edge, const Vec3& direction,
                  const Vec3& point, double least, Vec3& step) {
  const Vec3 way = Normalized(Cross(direction, edge));
  const double curved = curvature.Of(way);
  if (curved > least) step = -Dot(point, way) / curved * way;
  return curved;
}

/// The normals of the lines on a cone, from a to b: a function of an angle about the axis that is
/// linear in its cosine and sine, and along which the cone itself extends equally far.
class Slant {
 public:
  Slant(const Couple& couple, int which)
      : couple_(couple), which_(which), piece_(which > 0 ? couple.a : couple.b) {
    if (which > 0) return;
    // In single precision, axes are not quite orthogonal.
    const auto& [x, y, z] = couple.turn;
    normals_ = {-Cross(y, z), -Cross(z, x), -Cross(x, y)};
  }

  /// Of the line whose normal is nearest to a direction.
  void SetAngle(const Vec3& direction) {
    const Vec3 local = ToCone(direction);
    const double x = piece_.half.x * local.x, z = piece_.half.z * local.z,
                 length = std::sqrt(x * x + z * z);
    cosine_ = length > 0 ? x / length : 1;
    sine_ = length > 0 ? z / length : 0;
  }
  /// Of the line whose normal is across an edge, of two the one nearer to a direction. False if
  /// there is none.
  bool SetAngleAcross(const Vec3& edge, const Vec3& direction) {
    const double x = Dot(edge, normals_.x) / piece_.half.x,
                 z = Dot(edge, normals_.z) / piece_.half.z,
                 y = Dot(edge, normals_.y) / (2 * piece_.half.y), square = x * x + z * z,
                 rest = square - y * y;
    if (!(rest >= 0) || !(square > 0)) return false;
    const double root = std::sqrt(rest);
    Slant other = *this;
    cosine_ = (-y * x - root * z) / square;
    sine_ = (-y * z + root * x) / square;
    other.cosine_ = (-y * x + root * z) / square;
    other.sine_ = (-y * z - root * x) / square;
    if (Dot(other.Normal(), direction) * Norm(Normal()) >
        Dot(Normal(), direction) * Norm(other.Normal()))
      cosine_ = other.cosine_, sine_ = other.sine_;
    return true;
  }
  /// Not of unit length, and its first two derivatives.
  Vec3 Normal() const { return Of(cosine_, 1, sine_); }
  Vec3 First() const { return Of(-sine_, 0, cosine_); }
  Vec3 Second() const { return Of(-cosine_, 0, -sine_); }
  Vec3 Tip() const { return ToA({0, piece_.centre.y + piece_.half.y, 0}); }
  Edge Line() const {
    const Vec3 tip = Tip(), low = ToA({cosine_ * piece_.half.x, piece_.centre.y - piece_.half.y,
                                       sine_ * piece_.half.z});
    return {.piece = which_,
            .along = tip - low,
            .middle = 0.5 * (tip + low),
            .is_axis = true,
            .is_slant = true};
  }

 private:
  Vec3 Of(double x, double y, double z) const {
    return normals_ * Vec3{x / piece_.half.x, y / (2 * piece_.half.y), z / piece_.half.z};
  }
  Vec3 ToCone(const Vec3& direction) const {
    return which_ > 0 ? direction : Inverse(couple_.turn, -direction);
  }
  Vec3 ToA(const Vec3& local) const { return which_ > 0 ? local : couple_.ToA(local); }

  const Couple& couple_;
  const int which_;
  const Piece& piece_;
  Rotation normals_ = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  ///< from the frame of the cone
  double cosine_ = 1, sine_ = 0;
};

/// As StepAcross, around a cone: of h(d) / |d|, by the angle of its line, h the extent of the
/// difference along d.
double StepAround(const Couple& couple, int which, const Vec3& direction,
                  const DifferenceVertex& vertex, double extent, double least, Vec3& step) {
  Slant slant(couple, which);
  slant.SetAngle(direction);
  const Vec3 first = slant.First(), tip = slant.Tip(),
             across = (which > 0 ? tip - vertex.on_b : vertex.on_a - tip) - extent * direction;
  const double length = Norm(slant.Normal()), along = Dot(direction, first),
               square = SquaredNorm(first) - along * along;
  const auto to_other = [&](const Vec3& v) { return which > 0 ? Inverse(couple.turn, -v) : v; };
  const Bend bend(which > 0 ? couple.b : couple.a, to_other(direction));
  const Vec3 turned = to_other(first);
  const double bent =
                   bend.Of(turned, turned) + length * Dot(across, slant.Second()) - extent * square,
               curved = bent / square;
  if (curved > least) step = -Dot(across, first) / bent * (first - along * direction);
  return curved;
}

/// The nearest direction across the edge, if there is one.
Vec3 AcrossEdge(const Couple& couple, const Edge& edge, const Vec3& direction) {
  if (edge.piece == 0) return direction;
  if (edge.is_slant) {
    Slant slant(couple, edge.piece);
    slant.SetAngle(direction);
    return Normalized(slant.Normal());
  }
  return Normalized(direction - Dot(direction, edge.along) / SquaredNorm(edge.along) * edge.along);
}

/// A direction from a to b, and how far the difference extends along it.
struct Way {
  Vec3 direction;
  DifferenceVertex vertex;
  double extent;

  Way(const Couple& couple, const Vec3& along)
      : direction(along), vertex(couple.Support(along)), extent(Dot(vertex.at, along)) {}
  /// Newton's step to where the extent is least, and only across the edge if there is one.
  Vec3 StepOf(const Couple& couple, const Edge& edge, double least, double& curved) const {
    Vec3 step = {0, 0, 0};
    if (edge.is_slant) {
      curved = StepAround(couple, edge.piece, direction, vertex, extent, least, step);
      return step;
    }
    const Curvature curvature(couple, direction, extent);
    curved = edge.piece != 0 ? StepAcross(curvature, edge.along, direction, vertex.at, least, step)
                             : StepFrom(curvature, direction, vertex.at, least, step);
    return step;
  }
  Separation ToSeparation() const { return {-direction, -extent, vertex.on_a, vertex.on_b}; }
};

/// The unit vector along a direction, and across the edge if there is one.
Vec3 Next(const Couple& couple, const Edge& edge, const Vec3& direction) {
  return AcrossEdge(couple, edge, Normalized(direction));
}

/// m: surfaces that are curved less are flat.
double LeastCurved(const Couple& couple) { return 1e-3 * std::min(couple.a.bound, couple.b.bound); }

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
          .is_axis = true,
          .is_slant = piece.kind == Kind::kCone};
}

Edge LineAlong(const Couple& couple, const Edge& edge, const Vec3& direction) {
  if (!edge.is_slant) return edge;
  Slant slant(couple, edge.piece);
  slant.SetAngle(direction);
  return slant.Line();
}

Edge LineAcross(const Couple& couple, const Edge& edge, const Edge& other, const Vec3& direction) {
  if (!edge.is_slant) return edge;
  Slant slant(couple, edge.piece);
  return slant.SetAngleAcross(other.along, direction) && Dot(slant.Normal(), direction) > 0
             ? slant.Line()
             : Edge();
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
  const double least = LeastCurved(couple);
  Way best(couple, AcrossEdge(couple, edge, -separation.normal));
  double angle = 1, curved = 0;
  for (int i = 0; i < steps; ++i) {
    Vec3 step = best.StepOf(couple, edge, least, curved);
    angle = Norm(step);
    if (!(angle > kLeast)) break;
    if (angle > kLargest) step = kLargest / angle * step;
    const Way next(couple, Next(couple, edge, best.direction + step));
    if (!(next.extent < best.extent)) break;
    best = next;
  }
  Separation touching = best.ToSeparation();
  if (!(touching.gap > separation.gap)) return {best.vertex, false};
  separation.normal = touching.normal;
  separation.gap = touching.gap;
  // Newton's steps end at the square of the last one.
  if (!(curved > least) || angle > kClose) return {best.vertex, false};
  if (edge.piece != 0 &&
      !SlideAlong(LineAlong(couple, edge, best.direction), best.vertex, touching))
    return {best.vertex, false};
  separation = touching;
  return {best.vertex, true};
}

Settled Settle(const Couple& couple, const Edge& edge, const Vec3& normal) {
  constexpr double kLargest = 0.3, kEnd = 1e-8;          // rad
  constexpr double kDigit = 0x1p-28, kRound = 0x1.8p24;  // a sum with it loses smaller digits
  constexpr int kMostSteps = 8;
  const double least = LeastCurved(couple);
  Way way(couple, AcrossEdge(couple, edge, -normal));
  double angle = 1, curved = 0;
  for (int i = 0; angle > kEnd; ++i) {
    const Vec3 step = way.StepOf(couple, edge, least, curved);
    angle = Norm(step);
    if (i == kMostSteps || !(curved > least) || !(angle <= kLargest)) return {};
    way = Way(couple, Next(couple, edge, way.direction + step));
  }
  const Vec3& exact = way.direction;
  const auto round = [](double x) { return (x + kRound) - kRound; };
  const Vec3 rounded = {round(exact.x), round(exact.y), round(exact.z)}, cut = exact - rounded;
  // Of the last step, Newton's method leaves about the square.
  const double uncertain =
      (16 * couple.rounding + angle * angle * (couple.a.bound + couple.b.bound)) / curved + 1e-14;
  const Way settled(couple, Next(couple, edge, rounded));
  Settled found{.separation = settled.ToSeparation(), .is_valid = true};
  found.is_certain =
      std::max({std::abs(cut.x), std::abs(cut.y), std::abs(cut.z)}) + uncertain < kDigit / 2;
  if (edge.piece != 0)
    found.is_valid =
        SlideAlong(LineAlong(couple, edge, settled.direction), settled.vertex, found.separation);
  return found;
}

}  // namespace cdb::narrow
