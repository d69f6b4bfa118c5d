// The triangles of a height field, computed from its heights when they are asked for.
//
// In the frame of a form: scaled so that the box is the cube of side 1 about the origin. Cell
// (column, row) has the triangles 2 i and 2 i + 1, i = row (columns - 1) + column,
// counter-clockwise from above, divided by the diagonal from its corner at +z to that at +x: those
// of a btHeightfieldTerrainShape. Besides the heights, it stores the box of each block of cells.
// Threads: any.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "library/terrain/height_grid.h"

namespace cdb::objects {

class HeightSurface {
 public:
  explicit HeightSurface(std::shared_ptr<const terrain::HeightGrid> grid);

  const terrain::HeightGrid& grid() const { return *grid_; }
  std::size_t TriangleCount() const { return 2 * grid_->cells(); }
  /// Of the field at its own scale, m, with its first height at x = z = 0.
  const Eigen::AlignedBox3d& box() const { return box_; }
  /// In the file's unit.
  double lowest() const { return lowest_; }
  double highest() const { return highest_; }

  Eigen::Vector3d Point(std::size_t column, std::size_t row) const {
    const Eigen::Vector3d& scale = grid_->scale;
    return {(scale.x() * static_cast<double>(column) - middle_.x()) / sides_.x(),
            HeightAt(row * grid_->columns + column),
            (scale.z() * static_cast<double>(row) - middle_.z()) / sides_.z()};
  }
  /// `vertex`: 0 to 2.
  Eigen::Vector3d Corner(std::size_t triangle, std::size_t vertex) const {
    const std::size_t cell = triangle / 2, width = grid_->columns - 1;
    // Columns and rows of the corners of both triangles, after those of the cell.
    constexpr std::size_t kColumn[2][3] = {{0, 0, 1}, {1, 0, 1}},
                          kRow[2][3] = {{0, 1, 0}, {0, 1, 1}};
    return Point(cell % width + kColumn[triangle % 2][vertex],
                 cell / width + kRow[triangle % 2][vertex]);
  }
  /// The farthest point along a direction.
  Eigen::Vector3d Support(const Eigen::Vector3d& along) const;
  /// Of the ball about the origin around the field with these sides.
  double OuterRadius(const Eigen::Vector3d& sides) const;
  /// Calls `visit(triangle)` for triangles whose boxes overlap or touch `box`, until it returns
  /// true; returns whether it did. O(blocks under the box + cells under it in blocks as high).
  template <typename Visit>
  bool AnyOf(const Eigen::AlignedBox3d& box, Visit visit) const {
    const Range columns = CellsIn(box.min().x(), box.max().x(), grid_->columns),
                rows = CellsIn(box.min().z(), box.max().z(), grid_->rows);
    for (std::size_t top = rows.first / kBlock; top * kBlock < rows.end; ++top)
      for (std::size_t left = columns.first / kBlock; left * kBlock < columns.end; ++left) {
        const Extent& extent = blocks_[top * width_in_blocks_ + left];
        if (!Meet(box, extent.low, extent.high)) continue;
        const std::size_t end_row = std::min(rows.end, (top + 1) * kBlock),
                          end_column = std::min(columns.end, (left + 1) * kBlock);
        for (std::size_t row = std::max(rows.first, top * kBlock); row < end_row; ++row)
          for (std::size_t column = std::max(columns.first, left * kBlock); column < end_column;
               ++column)
            if (AnyOfCell(column, row, box, visit)) return true;
      }
    return false;
  }

 private:
  static constexpr std::size_t kBlock = 32;  ///< cells along each side
  struct Range {
    std::size_t first, end;
  };
  struct Extent {
    double low, high;
  };

  static double Cells(std::size_t points) { return static_cast<double>(points - 1); }
  /// The cells of a line of points that touch the interval.
  static Range CellsIn(double from, double to, std::size_t points) {
    const double cells = Cells(points);
    const double first = std::ceil((from + 0.5) * cells - 1), last = std::floor((to + 0.5) * cells);
    if (!(first <= last && last >= 0 && first < cells)) return {0, 0};
    return {static_cast<std::size_t>(std::max(first, 0.0)),
            static_cast<std::size_t>(std::min(last, cells - 1)) + 1};
  }
  static bool Meet(const Eigen::AlignedBox3d& box, double low, double high) {
    return low <= box.max().y() && high >= box.min().y();
  }
  double HeightAt(std::size_t index) const {
    return (grid_->scale.y() * grid_->heights[index] - middle_.y()) / sides_.y();
  }
  template <typename Visit>
  bool AnyOfCell(std::size_t column, std::size_t row, const Eigen::AlignedBox3d& box,
                 Visit& visit) const {
    const std::size_t at = row * grid_->columns + column, below = at + grid_->columns,
                      triangle = 2 * (row * (grid_->columns - 1) + column);
    const double right = HeightAt(at + 1), left_below = HeightAt(below);
    const auto [low, high] = std::minmax(right, left_below);
    for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
      const double third = HeightAt(i == 0 ? at : below + 1);
      if (Meet(box, std::min(low, third), std::max(high, third)) && visit(triangle + i))
        return true;
    }
    return false;
  }
  /// The points of a block.
  Range ColumnsOf(std::size_t block) const;
  Range RowsOf(std::size_t block) const;
  /// Along this direction; no point of the block is beyond it.
  double ReachOf(std::size_t block, const Eigen::Vector3d& along) const;
  template <typename Visit>
  void ForPointsOf(std::size_t block, Visit visit) const;

  std::shared_ptr<const terrain::HeightGrid> grid_;
  double lowest_ = 0, highest_ = 0;
  Eigen::AlignedBox3d box_;
  Eigen::Vector3d middle_, sides_;  ///< of the box; a flat one is as high as it is long
  std::size_t width_in_blocks_ = 0;
  std::vector<Extent> blocks_;  ///< along y, in the cube
};

}  // namespace cdb::objects
