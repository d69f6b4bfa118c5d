// Checks that objects placed by a layout neither overlap nor leave the cube.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "library/layouts/bodies.h"
#include "library/objects/solid.h"

namespace cdb::layouts {

/// `indices`: the objects to check. Movable objects must neither reach through a wall of the cube,
/// whichever walls are in use, nor into another object; they may touch both, within a few roundings
/// of their coordinates. Fixed objects may leave the cube and overlap one another, and objects of
/// groups with `overlap` on may overlap each other. Throws SceneError, which names the later
/// object, the other object or the wall, the depth, and a remedy. O(n) if sizes and shapes are
/// similar.
void CheckClearance(const Bodies& bodies, const std::vector<std::uint32_t>& indices);

// A hashed grid for boxes of any size and position, so that a new box is tested only with its
// neighbours.

/// A box is stored in one cell, that of its centre, of a lattice with cells as long as the box or
/// up to twice as long; cells are found by a hash, so that neither extent nor clustering matters.
/// Boxes must be added from large to small; a query then visits up to 27 cells on each level. Not
/// thread-safe.
class HashGrid {
 public:
  explicit HashGrid(std::size_t boxes);

  /// The level of the lattice for boxes with this largest extent, > 0; higher for larger ones.
  static int LevelOf(double extent) { return std::ilogb(extent) + 1; }

  /// `level`: that of the box, not higher than the previous one.
  void Add(std::uint32_t id, int level, const objects::Box& box);

  /// Calls `meets(id)` for each box that touches `box`, and for some others, possibly repeatedly,
  /// until a call returns true; returns whether one did.
  template <typename Meets>
  bool AnyOf(const objects::Box& box, Meets meets) const {
    for (const int level : levels_) {
      const double edge = std::ldexp(1.0, level);
      std::array<std::int64_t, 3> first, last;
      for (int axis = 0; axis < 3; ++axis) {
        first[axis] = Cell(box.lower[axis] / edge - kReach);
        last[axis] = Cell(box.upper[axis] / edge + kReach);
      }
      for (std::int64_t z = first[2]; z <= last[2]; ++z)
        for (std::int64_t y = first[1]; y <= last[1]; ++y)
          for (std::int64_t x = first[0]; x <= last[0]; ++x)
            for (std::uint32_t at = heads_[Bucket(level, x, y, z)]; at != kNone;
                 at = entries_[at].next)
              if (meets(entries_[at].id)) return true;
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  /// Reach of boxes beyond their centres, in cells, with a tolerance for rounding.
  static constexpr double kReach = 0.5 + 1e-6;
  struct Entry {
    std::uint32_t id, next;
  };

  static std::int64_t Cell(double coordinate);
  std::size_t Bucket(int level, std::int64_t x, std::int64_t y, std::int64_t z) const;

  std::vector<int> levels_;  ///< of the boxes added so far
  std::vector<std::uint32_t> heads_;
  std::vector<Entry> entries_;
};

// The free space for one more object, as voxels that are refined adaptively.

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

// A grid over the cube that lists the boxes in each cell, so that a new box is tested only with its
// neighbours.

/// A box is stored in every cell that it overlaps, by value: in single precision and slightly
/// enlarged, so that two entries share a cache line. Not thread-safe.
class BoxGrid {
 public:
  /// `extents`: the largest extent of each box to be added, which determines the cell size. m.
  BoxGrid(double side, const std::vector<double>& extents);

  void Add(std::uint32_t id, const objects::Box& box);

  /// Calls `meets(id)` for the boxes that overlap or touch `box` or miss it by less than 1e-6 of
  /// the side, possibly repeatedly, until a call returns true; returns whether one did. `box` may
  /// leave the cube by half its side, added boxes by any length.
  template <typename Meets>
  bool AnyOf(const objects::Box& box, Meets meets) const {
    const Bounds32 query = Outwards(box);
    return AnyCell(box, [&](std::size_t cell) {
      for (std::uint32_t at = heads_[cell]; at != kNone; at = entries_[at].next) {
        const Entry& entry = entries_[at];
        if (Touch(entry.bounds, query) && meets(entry.id)) return true;
      }
      return false;
    });
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  struct Bounds32 {
    float lower[3], upper[3];
  };
  struct alignas(32) Entry {
    Bounds32 bounds;
    std::uint32_t id, next;
  };

  /// In units of the side, which never overflow, and enlarged by more than the loss by rounding.
  Bounds32 Outwards(const objects::Box& box) const;
  static bool Touch(const Bounds32& a, const Bounds32& b) {
    // Without branches, as the deciding axis is unpredictable.
    bool touch = true;
    for (int axis = 0; axis < 3; ++axis)
      touch &= (a.lower[axis] <= b.upper[axis]) & (a.upper[axis] >= b.lower[axis]);
    return touch;
  }
  std::size_t Cell(double coordinate) const;
  template <typename Visit>
  bool AnyCell(const objects::Box& box, Visit visit) const {
    std::size_t first[3], last[3];
    for (int axis = 0; axis < 3; ++axis) {
      first[axis] = Cell(box.lower[axis]);
      last[axis] = Cell(box.upper[axis]);
    }
    for (std::size_t x = first[0]; x <= last[0]; ++x)
      for (std::size_t y = first[1]; y <= last[1]; ++y)
        for (std::size_t z = first[2]; z <= last[2]; ++z)
          if (visit((x * cells_ + y) * cells_ + z)) return true;
    return false;
  }

  double side_;
  std::size_t cells_ = 1;  ///< along an edge
  double cells_per_metre_;
  std::vector<std::uint32_t> heads_;
  std::vector<Entry> entries_;
};

}  // namespace cdb::layouts
