#include "library/objects/simplex.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

namespace cdb::objects {
namespace {

using Eigen::Vector3d;

/// The nearest of several parts of a simplex.
struct Best {
  Simplex part;
  Vector3d nearest = Vector3d::Zero();
  double least = -1;  ///< squared

  void TakeIfNearer(const Simplex& candidate, const Vector3d& point) {
    const double squared = point.squaredNorm();
    if (least >= 0 && !(squared < least)) return;
    least = squared;
    nearest = point;
    part = candidate;
  }
};

Vector3d NearestOnSegment(Simplex& simplex) {
  const Vector3d a = simplex.points[0], b = simplex.points[1];
  const Vector3d ab = b - a;
  const double t = -a.dot(ab);
  const double length = ab.squaredNorm();
  if (t <= 0 || length == 0) {
    simplex = {{a}, 1};
    return a;
  }
  if (t >= length) {
    simplex = {{b}, 1};
    return b;
  }
  const Vector3d point = a + ab * (t / length);
  // Repeated, to remove rounding errors along the segment: a short vector needs its direction too.
  return point - ab * (point.dot(ab) / length);
}

/// The normal of a triangle, of length twice the area. From the two shorter edges, as the longer
/// ones of a needle would cancel.
Vector3d NormalOf(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, bc = c - b, ca = a - c;
  const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
  if (ab2 >= bc2 && ab2 >= ca2) return bc.cross(ca);
  return bc2 >= ca2 ? ca.cross(ab) : ab.cross(bc);
}

Vector3d NearestOnTriangle(Simplex& simplex, double noise) {
  const Vector3d a = simplex.points[0], b = simplex.points[1], c = simplex.points[2];
  const Vector3d normal = NormalOf(a, b, c);
  const double area = normal.squaredNorm();
  const double longest =
      std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  if (area > noise * noise * longest) {
    const Vector3d point = normal * (a.dot(normal) / area);
    const Vector3d pa = a - point, pb = b - point, pc = c - point;
    if (pa.cross(pb).dot(normal) > 0 && pb.cross(pc).dot(normal) > 0 &&
        pc.cross(pa).dot(normal) > 0)
      return point;
  }
  Best best;
  for (const auto& [p, q] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
    Simplex edge{{p, q}, 2};
    const Vector3d point = NearestOnSegment(edge);
    best.TakeIfNearer(edge, point);
  }
  simplex = best.part;
  return best.nearest;
}

Vector3d NearestOnTetrahedron(Simplex& simplex, double noise) {
  // All have the same orientation, as seen from the corner that each leaves out.
  static constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  const auto points = simplex.points;
  const Vector3d& d = points[3];
  const Vector3d first = NormalOf(points[0], points[1], points[2]);
  // One sign for all faces: the individual signs of a flat tetrahedron may contradict one another.
  const double volume = first.dot(d - points[0]);
  double largest = first.squaredNorm();
  std::array<double, 4> heights;
  for (int face = 0; face < 4; ++face) {
    const Vector3d& a = points[kFaces[face][0]];
    const Vector3d normal = NormalOf(a, points[kFaces[face][1]], points[kFaces[face][2]]);
    heights[face] = a.dot(normal);
    largest = std::max(largest, normal.squaredNorm());
  }
  const bool is_flat = volume * volume <= noise * noise * largest;
  Best best;
  for (int face = 0; face < 4; ++face) {
    // The origin is on the inner side of this face.
    if (!is_flat && heights[face] * volume > 0) continue;
    Simplex triangle{{points[kFaces[face][0]], points[kFaces[face][1]], points[kFaces[face][2]]},
                     3};
    const Vector3d point = NearestOnTriangle(triangle, noise);
    best.TakeIfNearer(triangle, point);
  }
  if (best.least >= 0) simplex = best.part;
  return best.nearest;
}

}  // namespace

Vector3d ReduceToNearest(Simplex& simplex, double noise) {
  switch (simplex.size) {
    case 1:
      return simplex.points[0];
    case 2:
      return NearestOnSegment(simplex);
    case 3:
      return NearestOnTriangle(simplex, noise);
    default:
      return NearestOnTetrahedron(simplex, noise);
  }
}

}  // namespace cdb::objects
