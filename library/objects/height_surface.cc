#include "library/objects/height_surface.h"

#include <limits>
#include <utility>

namespace cdb::objects {

using Eigen::Vector3d;

HeightSurface::HeightSurface(std::shared_ptr<const terrain::HeightGrid> grid)
    : grid_(std::move(grid)) {
  const auto [low, high] = std::ranges::minmax(grid_->heights);
  lowest_ = low;
  highest_ = high;
  const Vector3d& scale = grid_->scale;
  box_ = {Vector3d(0, scale.y() * low, 0),
          Vector3d(scale.x() * Cells(grid_->columns), scale.y() * high,
                   scale.z() * Cells(grid_->rows))};
  middle_ = box_.center();
  sides_ = box_.sizes();
  if (!(sides_.y() > 0)) sides_.y() = sides_.maxCoeff();
  width_in_blocks_ = (grid_->columns - 2) / kBlock + 1;
  blocks_.resize(width_in_blocks_ * ((grid_->rows - 2) / kBlock + 1));
  for (std::size_t block = 0; block < blocks_.size(); ++block) {
    Extent& extent = blocks_[block];
    extent = {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    const Range columns = ColumnsOf(block), rows = RowsOf(block);
    for (std::size_t row = rows.first; row < rows.end; ++row)
      for (std::size_t column = columns.first; column < columns.end; ++column) {
        const double height = HeightAt(row * grid_->columns + column);
        extent = {std::min(extent.low, height), std::max(extent.high, height)};
      }
  }
}

HeightSurface::Range HeightSurface::ColumnsOf(std::size_t block) const {
  const std::size_t first = block % width_in_blocks_ * kBlock;
  return {first, std::min(first + kBlock + 1, grid_->columns)};
}

HeightSurface::Range HeightSurface::RowsOf(std::size_t block) const {
  const std::size_t first = block / width_in_blocks_ * kBlock;
  return {first, std::min(first + kBlock + 1, grid_->rows)};
}

Vector3d HeightSurface::Support(const Vector3d& along) const {
  const double rounding = 1e-12 * along.lpNorm<1>();
  Vector3d farthest = Point(0, 0);
  double most = along.dot(farthest);
  for (std::size_t block = 0; block < blocks_.size(); ++block) {
    const Range columns = ColumnsOf(block), rows = RowsOf(block);
    // Most blocks are skipped without looking at their points, as not even their boxes reach so
    // far.
    const auto reach_in = [&](double by, Range range, std::size_t points) {
      return by * (static_cast<double>(by > 0 ? range.end - 1 : range.first) / Cells(points) - 0.5);
    };
    const double height = along.y() > 0 ? blocks_[block].high : blocks_[block].low;
    if (reach_in(along.x(), columns, grid_->columns) + along.y() * height +
            reach_in(along.z(), rows, grid_->rows) + rounding <
        most)
      continue;
    for (std::size_t row = rows.first; row < rows.end; ++row)
      for (std::size_t column = columns.first; column < columns.end; ++column) {
        const Vector3d point = Point(column, row);
        if (along.dot(point) <= most) continue;
        most = along.dot(point);
        farthest = point;
      }
  }
  return farthest;
}

double HeightSurface::OuterRadius(const Vector3d& sides) const {
  double most = 0;
  for (std::size_t row = 0; row < grid_->rows; ++row)
    for (std::size_t column = 0; column < grid_->columns; ++column)
      most = std::max(most, Point(column, row).cwiseProduct(sides).squaredNorm());
  return std::sqrt(most);
}

}  // namespace cdb::objects
