// A hashed grid for boxes of any size and position, so that a new box is tested only with its
// neighbours.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "library/objects/solid.h"

namespace cdb::layouts {

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

}  // namespace cdb::layouts
