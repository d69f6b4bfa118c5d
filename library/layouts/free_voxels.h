// The free space for one more object, as voxels that are refined adaptively.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "library/objects/solid.h"

namespace cdb::layouts {

/// A list of voxels, equal boxes of a lattice between `low` and `high`, that together contain every
/// free position: a position drawn uniformly from a uniformly chosen voxel, and redrawn until it is
/// free, is uniform over the free space. An empty list proves that there is none. m. Not
/// thread-safe. 8 bytes per voxel. Source: G. Zhang and S. Torquato, Phys. Rev. E 88, 053312
/// (2013).
///
/// `covered(box)` returns true only if no position in the box is free.
class FreeVoxels {
 public:
  /// The voxels of edge length about `edge` that are not covered; longer ones if there would be
  /// more than `most` in the lattice. `low` < `high` on every axis.
  template <typename Covered>
  FreeVoxels(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double edge, double most,
             Covered covered)
      : low_(low) {
    const Eigen::Vector3d length = high - low;
    const auto along = [&](int axis) {
      return std::clamp(std::ceil(length[axis] / edge), 1.0, double{kMaxAlong});
    };
    // Terminates: once `edge` is the longest side, there is one voxel.
    while (along(0) * along(1) * along(2) > std::max(most, 1.0)) edge *= 1.1;
    std::array<std::uint64_t, 3> cells;
    for (int axis = 0; axis < 3; ++axis) {
      cells[axis] = static_cast<std::uint64_t>(along(axis));
      edges_[axis] = length[axis] / along(axis);
    }
    along_ = *std::ranges::max_element(cells);
    for (std::uint64_t x = 0; x < cells[0]; ++x)
      for (std::uint64_t y = 0; y < cells[1]; ++y)
        for (std::uint64_t z = 0; z < cells[2]; ++z) AddUnlessCovered({x, y, z}, covered);
  }

  std::size_t size() const { return voxels_.size(); }
  bool empty() const { return voxels_.empty(); }

  objects::Box BoxOf(std::size_t index) const {
    const std::uint64_t voxel = voxels_[index];
    return BoxAt({voxel >> (2 * kBits), (voxel >> kBits) & kMask, voxel & kMask});
  }

  /// Removes a voxel that is now covered. The last voxel takes its index.
  void Remove(std::size_t index) {
    voxels_[index] = voxels_.back();
    voxels_.pop_back();
  }

  bool CanSplit() const { return 2 * along_ <= kMaxAlong; }

  /// Halves the edges, and keeps the uncovered ones of the eight parts of each voxel.
  template <typename Covered>
  void Split(Covered covered) {
    std::vector<std::uint64_t> whole;
    whole.swap(voxels_);
    edges_ /= 2;
    along_ *= 2;
    // From the end, and with memory released on the way, as the parts need it.
    for (; !whole.empty(); whole.pop_back()) {
      if (whole.size() < whole.capacity() / 2) whole.shrink_to_fit();
      const std::uint64_t voxel = whole.back();
      const std::uint64_t x = 2 * (voxel >> (2 * kBits)), y = 2 * ((voxel >> kBits) & kMask),
                          z = 2 * (voxel & kMask);
      for (std::uint64_t part = 0; part < 8; ++part)
        AddUnlessCovered({x + (part >> 2), y + ((part >> 1) & 1), z + (part & 1)}, covered);
    }
  }

 private:
  static constexpr int kBits = 21;  ///< of one coordinate
  static constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1;
  static constexpr std::uint64_t kMaxAlong = std::uint64_t{1} << kBits;

  using Coordinates = std::array<std::uint64_t, 3>;

  objects::Box BoxAt(const Coordinates& at) const {
    objects::Box box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lower[axis] = low_[axis] + edges_[axis] * static_cast<double>(at[axis]);
      box.upper[axis] = low_[axis] + edges_[axis] * static_cast<double>(at[axis] + 1);
    }
    return box;
  }

  template <typename Covered>
  void AddUnlessCovered(const Coordinates& at, Covered& covered) {
    if (!covered(BoxAt(at))) voxels_.push_back(at[0] << (2 * kBits) | at[1] << kBits | at[2]);
  }

  Eigen::Vector3d low_, edges_;
  std::uint64_t along_;                ///< voxels along the longest edge of the lattice
  std::vector<std::uint64_t> voxels_;  ///< x, y, z from the upper bits down
};

}  // namespace cdb::layouts
