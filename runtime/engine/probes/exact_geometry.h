// Exact pairs and overlaps of the bodies in their current poses, by brute force and the referee of
// library/exact, in double.
//
// Not thread-safe with respect to the engine.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "library/exact/signed_distance.h"
#include "runtime/engine/world/engine.h"

namespace cdb::probes {

/// Indices of bodies (getUserIndex), the smaller first.
using BodyPair = std::pair<std::uint32_t, std::uint32_t>;

/// All pairs of objects whose tightest boxes overlap, that may touch and are not both fixed, in
/// order.
std::vector<BodyPair> ExactPairs(const world::Engine& engine);

/// Two overlapping bodies.
struct ExactOverlap {
  BodyPair bodies;
  double depth = 0;        ///< m
  Eigen::Vector3d normal;  ///< from the second body to the first
  bool has_one_normal = true;
  double size = 0;  ///< m, of the smaller object; walls have none
};

/// In sizes. A shallower overlap is lost in rounding; no detector has to find it.
inline constexpr double kLeastOverlap = 1e-4;

struct ExactContacts {
  std::vector<ExactOverlap> overlaps;  ///< deeper than kLeastOverlap, in the order of their bodies
  /// Other pairs that may overlap as deeply, but whose distance is not known to a billionth of the
  /// size of the smaller object.
  std::size_t unsure = 0;
};

/// Of objects that may collide, and of objects and walls. `pairs`: ExactPairs.
ExactContacts ExactOverlaps(const world::Engine& engine, const std::vector<BodyPair>& pairs);

/// Errors of the narrow phase over a set of overlaps.
struct NarrowPhaseErrors {
  double missed = 0;      ///< overlaps without a contact point
  double depth_sum = 0;   ///< sum of |depth - exact| over the other overlaps, in sizes
  double normal_sum = 0;  ///< sum of the angles between normals, rad, where the normal is unique
  double normals = 0;     ///< number of angles in normal_sum
};

/// Compares each overlap with the deepest point in the manifolds, which hold the contacts of the
/// last step.
NarrowPhaseErrors CompareContacts(world::Engine& engine, const std::vector<ExactOverlap>& overlaps);

}  // namespace cdb::probes
