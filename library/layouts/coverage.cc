#include "library/layouts/coverage.h"

#include <algorithm>
#include <array>
#include <utility>

#include "library/objects/solid_pair.h"

namespace cdb::layouts {
namespace {

using Eigen::Vector3d;

bool IsUnturnedCuboid(const objects::Solid& solid, const Eigen::Quaterniond& orientation) {
  return solid.shape == objects::Shape::kCuboid &&
         orientation.coeffs() == Eigen::Quaterniond::Identity().coeffs();
}

}  // namespace

Probe::Probe(objects::Solid its_solid, const Eigen::Quaterniond& its_orientation)
    : solid(std::move(its_solid)),
      orientation(its_orientation),
      bounds(objects::Bounds(solid, orientation)),
      inner(solid.InnerRadius()),
      outer(solid.OuterRadius()) {}

bool Coverage::Covers(std::uint32_t other, const Probe& probe, const objects::Box& voxel) const {
  // A surface is too thin to cover a position.
  if (bodies_.object(other).solid.IsSurface()) return false;
  const Core& theirs = bodies_.core(other);
  const Vector3d to_lower = (theirs.position - voxel.lower).cwiseAbs();
  const Vector3d to_upper = (theirs.position - voxel.upper).cwiseAbs();
  const double farthest = to_lower.cwiseMax(to_upper).squaredNorm();
  const double inner = probe.inner + theirs.inner;
  if (farthest < inner * inner * (1 - kRounding) && probe.inner > 0 && theirs.inner > 0)
    return true;
  const double outer = probe.outer + theirs.outer;
  if (farthest > outer * outer * (1 + kRounding)) return false;
  std::array<Vector3d, 8> offsets;  // from the probe in each corner of the voxel
  for (int corner = 0; corner < 8; ++corner)
    for (int axis = 0; axis < 3; ++axis)
      offsets[corner][axis] = theirs.position[axis] -
                              ((corner >> axis & 1) != 0 ? voxel.upper[axis] : voxel.lower[axis]);
  const ObjectState& neighbour = bodies_.object(other);
  const objects::SolidPair pair(probe.solid, probe.orientation, neighbour.solid,
                                neighbour.pose.orientation);
  // The positions at which two convex pieces touch form a convex set, so the corners decide.
  return pair.AnyPieces([&](std::size_t piece, std::size_t their_piece) {
    return std::ranges::all_of(offsets, [&](const Vector3d& offset) {
      return pair.PiecesOverlap(piece, their_piece, offset);
    });
  });
}

bool Coverage::IsCovered(const Probe& probe, const objects::Box& voxel) const {
  // An object that covers the voxel also covers its centre.
  const objects::Box box = Shifted(probe.bounds, (voxel.lower + voxel.upper) / 2);
  if (grid_.AnyOf(box, [&](std::uint32_t other) { return Covers(other, probe, voxel); }))
    return true;
  return IsUnturnedCuboid(probe.solid, probe.orientation) && IsCoveredBySlabs(probe, voxel);
}

/// Whether unrotated cuboids together cover the voxel, cut off slice by slice. Two of them with
/// slightly too little space for the probe between their faces cover many voxels together but none
/// alone, until the voxels are as thin as the missing space.
bool Coverage::IsCoveredBySlabs(const Probe& probe, const objects::Box& voxel) const {
  objects::Box left = voxel;
  const objects::Box reach{voxel.lower + probe.bounds.lower, voxel.upper + probe.bounds.upper};
  const auto cut = [&](std::uint32_t other) {
    const ObjectState& neighbour = bodies_.object(other);
    if (!IsUnturnedCuboid(neighbour.solid, neighbour.pose.orientation)) return false;
    const objects::Box theirs = bodies_.BoxOf(other);
    const Vector3d lower = theirs.lower - probe.bounds.upper;
    const Vector3d upper = theirs.upper - probe.bounds.lower;
    const auto spans = [&](int axis) {
      return lower[axis] <= left.lower[axis] && upper[axis] >= left.upper[axis];
    };
    for (int axis = 0; axis < 3; ++axis) {
      if (!spans((axis + 1) % 3) || !spans((axis + 2) % 3)) continue;
      if (spans(axis)) return true;
      if (lower[axis] <= left.lower[axis])
        left.lower[axis] = std::max(left.lower[axis], upper[axis]);
      if (upper[axis] >= left.upper[axis])
        left.upper[axis] = std::min(left.upper[axis], lower[axis]);
    }
    return false;
  };
  // After a cut, a cuboid may span the rest that did not before.
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round)
    if (grid_.AnyOf(reach, cut)) return true;
  return false;
}

}  // namespace cdb::layouts
