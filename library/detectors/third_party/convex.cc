#include "library/detectors/third_party/convex.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "library/objects/shapes/super_norm.h"

namespace cdb::third_party {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The farthest point of the ellipse in the plane of x and z.
Vector3d OnEllipse(const Vec3& half, const Vector3d& direction) {
  const double x = half.x * direction.x(), z = half.z * direction.z();
  const double length = std::hypot(x, z);
  if (length == 0) return {half.x, 0, 0};
  return {half.x * x / length, 0, half.z * z / length};
}

Vector3d OnEllipsoid(const Vector3d& half, const Vector3d& direction) {
  const Vector3d scaled = half.cwiseProduct(direction);
  const double length = scaled.stableNorm();
  if (length == 0) return {half.x(), 0, 0};
  return half.cwiseProduct(scaled) / length;
}

/// The feature of a piece that faces a direction, seen along it: the corners of a polygon in order,
/// all of which may be on one line or at one point. They are the farthest points in directions
/// tilted a little to each side.
constexpr int kCorners = 8;
constexpr double kTilt = 1e-3;  // rad: a face so little askew counts as facing
using Outline = std::array<Vector2d, kCorners>;

Outline OutlineOf(const PlacedPiece& piece, const Vector3d& towards, const Vector3d& u,
                  const Vector3d& v) {
  Outline outline;
  for (int i = 0; i < kCorners; ++i) {
    // Off the axes, so that a face of a box is not ambiguous.
    const double angle = (i + 0.3) * 2 * std::numbers::pi / kCorners;
    const Vector3d point =
        piece.Support(towards + kTilt * (std::cos(angle) * u + std::sin(angle) * v));
    outline[i] = {point.dot(u), point.dot(v)};
  }
  return outline;
}

/// The nearest point of the polygon.
Vector2d Nearest(const Outline& outline, const Vector2d& point) {
  Vector2d best = outline[0];
  double least = std::numeric_limits<double>::infinity();
  bool is_inside = true, has_side = false;
  for (int i = 0; i < kCorners; ++i) {
    const Vector2d from = outline[i], side = outline[(i + 1) % kCorners] - from;
    const Vector2d to = point - from;
    const double square = side.squaredNorm();
    if (square > 0) {  // several directions may share one corner
      has_side = true;
      is_inside = is_inside && side.x() * to.y() - side.y() * to.x() > 0;
    }
    const double along = square > 0 ? std::clamp(to.dot(side) / square, 0.0, 1.0) : 0;
    const Vector2d candidate = from + along * side;
    const double distance = (candidate - point).squaredNorm();
    if (distance < least) {
      least = distance;
      best = candidate;
    }
  }
  return has_side && is_inside ? point : best;
}

}  // namespace

Eigen::Matrix3d AxesOf(const Pose& pose) {
  Eigen::Matrix3d axes;
  axes << ToEigen(pose.x), ToEigen(pose.y), ToEigen(pose.z);
  return axes;
}

std::size_t PieceCount(const Shape& shape) {
  return shape.kind == ShapeKind::kCompound ? shape.hulls.size() : 1;
}

double StraightHalf(const Shape& shape) {
  return std::max(0.0, shape.half.y - std::sqrt(shape.half.x * shape.half.z));
}

Vector3d PieceSupport(const Shape& shape, std::size_t piece, const Vector3d& direction) {
  const Vec3& half = shape.half;
  switch (shape.kind) {
    case ShapeKind::kEllipsoid:
      return OnEllipsoid(ToEigen(half), direction);
    case ShapeKind::kBox:
      return {std::copysign(half.x, direction.x()), std::copysign(half.y, direction.y()),
              std::copysign(half.z, direction.z())};
    case ShapeKind::kCylinder: {
      Vector3d point = OnEllipse(half, direction);
      point.y() = std::copysign(half.y, direction.y());
      return point;
    }
    case ShapeKind::kCone: {
      const Vector3d tip(0, shape.centre.y + half.y, 0);
      Vector3d rim = OnEllipse(half, direction);
      rim.y() = shape.centre.y - half.y;
      return direction.dot(tip) > direction.dot(rim) ? tip : rim;
    }
    case ShapeKind::kCapsule: {
      const double straight = StraightHalf(shape);
      return OnEllipsoid({half.x, half.y - straight, half.z}, direction) +
             Vector3d(0, std::copysign(straight, direction.y()), 0);
    }
    case ShapeKind::kHull:
    case ShapeKind::kCompound: {
      Vector3d best = Vector3d::Zero();
      double most = -std::numeric_limits<double>::infinity();
      for (const Vec3& vertex : shape.hulls[piece].vertices) {
        const double along = direction.dot(ToEigen(vertex));
        if (along > most) {
          most = along;
          best = ToEigen(vertex);
        }
      }
      return best;
    }
    case ShapeKind::kSuperellipsoid: {
      const auto [x, y, z] =
          shapes::FarthestOfSuperNorm(half.x * direction.x(), half.y * direction.y(),
                                      half.z * direction.z(), shape.e1, shape.e2);
      return {half.x * x, half.y * y, half.z * z};
    }
    case ShapeKind::kPlane:
    case ShapeKind::kSurface:
      break;
  }
  return Vector3d::Zero();
}

Vector3d PieceCentre(const Shape& shape, std::size_t piece) {
  if (shape.hulls.empty()) return Vector3d::Zero();  // the centre of mass
  Vector3d sum = Vector3d::Zero();
  for (const Vec3& vertex : shape.hulls[piece].vertices) sum += ToEigen(vertex);
  return sum / static_cast<double>(shape.hulls[piece].vertices.size());
}

PlacedPiece::PlacedPiece(const Scene& scene, Id body, std::size_t of)
    : shape(&scene.shapes[body]),
      piece(of),
      at(ToEigen(scene.poses[body].position)),
      axes(AxesOf(scene.poses[body])) {}

Vector3d MeetingPoint(const PlacedPiece& a, const PlacedPiece& b, const Vector3d& normal) {
  const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  const Outline of_a = OutlineOf(a, -normal, u, v), of_b = OutlineOf(b, normal, u, v);
  // Alternating projections from the middle of one: to the common part, or to the nearest points.
  Vector2d point = Vector2d::Zero();
  for (const Vector2d& corner : of_a) point += corner / kCorners;
  constexpr int kRounds = 8;
  for (int round = 0; round < kRounds; ++round) {
    const Vector2d next = Nearest(of_a, Nearest(of_b, point));
    if (next == point) break;
    point = next;
  }
  const double height = (a.Support(-normal).dot(normal) + b.Support(normal).dot(normal)) / 2;
  return point.x() * u + point.y() * v + height * normal;
}

}  // namespace cdb::third_party
