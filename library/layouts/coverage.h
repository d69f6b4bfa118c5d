// Finds voxels that are certainly occupied.
#pragma once

#include <cstdint>

#include "library/layouts/bodies.h"
#include "library/layouts/grid.h"

namespace cdb::layouts {

/// What the voxels of a list are free for: a solid that every object to come has inside it, at its
/// centre of mass. What is not free for the probe is free for none of them.
struct Probe {
  objects::Solid solid;
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  objects::Box bounds;          ///< its centre of mass at the origin
  double inner = 0, outer = 0;  ///< radii, m

  Probe(objects::Solid its_solid, const Eigen::Quaterniond& its_orientation);
};

/// Bodies and grid, which lists those that have their place, must outlive it. Not for several
/// threads.
class Coverage {
 public:
  Coverage(const Bodies& bodies, const BoxGrid& grid) : bodies_(bodies), grid_(grid) {}

  /// Whether the probe touches object `other` wherever in the voxel it is.
  bool Covers(std::uint32_t other, const Probe& probe, const objects::Box& voxel) const;
  /// Whether the probe is known to touch something wherever in the voxel it is.
  bool IsCovered(const Probe& probe, const objects::Box& voxel) const;

 private:
  bool IsCoveredBySlabs(const Probe& probe, const objects::Box& voxel) const;

  const Bodies& bodies_;
  const BoxGrid& grid_;
};

}  // namespace cdb::layouts
