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

double HeightSurface::ReachOf(std::size_t block, const Vector3d& along) const {
  const auto reach_in = [](double by, Range range, std::size_t points) {
    return by * (static_cast<double>(by > 0 ? range.end - 1 : range.first) / Cells(points) - 0.5);
  };
  const double height = along.y() > 0 ? blocks_[block].high : blocks_[block].low;
  return reach_in(along.x(), ColumnsOf(block), grid_->columns) + along.y() * height +
         reach_in(along.z(), RowsOf(block), grid_->rows) + 1e-12 * along.lpNorm<1>();
}

template <typename Visit>
void HeightSurface::ForPointsOf(std::size_t block, Visit visit) const {
  const Range columns = ColumnsOf(block), rows = RowsOf(block);
  for (std::size_t row = rows.first; row < rows.end; ++row)
    for (std::size_t column = columns.first; column < columns.end; ++column)
      visit(Point(column, row));
}

Vector3d HeightSurface::Support(const Vector3d& along) const {
  std::vector<double> reach(blocks_.size());
  for (std::size_t block = 0; block < reach.size(); ++block) reach[block] = ReachOf(block, along);
  // The block that may reach farthest tells which others need no look at their points.
  double enough = -std::numeric_limits<double>::infinity();
  ForPointsOf(static_cast<std::size_t>(std::ranges::max_element(reach) - reach.begin()),
              [&](const Vector3d& point) { enough = std::max(enough, along.dot(point)); });
  Vector3d farthest = Point(0, 0);
  double most = along.dot(farthest);
  for (std::size_t block = 0; block < reach.size(); ++block)
    if (reach[block] >= std::max(enough, most))
      ForPointsOf(block, [&](const Vector3d& point) {
        if (along.dot(point) <= most) return;
        most = along.dot(point);
        farthest = point;
      });
  return farthest;
}

double HeightSurface::OuterRadius(const Vector3d& sides) const {
  constexpr double kRounding = 1 + 1e-12;
  double most = 0;
  // From the corners on, which are often the farthest.
  for (const std::size_t row : {std::size_t{0}, grid_->rows - 1})
    for (const std::size_t column : {std::size_t{0}, grid_->columns - 1})
      most = std::max(most, Point(column, row).cwiseProduct(sides).squaredNorm());
  for (std::size_t block = 0; block < blocks_.size(); ++block) {
    // The farthest corner of the block's box.
    double reach = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d along = Vector3d::Unit(axis);
      const double side = std::max(ReachOf(block, along), ReachOf(block, -along)) * sides[axis];
      reach += side * side;
    }
    if (reach * kRounding >= most)
      ForPointsOf(block, [&](const Vector3d& point) {
        most = std::max(most, point.cwiseProduct(sides).squaredNorm());
      });
  }
  return std::sqrt(most);
}

}  // namespace cdb::objects
