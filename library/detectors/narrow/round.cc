// Closed forms of balls, capsules and planes. Source of the nearest points of segments: Ericson,
// Real-Time Collision Detection, 2005, section 5.1.9.
#include <algorithm>
#include <cmath>

#include "library/detectors/narrow/kernels.h"

namespace cdb::narrow {
namespace {

/// In sizes: the direction of a shorter vector is that of rounding errors.
constexpr double kRounding = 1e-13;

/// A segment about a middle.
struct Segment {
  Vec3 middle, along;  ///< along: unit
  double half;
  Vec3 At(double s) const { return middle + s * along; }
  double Nearest(const Vec3& point) const {
    return std::clamp(Dot(along, point - middle), -half, half);
  }
};

/// Adds the point of two balls around core points that are `between` apart, from b to a; if that is
/// no more than `rounding`, along `if_none`.
void AddRound(const Vec3& between, const Vec3& core_b, double radius_a, double radius_b,
              double rounding, const Vec3& if_none, Manifold& manifold) {
  const double radii = radius_a + radius_b, square = SquaredNorm(between);
  if (square > (radii + kNear) * (radii + kNear)) return;
  const double distance = std::sqrt(square);
  const Vec3 normal = distance > rounding ? 1 / distance * between : if_none;
  manifold.Add(core_b + radius_b * normal, normal, distance - radii);
}

/// Segments whose angle has a smaller sine lie along each other: they touch at two points.
constexpr double kParallel = 0.05;

/// Adds the points at the two ends of the part where segments lie along each other.
void AddEnds(const Segment& a, const Segment& b, double radius_a, double radius_b,
             const Vec3& normal, Manifold& manifold) {
  const double middle = Dot(a.along, b.middle - a.middle);
  const double reach = b.half * std::abs(Dot(a.along, b.along));
  const double from = std::max(-a.half, middle - reach), to = std::min(a.half, middle + reach);
  if (!(from < to)) return;
  for (const double s : {from, to}) {
    Vec3 on_a = a.At(s);
    const double t = b.Nearest(on_a);
    const Vec3 on_b = b.At(t);
    if (std::abs(t) == b.half) on_a = a.At(a.Nearest(on_b));
    const Vec3 between = on_a - on_b;
    if (Dot(between, normal) < 0.9 * Norm(between)) continue;  // on different sides
    AddRound(between, on_b, radius_a, radius_b, 0, normal, manifold);
  }
}

Segment AxisOf(const Placed& capsule, const Vec3& middle) {
  return {middle, capsule.pose.y, capsule.piece.half.y};
}

}  // namespace

// Balls get no contact before they touch, as in Bullet: it would take most of the speed of a bounce
// from them, and as they touch at one point, it would hold nothing.
void BallBall(const Placed& a, const Placed& b, Hint&, Manifold& manifold) {
  const Vec3 at_b = b.pose.position - a.pose.position;
  const double radii = a.piece.radius + b.piece.radius;
  if (SquaredNorm(at_b) > radii * radii) return;
  AddRound(-at_b, at_b, a.piece.radius, b.piece.radius, 1e-150, {0, 1, 0}, manifold);
}

void BallCapsule(const Placed& a, const Placed& b, Hint&, Manifold& manifold) {
  const Segment axis = AxisOf(b, b.pose.position - a.pose.position);
  const double t = axis.Nearest({0, 0, 0});
  const Vec3 nearest = axis.At(t);
  // Beside the axis, the way out is across it, which a short distance does not tell.
  Vec3 between = -nearest;
  if (std::abs(t) < axis.half) between = between - Dot(between, axis.along) * axis.along;
  AddRound(between, nearest, a.piece.radius, b.piece.radius, kRounding * b.piece.bound,
           UnitAcross(axis.along), manifold);
}

void CapsuleCapsule(const Placed& a, const Placed& b, Hint&, Manifold& manifold) {
  const Vec3 at_b = b.pose.position - a.pose.position;
  const double radii = a.piece.radius + b.piece.radius, far = a.piece.bound + b.piece.bound + kNear;
  if (SquaredNorm(at_b) > far * far) return;
  const Segment one = AxisOf(a, {0, 0, 0}), other = AxisOf(b, at_b);
  const Vec3 across = Cross(one.along, other.along);
  const double cosine = Dot(one.along, other.along), square_sine = SquaredNorm(across);
  const double d = Dot(one.along, at_b), e = Dot(other.along, at_b);
  // Of parallel segments, any s will do; with rounding, it is still in range.
  double s = square_sine > 0 ? std::clamp((d - cosine * e) / square_sine, -one.half, one.half) : 0;
  const double t = std::clamp(cosine * s - e, -other.half, other.half);
  s = std::clamp(cosine * t + d, -one.half, one.half);
  const Vec3 on_b = other.At(t), between = one.At(s) - on_b;
  const double distance = Norm(between);
  if (distance > radii + kNear) return;
  Vec3 normal = square_sine > 1e-24 ? Normalized(across) : UnitAcross(one.along);
  if (Dot(normal, distance > 0 ? between : -at_b) < 0) normal = -normal;
  // Of crossing axes, the way out is across both, which a short distance does not tell; from an end
  // of one, it is across the other.
  const bool is_inside = std::abs(s) < one.half, is_other_inside = std::abs(t) < other.half;
  if (distance > kRounding * far && !(is_inside && is_other_inside && square_sine > 1e-12)) {
    Vec3 way = between;
    if (is_inside) way = way - Dot(way, one.along) * one.along;
    if (is_other_inside) way = way - Dot(way, other.along) * other.along;
    normal = Normalized(way);
  }
  const std::size_t before = manifold.points().size();
  if (square_sine < kParallel * kParallel && distance > 0.1 * radii)
    AddEnds(one, other, a.piece.radius, b.piece.radius, normal, manifold);
  for (const Point& point : manifold.points().subspan(before))
    if (point.gap <= distance - radii + 1e-9 * far) return;
  manifold.Add(on_b + b.piece.radius * normal, normal, distance - radii);
}

void BallBox(const Placed& a, const Placed& b, Hint&, Manifold& manifold) {
  const Vec3 at_b = b.pose.position - a.pose.position, &half = b.piece.half;
  const double radius = a.piece.radius, far = b.piece.bound + radius + kNear;
  if (SquaredNorm(at_b) > far * far) return;
  const Rotation axes = AxesOf(b.pose);
  const Vec3 local = Inverse(axes, -at_b);
  Vec3 nearest = {std::clamp(local.x, -half.x, half.x), std::clamp(local.y, -half.y, half.y),
                  std::clamp(local.z, -half.z, half.z)};
  const Vec3 away = local - nearest;
  const double square = SquaredNorm(away);
  if (square > (radius + kNear) * (radius + kNear)) return;
  if (square > 0) {
    const double distance = std::sqrt(square);
    return manifold.Add(at_b + axes * nearest, axes * (1 / distance * away), distance - radius);
  }
  // The centre is inside: out over the nearest face.
  const double depth[] = {half.x - std::abs(local.x), half.y - std::abs(local.y),
                          half.z - std::abs(local.z)};
  const auto axis = std::min_element(depth, depth + 3) - depth;
  const double place[] = {local.x, local.y, local.z}, sign = place[axis] < 0 ? -1 : 1;
  const Vec3& column = axis == 0 ? axes.x : axis == 1 ? axes.y : axes.z;
  const Vec3 normal = sign * column;
  manifold.Add(depth[axis] * normal, normal, -depth[axis] - radius);
}

namespace {

/// Adds a core point of a, in its frame, if it is near the plane at `height` m below the origin.
struct PlaneSide {
  const Placed& a;
  Vec3 normal, local;  ///< in world axes, and in those of a
  double height;       ///< of the position of a
  double near;         ///< m: points that are no farther from the plane are added

  double HeightOf(const Vec3& core) const { return height + Dot(local, core); }
  void Add(const Vec3& core, Manifold& manifold) const {
    const double above = HeightOf(core), gap = above - a.piece.radius;
    if (gap > near) return;
    manifold.Add(AxesOf(a.pose) * core - above * normal, normal, gap);
  }
};

/// The lower end, and the surface beside the upper one if the capsule lies.
void AddCapsuleOnPlane(const PlaneSide& side, Manifold& manifold) {
  const Vec3 low = {0, std::copysign(side.a.piece.half.y, -side.local.y), 0};
  side.Add(low, manifold);
  if (std::abs(side.local.y) > kLying) return;
  const Vec3 away = Normalized({side.local.x, 0, side.local.z});
  const Vec3 high = -low - side.a.piece.radius * away;
  const double gap = side.HeightOf(high);
  if (gap <= side.near)
    manifold.Add(AxesOf(side.a.pose) * high - gap * side.normal, side.normal, gap);
}

void AddFaceOnPlane(const PlaneSide& side, Manifold& manifold) {
  const Piece& piece = side.a.piece;
  const Vec3 down = -side.local;
  const std::uint32_t deepest = FarthestVertex(piece, down);
  if (side.HeightOf(piece.Vertex(deepest)) > side.near) return;
  const FlatFace& face = FacingFace(piece, down);
  bool has_deepest = false;
  for (std::uint32_t i = face.first; i < face.first + face.count; ++i) {
    has_deepest |= piece.corners[i] == deepest;
    side.Add(piece.Vertex(piece.corners[i]), manifold);
  }
  if (!has_deepest) side.Add(piece.Vertex(deepest), manifold);
}

/// The corners of a base, or the ends of a line, and the lowest point.
void AddCurvedOnPlane(const PlaneSide& side, Manifold& manifold) {
  const Piece& piece = side.a.piece;
  const Vec3 down = -side.local, deepest = FarthestPoint(piece, down);
  const double gap = side.HeightOf(deepest);
  if (gap > side.near) return;
  const Facing facing = FacingOf(piece, down);
  if (facing.is_line) {
    side.Add(facing.from, manifold);
    side.Add(facing.to, manifold);
  } else if (facing.face != nullptr) {
    const FlatFace& face = *facing.face;
    for (std::uint32_t i = face.first; i < face.first + face.count; ++i)
      side.Add(piece.Vertex(piece.corners[i]), manifold);
  }
  for (const Point& point : manifold.points())
    if (point.gap <= gap + kSameGap * piece.bound) return;
  AddDeepest(AxesOf(side.a.pose) * deepest - gap * side.normal, side.normal, gap, BesideOf(piece),
             manifold);
}

}  // namespace

void AnyPlane(const Placed& a, const Placed& b, Hint&, Manifold& manifold) {
  const Piece& piece = a.piece;
  const Vec3 normal = AxesOf(b.pose) * b.piece.normal;
  const double height = Dot(normal, a.pose.position - b.pose.position);
  // As in Bullet, large bodies have contacts earlier, by their radius; but not round ones, which
  // would lose speed when they bounce.
  const double near = piece.faces.empty() ? kNear : std::max(kNear, kNear * piece.reach);
  if (height > piece.reach + near) return;
  const PlaneSide side = {a, normal, Inverse(AxesOf(a.pose), normal), height, near};
  if (piece.kind == Kind::kBall) return side.Add({0, 0, 0}, manifold);
  if (piece.kind == Kind::kCapsule) return AddCapsuleOnPlane(side, manifold);
  if (IsCurved(piece.kind)) {
    AddCurvedOnPlane(side, manifold);
  } else {
    AddFaceOnPlane(side, manifold);
  }
  manifold.Reduce(1e-3 * piece.bound);
}

}  // namespace cdb::narrow
