#include "compiler/grid/subgrid.h"

#include <algorithm>
#include <iterator>
#include <numeric>

namespace cdb::grid {

AxisSet Union(const AxisSet& a, const AxisSet& b) {
  AxisSet both;
  std::ranges::set_union(a, b, std::back_inserter(both));
  return both;
}

AxisSet AllAxes(std::size_t count) {
  AxisSet all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

AxisSet WithoutConstants(const AxisSet& axes, const Point& extents) {
  AxisSet varying;
  for (const std::size_t axis : axes)
    if (extents[axis] > 1) varying.push_back(axis);
  return varying;
}

double CountOf(const Point& extents) {
  double count = 1;
  for (const std::size_t extent : extents) count *= static_cast<double>(extent);
  return count;
}

Subgrid::Subgrid(AxisSet axes, const Point& extents)
    : axes_(WithoutConstants(axes, extents)), strides_(axes_.size()) {
  for (const std::size_t axis : axes_) extents_.push_back(extents[axis]);
  for (std::size_t i = axes_.size(); i-- > 0;) {
    strides_[i] = size_;
    size_ *= extents_[i];
  }
}

void Subgrid::MoveTo(std::uint64_t index, Point& point) const {
  for (std::size_t i = 0; i < axes_.size(); ++i)
    point[axes_[i]] = static_cast<std::size_t>(index / strides_[i] % extents_[i]);
}

bool Subgrid::Advance(Point& point) const {
  for (std::size_t i = axes_.size(); i-- > 0;) {
    if (++point[axes_[i]] < extents_[i]) return true;
    point[axes_[i]] = 0;
  }
  return false;
}

}  // namespace cdb::grid
