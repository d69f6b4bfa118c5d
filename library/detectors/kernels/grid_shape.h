// Chooses the cells of a grid from its boxes, in steps of bounded cost.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "library/detectors/kernels/kernels.h"

namespace cdb::kernels {

/// Chooses origin, cell size and the limit for oversized boxes. Call Start, CountLengths for all
/// boxes, FixLimit, MeasureReach for all boxes, Shape; the boxes must not change in between.
/// Coordinates in m. Errors: bad_alloc. Threads: one at a time.
class GridShapeChooser {
 public:
  static constexpr std::size_t kMaxSample = 256;

  void Start(const Columns& boxes, std::size_t count);
  void CountLengths(std::size_t begin, std::size_t end);
  void FixLimit();
  void MeasureReach(std::size_t begin, std::size_t end);
  GridShape Shape();

 private:
  using Vector = std::array<double, 3>;
  /// The boxes from which the shape is chosen: a fraction of them, spread evenly over the ids.
  struct Sample {
    std::array<std::array<float, kMaxSample>, 3> lower, extent;
    std::array<float, kMaxSample> longest;
    std::size_t size = 0;
  };
  /// The region of the grid, and the number of boxes in it.
  struct Region {
    Vector from, spread;
    double total;    ///< number of boxes
    double density;  ///< boxes per volume
  };
  /// Cell sides, and the cost of a query; infinite if there would be too many rows.
  struct Cells {
    Vector sides;
    double cost;
  };

  void TakeSample(std::size_t count);
  Region RegionOf(std::size_t count) const;
  template <typename See>
  void ForEachLimit(const See& see) const;
  Vector MeanExtent() const;
  Cells CellsOfWidth(double width) const;
  Vector CheapestSides() const;

  Columns boxes_ = {};
  Sample sample_;
  Region region_ = {};
  std::vector<std::size_t> counts_;  ///< histogram of longest sides, eight bins an octave
  float limit_ = 0;                  ///< the longest side that a box in a cell may have
  std::array<float, 3> reach_ = {};  ///< the largest extents within the limit
  Vector mean_ = {};                 ///< the mean extents within the limit
  double usual_ = 0;                 ///< the largest reach
};

}  // namespace cdb::kernels
