// A uniform grid of boxes, rebuilt on request: the basis of `grid` and `skin`.
//
// Method: each box is counted into the cell of its lower corner. Cells along x are adjacent in
// memory, so that the candidates of a box are a few rows, each contiguous and tested eight boxes at
// once. Oversized boxes, much longer than most, are kept in a separate list and tested with all
// others. Origin, cell size and the limit for oversized boxes are chosen from the boxes, every
// sixteenth build or when far more boxes than expected are oversized.
//
// Cost: linear in boxes, plus boxes times oversized boxes / 8, plus the pairs. Memory: about 70
// bytes a box.
//
// Errors: bad_alloc. Threads: one at a time; Query may run on several at once.
// Source: uniform grids as in Ericson, Real-Time Collision Detection, section 7.1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_buffer.h"
#include "library/detectors/kernels/soa_boxes.h"

namespace cdb::kernels {

class BoxGrid {
 public:
  explicit BoxGrid(const Kernels& kernels) : kernels_(kernels) {}

  /// Boxes with a NaN are left out. True if every coordinate is representable as float: then the
  /// pairs are exact; otherwise there may be a few false positives.
  bool Build(const Box* boxes, std::size_t count);
  /// The same for boxes that the caller writes into the memory that Room returns: then Arrange.
  const Columns& Room(std::size_t count);
  void Arrange(std::size_t count);
  /// Makes the next build choose the cells again, because the boxes are unrelated to the last ones.
  void Reshape() { shaped_for_ = 0; }
  /// The pairs of the boxes `begin` to `end` of Size() with those before or after them. The
  /// concatenation of all ranges is the same list, whatever their number.
  void Query(std::size_t begin, std::size_t end, PairSink& sink) const;
  void QueryPart(unsigned part, unsigned parts, PairSink& sink) const {
    Query(count_ * part / parts, count_ * (part + 1) / parts, sink);
  }
  /// Pairs (id, other) of a box with all boxes of the grid.
  void QueryOne(const FatBox& box, Id id, PairSink& sink) const;

  /// Mean number of boxes that share the cell of a box; small if the grid suits the boxes.
  double MeanOccupancy() const { return mean_occupancy_; }
  /// Number of oversized boxes, which are tested with all others.
  std::size_t TooLong() const { return count_ - gridded_; }
  /// Number of boxes, in cells and oversized.
  std::size_t Size() const { return count_; }

 private:
  void ChooseShape(std::size_t count);
  GridRows Rows() const;

  const Kernels& kernels_;
  GridShape shape_ = {};
  SoaBoxes loose_, sorted_;  ///< by id, by cell
  std::vector<std::uint32_t> cells_, starts_;
  std::vector<Id> ids_;
  double mean_occupancy_ = 0;
  std::size_t gridded_ = 0, count_ = 0;  ///< of the sorted boxes
  std::size_t foreseen_ = 0;             ///< oversized boxes when the cells were chosen
  std::size_t shaped_for_ = 0;           ///< number of boxes at that time
  unsigned age_ = 0;                     ///< builds since that time
};

}  // namespace cdb::kernels
