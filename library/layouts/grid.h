// A grid over the cube that lists the boxes in each cell, so that a new box is tested only with its
// neighbours.
#pragma once

#include <cstdint>
#include <vector>

#include "library/objects/solid.h"

namespace cdb::layouts {

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
