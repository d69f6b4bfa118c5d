// Exact pairs and overlaps of the bodies in their current poses, by brute force and closed forms,
// in double.
//
// Threads: none but the engine's.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "library/objects/penetration.h"
#include "runtime/engine/world/engine.h"

namespace cdb::probes {

/// Bodies by getUserIndex, the smaller first.
using BodyPair = std::pair<std::uint32_t, std::uint32_t>;

/// Pairs of objects that may touch, not both fixed, whose tightest boxes overlap: all of them, in
/// order.
std::vector<BodyPair> ExactPairs(const world::Engine& engine);

/// Two bodies in each other.
struct ExactOverlap {
  BodyPair bodies;
  objects::Penetration contact;  ///< its normal from the second body to the first
  double size;                   ///< m: of the smaller object; a wall has none
};

/// An overlap less deep than this in sizes is lost in rounding: no detector has to find it.
inline constexpr double kLeastOverlap = 1e-4;

/// Overlaps of objects that may collide, and of objects with walls, for which there is a closed
/// form: deeper than kLeastOverlap, in the order of their bodies. `pairs`: ExactPairs.
std::vector<ExactOverlap> ExactOverlaps(const world::Engine& engine,
                                        const std::vector<BodyPair>& pairs);

/// What the narrow phase made of overlaps.
struct NarrowPhaseErrors {
  double missed = 0;      ///< have no contact point
  double depth_sum = 0;   ///< of the others' |depth - exact|, in sizes
  double normal_sum = 0;  ///< of the angles between normals, rad, where there is only one
  double normals = 0;     ///< how many those are
};

/// Of each overlap the deepest point in the manifolds, which hold what the last step found.
NarrowPhaseErrors CompareContacts(world::Engine& engine, const std::vector<ExactOverlap>& overlaps);

}  // namespace cdb::probes
