#include "library/objects/distance.h"

#include <algorithm>
#include <limits>

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
  return pair.IsInCells(offset) ? 0 : least;
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

}  // namespace cdb::objects
