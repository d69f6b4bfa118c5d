// Finds voxels that are certainly occupied.
#pragma once

#include <cstdint>

#include "library/layouts/bodies.h"
#include "library/layouts/grid.h"

namespace cdb::layouts {

/// The object for which voxels are tested: a solid that is contained in every object still to be
/// placed, at its centre of mass. A position that is not free for the probe is free for none of
/// them.
struct Probe {
  objects::Solid solid;
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  objects::Box bounds;          ///< with its centre of mass at the origin
  double inner = 0, outer = 0;  ///< radii, m

  Probe(objects::Solid its_solid, const Eigen::Quaterniond& its_orientation);
};

/// `bodies`, and the grid, which lists the placed ones, must outlive it. Not thread-safe.
class Coverage {
 public:
  Coverage(const Bodies& bodies, const BoxGrid& grid) : bodies_(bodies), grid_(grid) {}

  /// Whether the probe touches object `other` at every position in the voxel.
  bool Covers(std::uint32_t other, const Probe& probe, const objects::Box& voxel) const;
  /// Whether the probe is known to touch an object at every position in the voxel.
  bool IsCovered(const Probe& probe, const objects::Box& voxel) const;

 private:
  bool IsCoveredBySlabs(const Probe& probe, const objects::Box& voxel) const;

  const Bodies& bodies_;
  const BoxGrid& grid_;
};

}  // namespace cdb::layouts
