#include "library/objects/distance.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "library/objects/solid_pair.h"

namespace cdb::objects {
namespace {

using Eigen::Vector3d;

/// As a fraction of sizes and distance.
constexpr double kExact = 1e-13;

}  // namespace

double Distance(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b) {
  const SolidPair pair(a, pose_a.orientation, b, pose_b.orientation);
  const Vector3d offset = pose_b.position - pose_a.position;
  double least = std::numeric_limits<double>::infinity();
  pair.AnyPieces([&](std::size_t piece_a, std::size_t piece_b) {
    least = std::min(least, pair.PieceGap(piece_a, piece_b, offset).distance);
    return least == 0;
  });
  return least;
}

std::optional<double> Approach(const Solid& a, const Pose& pose_a, const Solid& b,
                               const Pose& pose_b, const Vector3d& direction, double distance) {
  const SolidPair pair(a, pose_a.orientation, b, pose_b.orientation);
  const double afar = a.OuterRadius() + b.OuterRadius() + distance;
  const double exact = kExact * (pair.size() + distance);
  // The distance at which some two pieces are this close; nearer ones need no test.
  std::optional<double> first;
  pair.AnyPieces([&](std::size_t piece_a, std::size_t piece_b) {
    for (double at = afar; at > first.value_or(0);) {
      const Gap gap = pair.PieceGap(piece_a, piece_b, at * direction);
      const double left = gap.distance - distance;
      if (left <= exact) {
        first = at;
        break;
      }
      const double rate = gap.direction.dot(direction);
      if (!(rate > 0)) break;
      at -= left / rate;
    }
    return false;
  });
  return first;
}

bool Overlap(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b) {
  return SolidPair(a, pose_a.orientation, b, pose_b.orientation)
      .Overlap(pose_b.position - pose_a.position);
}

namespace {

using Eigen::Matrix3d;

/// Sine of the angle up to which two directions of separation count as one.
constexpr double kSameWay = 1e-3;
/// Edges whose sine is below this are parallel, and the axes of the faces suffice. Their product
/// has lost half of its digits.
constexpr double kParallel = 1e-8;

struct WayOut {
  double depth;
  Vector3d normal;
};

bool IsSameWay(const Vector3d& a, const Vector3d& b) {
  return a.dot(b) > 0 && a.cross(b).norm() < kSameWay;
}

/// The shortest of these separations.
Penetration Shortest(const std::vector<WayOut>& ways) {
  const WayOut& best = *std::ranges::min_element(ways, {}, &WayOut::depth);
  Penetration result{best.depth, best.normal};
  for (const WayOut& way : ways)
    if (!IsSameWay(way.normal, best.normal))
      result.next_depth = std::min(result.next_depth, way.depth);
  return result;
}

Penetration OfBalls(double radius_a, const Vector3d& a, double radius_b, const Vector3d& b) {
  const Vector3d between = a - b;
  const double reach = radius_a + radius_b, distance = between.norm();
  // All directions are equally long.
  if (distance == 0) return {reach, Vector3d::UnitY(), reach};
  return {reach - distance, between / distance};
}

/// `a` is the ball: the normal points to it.
Penetration OfBallAndCuboid(double radius, const Vector3d& ball, const Solid& cuboid,
                            const Pose& pose) {
  const Matrix3d axes = pose.orientation.toRotationMatrix();
  const Vector3d half = cuboid.HalfExtents();
  const Vector3d centre = axes.transpose() * (ball - pose.position);
  const Vector3d outside = centre - centre.cwiseMax(-half).cwiseMin(half);
  const double distance = outside.norm();
  if (distance > 0) return {radius - distance, axes * outside / distance};
  std::vector<WayOut> ways;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0})
      ways.push_back({radius + half[axis] - sign * centre[axis], sign * axes.col(axis)});
  return Shortest(ways);
}

std::optional<Penetration> OfCuboids(const Solid& a, const Pose& pose_a, const Solid& b,
                                     const Pose& pose_b) {
  const Matrix3d axes_a = pose_a.orientation.toRotationMatrix();
  const Matrix3d axes_b = pose_b.orientation.toRotationMatrix();
  const Vector3d half_a = a.HalfExtents(), half_b = b.HalfExtents();
  const Vector3d between = pose_a.position - pose_b.position;
  std::vector<WayOut> ways;
  ways.reserve(30);
  const auto add = [&](const Vector3d& axis) {
    const double reach = (axes_a.transpose() * axis).cwiseAbs().dot(half_a) +
                         (axes_b.transpose() * axis).cwiseAbs().dot(half_b);
    for (const double sign : {-1.0, 1.0})
      ways.push_back({reach - sign * axis.dot(between), sign * axis});
  };
  for (int i = 0; i < 3; ++i) {
    add(axes_a.col(i));
    add(axes_b.col(i));
    for (int j = 0; j < 3; ++j) {
      const Vector3d axis = axes_a.col(i).cross(axes_b.col(j));
      if (axis.norm() > kParallel) add(axis.normalized());
    }
  }
  const Penetration result = Shortest(ways);
  return result.depth >= 0 ? std::optional(result) : std::nullopt;
}

}  // namespace

std::optional<Penetration> ExactContact(const Solid& a, const Pose& pose_a, const Solid& b,
                                        const Pose& pose_b) {
  const bool is_cuboid_a = a.shape == Shape::kCuboid, is_cuboid_b = b.shape == Shape::kCuboid;
  if (a.IsBall() && b.IsBall())
    return OfBalls(a.sides.x() / 2, pose_a.position, b.sides.x() / 2, pose_b.position);
  if (a.IsBall() && is_cuboid_b)
    return OfBallAndCuboid(a.sides.x() / 2, pose_a.position, b, pose_b);
  if (is_cuboid_a && b.IsBall()) {
    Penetration result = OfBallAndCuboid(b.sides.x() / 2, pose_b.position, a, pose_a);
    result.normal = -result.normal;
    return result;
  }
  if (is_cuboid_a && is_cuboid_b) return OfCuboids(a, pose_a, b, pose_b);
  return std::nullopt;
}

std::optional<Penetration> ExactContact(const Solid& solid, const Pose& pose,
                                        const Vector3d& normal, double offset) {
  if (solid.shape == Shape::kCompound) return std::nullopt;
  const Vector3d deepest =
      pose.position + pose.orientation * solid.Support(pose.orientation.conjugate() * -normal);
  return Penetration{offset - normal.dot(deepest), normal};
}

}  // namespace cdb::objects
