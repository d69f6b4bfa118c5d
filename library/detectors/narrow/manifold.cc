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

/// Of a capsule that lies along the plane: the line on its surface that is nearest to it.
void LieDown(const Piece& piece, const Rotation& turn, const Vec3& place, const Plane& plane,
             double sign, Feature& feature) {
  const Vec3 way = sign * plane.normal;
  const double tilt = Dot(turn.y, way);
  if (std::abs(tilt) > kLying) return;
  const Vec3 middle = place + piece.radius * Normalized(way - tilt * turn.y);
  const Vec3 low = middle - piece.half.y * turn.y, high = middle + piece.half.y * turn.y;
  const Corner &from = feature.corners[0] = plane.Of(low),
               &to = feature.corners[1] = plane.Of(high);
  feature.count = 2;
  const Corner along = {to.x - from.x, to.y - from.y};
  const double rise = Dot(plane.normal, high - low) / (along.x * along.x + along.y * along.y);
  feature.slope_x = rise * along.x;
  feature.slope_y = rise * along.y;
  feature.height = Dot(plane.normal, low) - feature.slope_x * from.x - feature.slope_y * from.y;
}

/// Of a piece at a pose in the frame of a, that faces along `sign` times the normal.
void FindFeature(const Piece& piece, const Rotation& turn, const Vec3& place, const Plane& plane,
                 double sign, Feature& feature) {
  const Vec3 local = Inverse(turn, sign * plane.normal);
  feature.count = 0;
  if (piece.kind == Kind::kCapsule) return LieDown(piece, turn, place, plane, sign, feature);
  if (piece.faces.empty()) return;
  const FlatFace& face = FacingFace(piece, local);
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
  return piece.faces[FarthestOf(piece.face_columns.data(), piece.padded_faces, direction)];
}

bool AddFacingPoints(const Couple& couple, const Separation& separation, Manifold& manifold) {
  const Piece &a = couple.a, &b = couple.b;
  const Vec3& normal = separation.normal;
  Plane plane{.u = UnitAcross(normal), .v = {}, .normal = normal};
  plane.v = Cross(normal, plane.u);
  Feature of_a, of_b;
  FindFeature(a, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}, plane, -1, of_a);
  if (of_a.count > 0) FindFeature(b, couple.turn, couple.place, plane, 1, of_b);
  double least = kernels::kInfinity;
  if (of_a.count > 0 && of_b.count > 0 && of_a.count + of_b.count > 4) {
    Outline outline;
    const std::size_t count =
        of_a.count == 2 ? Clip(of_a, of_b, outline) : Clip(of_b, of_a, outline);
    for (std::size_t i = 0; i < count; ++i) {
      const Corner& at = outline[i];
      const double height = of_b.HeightAt(at), gap = of_a.HeightAt(at) - height;
      least = std::min(least, gap);
      if (gap > kNear) continue;
      manifold.Add(at.x * plane.u + at.y * plane.v + height * normal, normal, gap);
    }
  }
  const double tolerance = kSameGap * std::min(a.bound, b.bound) + 1e3 * couple.rounding;
  return least <= separation.gap - a.radius - b.radius + tolerance;
}

void AddNearest(const Couple& couple, const Separation& separation, Manifold& manifold) {
  const Piece &a = couple.a, &b = couple.b;
  const Vec3& normal = separation.normal;
  const Vec3 on_b = separation.on_b + b.radius * normal;
  const double gap = separation.gap - a.radius - b.radius;
  // The end of a capsule that lies is beside the end of its line.
  const double beside = 1.5 * kLying * (a.radius + b.radius);
  for (Point& point : manifold.points())
    if (SquaredNorm(point.on_b - on_b) < beside * beside) {
      point = {on_b, normal, gap};
      return;
    }
  manifold.Add(on_b, normal, gap);
}

}  // namespace cdb::narrow
