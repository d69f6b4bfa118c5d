// Source: Gregorius, The separating axis test between convex polyhedra, GDC 2013 (clipping), and
// Robust contact creation for physics simulations, GDC 2015 (reduction); Sutherland & Hodgman,
// Reentrant polygon clipping, 1974.
#include "library/detectors/narrow/manifold.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace cdb::narrow {
namespace {

/// Least cosine of a face and the normal at which the face is seen from the front.
constexpr double kFacing = 0.05;
/// Largest sine of the angle of two lines that touch along each other, and how far apart they are
/// at most in radii of the smaller piece: then the gap of round sides is about that of the lines.
constexpr double kParallel = 0.02, kBeside = 0.02;
/// Corners of faces of which all are considered; of larger faces, every n-th.
constexpr std::size_t kMostCorners = 64;

struct Corner {
  double x, y;
};

/// The feature of a piece that faces the other, seen along the normal: a point, a segment or a
/// polygon, counter-clockwise; and its height along the normal, which is linear.
struct Feature {
  std::array<Corner, kMostCorners> corners;
  std::size_t count = 0;
  double height = 0, slope_x = 0, slope_y = 0;  ///< at (0, 0), and per m

  double HeightAt(const Corner& at) const { return height + slope_x * at.x + slope_y * at.y; }
};

struct Plane {
  Vec3 u, v, normal;
  Corner Of(const Vec3& at) const { return {Dot(u, at), Dot(v, at)}; }
};

/// Sets the line from `low` to `high`.
void SetLine(const Vec3& low, const Vec3& high, const Plane& plane, Feature& feature) {
  const Corner &from = feature.corners[0] = plane.Of(low),
               &to = feature.corners[1] = plane.Of(high);
  feature.count = 2;
  const Corner along = {to.x - from.x, to.y - from.y};
  const double rise = Dot(plane.normal, high - low) / (along.x * along.x + along.y * along.y);
  feature.slope_x = rise * along.x;
  feature.slope_y = rise * along.y;
  feature.height = Dot(plane.normal, low) - feature.slope_x * from.x - feature.slope_y * from.y;
}

/// Of a capsule that lies along the plane: the line on its surface that is nearest to it.
void LieDown(const Piece& piece, const Rotation& turn, const Vec3& place, const Plane& plane,
             double sign, Feature& feature) {
  const Vec3 way = sign * plane.normal;
  const double tilt = Dot(turn.y, way);
  if (std::abs(tilt) > kLying) return;
  const Vec3 middle = place + piece.radius * Normalized(way - tilt * turn.y);
  SetLine(middle - piece.half.y * turn.y, middle + piece.half.y * turn.y, plane, feature);
}

/// Of a piece at a pose in the frame of a, that faces along `sign` times the normal.
void FindFeature(const Piece& piece, const Rotation& turn, const Vec3& place, const Plane& plane,
                 double sign, Feature& feature) {
  const Vec3 local = Inverse(turn, sign * plane.normal);
  feature.count = 0;
  if (piece.kind == Kind::kCapsule) return LieDown(piece, turn, place, plane, sign, feature);
  const Facing facing = FacingOf(piece, local);
  if (facing.is_line)
    return SetLine(turn * facing.from + place, turn * facing.to + place, plane, feature);
  if (facing.face == nullptr) return;
  const FlatFace& face = *facing.face;
  if (Dot(face.normal, local) < kFacing) return;
  const Vec3 normal = turn * face.normal;
  const double along = Dot(normal, plane.normal);
  feature.slope_x = -Dot(normal, plane.u) / along;
  feature.slope_y = -Dot(normal, plane.v) / along;
  feature.height = (face.offset + Dot(normal, place)) / along;
  const std::size_t step = (face.count + kMostCorners - 1) / kMostCorners;
  for (std::size_t i = 0; i < face.count; i += step)
    feature.corners[feature.count++] =
        plane.Of(turn * piece.Vertex(piece.corners[face.first + i]) + place);
  // From outside of a, the normal points away.
  if (sign < 0) std::reverse(feature.corners.begin(), feature.corners.begin() + feature.count);
}

using Outline = std::array<Corner, 2 * kMostCorners + 4>;

/// The part of the polygon or segment on the left of the line from `from` to `to`.
std::size_t ClipAtLine(const Corner* in, std::size_t count, const Corner& from, const Corner& to,
                       Corner* out) {
  const double x = to.x - from.x, y = to.y - from.y;
  const auto left = [&](const Corner& at) { return x * (at.y - from.y) - y * (at.x - from.x); };
  std::size_t made = 0;
  const std::size_t sides = count == 2 ? 1 : count;
  double here = left(in[0]);
  if (here >= 0) out[made++] = in[0];
  for (std::size_t i = 0; i < sides; ++i) {
    const Corner &a = in[i], &b = in[i + 1 == count ? 0 : i + 1];
    const double there = left(b);
    if ((here > 0 && there < 0) || (here < 0 && there > 0)) {
      const double part = here / (here - there);
      out[made++] = {a.x + part * (b.x - a.x), a.y + part * (b.y - a.y)};
    }
    if (there >= 0 && (count == 2 || i + 1 < sides)) out[made++] = b;
    here = there;
  }
  return made;
}

/// The intersection of two features, of which the second is a polygon.
std::size_t Clip(const Feature& one, const Feature& polygon, Outline& result) {
  Outline other;
  Corner *in = other.data(), *out = result.data();
  std::size_t count = one.count;
  std::copy_n(one.corners.begin(), count, out);
  for (std::size_t i = 0; i < polygon.count && count > 0; ++i) {
    std::swap(in, out);
    count = ClipAtLine(in, count, polygon.corners[i],
                       polygon.corners[i + 1 == polygon.count ? 0 : i + 1], out);
    count = std::min(count, result.size() - 4);
  }
  if (out != result.data()) std::copy_n(out, count, result.begin());
  return count;
}

/// The ends, on b, of the part of two lines in which they are side by side, if they are no farther
/// than `beside` m apart there.
std::size_t CommonPart(const Feature& a, const Feature& b, double beside, Outline& result) {
  const Corner &from_a = a.corners[0], &from = b.corners[0];
  const Corner along_a = {a.corners[1].x - from_a.x, a.corners[1].y - from_a.y},
               along = {b.corners[1].x - from.x, b.corners[1].y - from.y};
  const double cross = along_a.x * along.y - along_a.y * along.x;
  const double square_a = along_a.x * along_a.x + along_a.y * along_a.y,
               square = along.x * along.x + along.y * along.y;
  if (cross * cross > kParallel * kParallel * square * square_a) return 0;
  const auto apart = [&](const Corner& at) {
    return std::abs((at.x - from_a.x) * along_a.y - (at.y - from_a.y) * along_a.x);
  };
  const auto place = [&](const Corner& at) {
    return ((at.x - from.x) * along.x + (at.y - from.y) * along.y) / square;
  };
  const auto [first, last] = std::minmax({place(a.corners[0]), place(a.corners[1])});
  const double low = std::max(first, 0.0), high = std::min(last, 1.0);
  if (!(low < high)) return 0;
  std::size_t count = 0;
  for (const double t : {low, high}) {
    const Corner at = {from.x + t * along.x, from.y + t * along.y};
    if (apart(at) <= beside * std::sqrt(square_a)) result[count++] = at;
  }
  return count;
}

}  // namespace

void Manifold::Reduce(double slop) {
  if (size_ <= kMostPoints) return;
  const std::span<Point> all = points();
  double deepest = all[0].gap;
  for (const Point& point : all) deepest = std::min(deepest, point.gap);
  // Where equally deep points are far apart, any direction serves to choose one of them.
  const Vec3 normal = all[0].normal, u = UnitAcross(normal);
  const auto take = [&](std::size_t place, auto score) {
    std::size_t best = place;
    double most = score(all[place]);
    for (std::size_t i = place + 1; i < all.size(); ++i)
      if (const double other = score(all[i]); other > most) most = other, best = i;
    std::swap(all[place], all[best]);
  };
  take(0, [&](const Point& point) {
    return point.gap <= deepest + slop ? Dot(u, point.on_b) : -kernels::kInfinity;
  });
  const Vec3 first = all[0].on_b;
  take(1, [&](const Point& point) { return SquaredNorm(point.on_b - first); });
  const Vec3 second = all[1].on_b;
  const auto area = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    return Dot(normal, Cross(b - a, c - a));
  };
  take(2, [&](const Point& point) { return std::abs(area(first, second, point.on_b)); });
  const Vec3 third = all[2].on_b;
  const double sign = area(first, second, third) < 0 ? -1 : 1;
  take(3, [&](const Point& point) {  // the area that it adds to the triangle
    const Vec3& at = point.on_b;
    return std::max({-sign * area(first, second, at), -sign * area(second, third, at),
                     -sign * area(third, first, at)});
  });
  size_ = kMostPoints;
  // The deepest of all is one of the four.
  Point* kept = &*std::ranges::min_element(all.first(kMostPoints), {}, &Point::gap);
  const Point& least = *std::ranges::min_element(all, {}, &Point::gap);
  if (least.gap < kept->gap - 1e-6 * slop) *kept = least;
}

const FlatFace& FacingFace(const Piece& piece, const Vec3& direction) {
  if (piece.kind == Kind::kBox) {
    const double along[] = {direction.x, direction.y, direction.z};
    int axis = std::abs(along[1]) > std::abs(along[0]) ? 1 : 0;
    if (std::abs(along[2]) > std::abs(along[axis])) axis = 2;
    return piece.faces[2 * axis + (along[axis] > 0 ? 1 : 0)];
  }
  if (IsCurved(piece.kind)) return piece.faces[piece.faces.size() > 1 && direction.y > 0 ? 1 : 0];
  return piece.faces[FarthestOf(piece.face_columns.data(), piece.padded_faces, direction)];
}

double InsetOf(const Piece& piece, const FlatFace& face, const Vec3& point) {
  if (IsCurved(piece.kind)) {
    const double x = point.x / piece.half.x, z = point.z / piece.half.z;
    return (1 - std::sqrt(x * x + z * z)) * std::min(piece.half.x, piece.half.z);
  }
  double inset = kernels::kInfinity;
  for (std::uint32_t i = 0; i < face.count; ++i) {
    const Vec3 from = piece.Vertex(piece.corners[face.first + i]),
               to = piece.Vertex(piece.corners[face.first + (i + 1 == face.count ? 0 : i + 1)]);
    const double area = Dot(face.normal, Cross(to - from, point - from));
    inset = std::min(inset, area / Norm(to - from));
  }
  return inset;
}

Facing FacingOf(const Piece& piece, const Vec3& direction) {
  if (piece.kind == Kind::kBox || piece.kind == Kind::kHull)
    return {.face = &FacingFace(piece, direction)};
  if (piece.faces.empty()) return {};
  const Scaled rim = RimOf(piece, direction);
  const Vec3 across = rim.Farthest();
  const double height = piece.half.y, middle = piece.centre.y;
  Facing line{.is_line = true,
              .from = {across.x, middle - height, across.z},
              .to = {0, middle + height, 0}};
  if (piece.kind == Kind::kCylinder) line.to = {across.x, height, across.z};
  const Vec3 along = line.to - line.from;
  const double tilt = Dot(along, direction);
  if (rim.length > 0 && tilt * tilt <= kLying * kLying * SquaredNorm(along)) return line;
  if (piece.kind == Kind::kCylinder) return {.face = &FacingFace(piece, direction)};
  return {.face = direction.y < 0 ? &piece.faces[0] : nullptr};
}

bool AddFacingPoints(const Couple& couple, const Separation& separation, Manifold& manifold) {
  const Piece &a = couple.a, &b = couple.b;
  const Vec3& normal = separation.normal;
  Plane plane{.u = UnitAcross(normal), .v = {}, .normal = normal};
  plane.v = Cross(normal, plane.u);
  Feature of_a, of_b;
  FindFeature(a, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}, plane, -1, of_a);
  if (of_a.count > 0) FindFeature(b, couple.turn, couple.place, plane, 1, of_b);
  if (of_a.count == 0 || of_b.count == 0) return false;
  Outline outline;
  std::size_t count = 0;
  if (of_a.count == 2 && of_b.count == 2) {
    count = CommonPart(of_a, of_b, kBeside * std::min(a.bound, b.bound), outline);
  } else {
    count = of_a.count == 2 ? Clip(of_a, of_b, outline) : Clip(of_b, of_a, outline);
  }
  const double exact = separation.gap - a.radius - b.radius;
  double least = kernels::kInfinity;
  for (std::size_t i = 0; i < count; ++i) {
    const Corner& at = outline[i];
    const double height = of_b.HeightAt(at), gap = of_a.HeightAt(at) - height;
    least = std::min(least, gap);
    if (gap > kNear) continue;
    manifold.Add(at.x * plane.u + at.y * plane.v + height * normal, normal, gap);
  }
  const double tolerance = kSameGap * std::min(a.bound, b.bound) + 1e3 * couple.rounding;
  return least <= exact + tolerance;
}

void AddDeepest(const Vec3& on_b, const Vec3& normal, double gap, double beside,
                Manifold& manifold) {
  Point* nearest = nullptr;
  double least = beside * beside;
  for (Point& point : manifold.points())
    if (const double square = SquaredNorm(point.on_b - on_b); square < least)
      least = square, nearest = &point;
  if (nearest != nullptr) {
    *nearest = {on_b, normal, gap};
  } else {
    manifold.Add(on_b, normal, gap);
  }
}

double BesideOf(const Piece& piece) {
  // The end of a capsule that lies is beside the end of its line.
  if (piece.radius > 0) return 1.5 * kLying * piece.radius;
  // Half the way from one corner of a rim to the next, and a little more.
  return IsCurved(piece.kind) ? 0.42 * std::min(piece.half.x, piece.half.z) : 0;
}

void AddNearest(const Couple& couple, const Separation& separation, Manifold& manifold) {
  const Piece &a = couple.a, &b = couple.b;
  const Vec3& normal = separation.normal;
  Separation touching = separation;
  if (couple.is_curved) Meet(couple, touching);
  AddDeepest(touching.on_b + b.radius * normal, normal, separation.gap - a.radius - b.radius,
             BesideOf(a) + BesideOf(b), manifold);
}

}  // namespace cdb::narrow
