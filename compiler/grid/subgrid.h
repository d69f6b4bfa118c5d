// The combinations of values of some axes of a grid.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cdb::grid {

/// An index on each axis of a grid.
using Point = std::vector<std::size_t>;
/// Indices of axes, ascending.
using AxisSet = std::vector<std::size_t>;

AxisSet Union(const AxisSet& a, const AxisSet& b);
AxisSet AllAxes(std::size_t count);
/// The axes with more than one value.
AxisSet WithoutConstants(const AxisSet& axes, const Point& extents);
/// A double, because the count may exceed 64 bits.
double CountOf(const Point& extents);

/// The combinations of the values on `axes`, numbered with the last axis fastest.
class Subgrid {
 public:
  Subgrid() = default;
  /// `extents`: the number of values on each axis of the whole grid.
  Subgrid(AxisSet axes, const Point& extents);

  const AxisSet& axes() const { return axes_; }
  std::uint64_t size() const { return size_; }
  /// The number of the point's combination.
  std::uint64_t IndexOf(const Point& point) const {
    std::uint64_t index = 0;
    for (std::size_t i = 0; i < axes_.size(); ++i) index += strides_[i] * point[axes_[i]];
    return index;
  }
  /// Moves the point to the combination `index`; its indices on other axes stay.
  void MoveTo(std::uint64_t index, Point& point) const;
  /// Moves the point to the next combination; false at the end, where it wraps around.
  bool Advance(Point& point) const;

 private:
  AxisSet axes_;
  std::vector<std::uint64_t> strides_;
  Point extents_;  ///< of `axes_`
  std::uint64_t size_ = 1;
};

}  // namespace cdb::grid
