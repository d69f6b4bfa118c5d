#include "library/objects/overlap.h"

#include <array>

namespace cdb::library {
namespace {

using Eigen::Vector3d;

/// Up to four points of the Minkowski difference, and the point of their hull nearest the origin.
struct Simplex {
  std::array<Vector3d, 4> points;
  int size = 0;
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
  return a + ab * (t / length);
}

// Voronoi regions of a triangle (C. Ericson, Real-Time Collision Detection, 5.1.5).
Vector3d NearestOnTriangle(Simplex& simplex) {
  const Vector3d a = simplex.points[0], b = simplex.points[1], c = simplex.points[2];
  const Vector3d ab = b - a, ac = c - a;
  const double d1 = -ab.dot(a), d2 = -ac.dot(a);
  const double d3 = -ab.dot(b), d4 = -ac.dot(b);
  const double d5 = -ab.dot(c), d6 = -ac.dot(c);
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  const double sum = va + vb + vc;
  if (va > 0 && vb > 0 && vc > 0 && sum > 0) return a + ab * (vb / sum) + ac * (vc / sum);
  // On an edge: the nearest of the three, which also holds where the triangle has no area.
  Simplex best;
  Vector3d nearest = Vector3d::Zero();
  double least = -1;
  for (const auto& [p, q] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
    Simplex edge{{p, q}, 2};
    const Vector3d point = NearestOnSegment(edge);
    if (least < 0 || point.squaredNorm() < least) {
      least = point.squaredNorm();
      nearest = point;
      best = edge;
    }
  }
  simplex = best;
  return nearest;
}

/// Zero where the origin is inside.
Vector3d NearestOnTetrahedron(Simplex& simplex) {
  static constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
  const auto points = simplex.points;
  Simplex best;
  Vector3d nearest = Vector3d::Zero();
  double least = -1;
  for (const auto& face : kFaces) {
    const Vector3d& a = points[face[0]];
    const Vector3d normal = (points[face[1]] - a).cross(points[face[2]] - a);
    const double inside = normal.dot(points[face[3]] - a);
    const double origin = -normal.dot(a);
    if (inside * origin > 0) continue;  // the origin is on the inner side of this face
    Simplex triangle{{a, points[face[1]], points[face[2]]}, 3};
    const Vector3d point = NearestOnTriangle(triangle);
    if (least < 0 || point.squaredNorm() < least) {
      least = point.squaredNorm();
      nearest = point;
      best = triangle;
    }
  }
  if (least >= 0) simplex = best;
  return nearest;
}

Vector3d Nearest(Simplex& simplex) {
  switch (simplex.size) {
    case 1:
      return simplex.points[0];
    case 2:
      return NearestOnSegment(simplex);
    case 3:
      return NearestOnTriangle(simplex);
    default:
      return NearestOnTetrahedron(simplex);
  }
}

}  // namespace

bool Overlap(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b) {
  const Vector3d offset = pose_b.position - pose_a.position;
  if (a.IsBall() && b.IsBall()) {
    const double reach = (a.sides.x() + b.sides.x()) / 2;
    return offset.squaredNorm() <= reach * reach;
  }
  const Eigen::Matrix3d turn_a = pose_a.orientation.toRotationMatrix();
  const Eigen::Matrix3d turn_b = pose_b.orientation.toRotationMatrix();
  // Farthest point of b - a along `direction`.
  const auto support = [&](const Vector3d& direction) -> Vector3d {
    return offset + turn_b * b.Support(turn_b.transpose() * direction) -
           turn_a * a.Support(-(turn_a.transpose() * direction));
  };
  // A gap below this is rounding's.
  const double size = a.sides.norm() + b.sides.norm();
  const double noise = 1e-14 * (size + offset.norm());
  Simplex simplex;
  simplex.points[simplex.size++] = support(-offset);
  constexpr int kMaxSteps = 256;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Vector3d nearest = Nearest(simplex);
    const double distance = nearest.norm();
    if (distance <= noise || simplex.size == 4) return true;
    const Vector3d point = support(-nearest);
    // Every point of b - a has a positive component along `nearest`: a plane between them.
    if (nearest.dot(point) > noise * distance) return false;
    for (int i = 0; i < simplex.size; ++i)
      if (simplex.points[i] == point) return true;  // no progress, and no gap seen
    simplex.points[simplex.size++] = point;
  }
  return true;
}

}  // namespace cdb::library
