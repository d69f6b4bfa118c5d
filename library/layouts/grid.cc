#include "library/layouts/grid.h"

#include <algorithm>
#include <cmath>

namespace cdb::layouts {
namespace {

/// The maximum number of entries per box. Compact boxes that fit into the cube stay below it with
/// one cell per box; long thin oblique ones need larger cells.
constexpr double kMaxEntriesPerBox = 32;
constexpr double kMaxCellsAlongEdge = 1024;

}  // namespace

BoxGrid::BoxGrid(double side, const std::vector<double>& extents) : side_(side) {
  const double count = static_cast<double>(extents.size());
  double cells = std::clamp(std::floor(std::cbrt(count)), 1.0, kMaxCellsAlongEdge);
  double entries = count;
  for (; cells > 1; cells = std::floor(cells / 2)) {
    entries = 0;
    for (const double extent : extents) {
      const double along = std::min(extent * cells / side + 1, cells);
      entries += along * along * along;
    }
    if (entries <= kMaxEntriesPerBox * count) break;
  }
  if (cells <= 1) entries = count;
  cells_ = static_cast<std::size_t>(cells);
  cells_per_metre_ = cells / side;
  heads_.assign(cells_ * cells_ * cells_, kNone);
  // The number for cubes of these extents: growing the vector would copy the entries repeatedly.
  entries_.reserve(static_cast<std::size_t>(entries));
}

BoxGrid::Bounds32 BoxGrid::Outwards(const objects::Box& box) const {
  // Coordinates are at most 1 here, so rounding twice loses up to 2^-24. Larger ones are outside
  // the cube, and so outside any query.
  constexpr float kLarger = 0x1p-23F;
  const auto in_sides = [&](double x) {
    return static_cast<float>(std::clamp(x / side_, -1., 1.));
  };
  Bounds32 bounds;
  for (int axis = 0; axis < 3; ++axis) {
    bounds.lower[axis] = in_sides(box.lower[axis]) - kLarger;
    bounds.upper[axis] = in_sides(box.upper[axis]) + kLarger;
  }
  return bounds;
}

std::size_t BoxGrid::Cell(double coordinate) const {
  const double cell = (coordinate + side_ / 2) * cells_per_metre_;
  if (!(cell > 0)) return 0;
  return std::min(static_cast<std::size_t>(cell), cells_ - 1);
}

void BoxGrid::Add(std::uint32_t id, const objects::Box& box) {
  const Bounds32 bounds = Outwards(box);
  AnyCell(box, [&](std::size_t cell) {
    entries_.push_back({bounds, id, heads_[cell]});
    heads_[cell] = static_cast<std::uint32_t>(entries_.size() - 1);
    return false;
  });
}

}  // namespace cdb::layouts
