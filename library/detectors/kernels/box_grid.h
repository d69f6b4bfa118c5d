// A uniform grid of boxes, rebuilt at will: what `grid` and `skin` stand on.
//
// Method: each box is counted into the cell of its lower corner, cells along x lie side by side, so
// that what a box may meet is a few rows, each one stretch of memory, tested eight boxes at once.
// Boxes much longer than most stand in a list of their own and are tested with all. Where the cells
// lie, how large they are and what is too long is chosen from the boxes, every sixteenth build or
// when far more boxes than foreseen are too long.
//
// Cost: linear in boxes, plus boxes times those too long / 8, plus the pairs. Memory: about 70
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

  /// Boxes that are not numbers are left out. True where every number is a float: then what is
  /// found is exact, else a few pairs that are close.
  bool Build(const Box* boxes, std::size_t count);
  /// The same of boxes that the caller writes, as they are, into what Room gives: then Arrange.
  const Columns& Room(std::size_t count);
  void Arrange(std::size_t count);
  /// Has the next build choose the shape: the boxes are other than those before.
  void Reshape() { shaped_for_ = 0; }
  /// The pairs of the boxes at `begin` to `end` of Size() with those before or after them: all
  /// ranges one after another give the same list whatever their number.
  void Query(std::size_t begin, std::size_t end, PairSink& sink) const;
  void QueryPart(unsigned part, unsigned parts, PairSink& sink) const {
    Query(count_ * part / parts, count_ * (part + 1) / parts, sink);
  }
  /// Pairs (id, other) of a box with all of the grid.
  void QueryOne(const FatBox& box, Id id, PairSink& sink) const;

  /// How many boxes share a box's cell, on the average; a few where the grid suits them.
  double ContactCluster() const { return crowd_; }
  /// Boxes that are tested with all.
  std::size_t TooLong() const { return count_ - gridded_; }
  /// Boxes in the grid and too long.
  std::size_t Size() const { return count_; }

 private:
  void ChooseShape(std::size_t count);
  GridRows Rows() const;

  const Kernels& kernels_;
  GridShape shape_ = {};
  SoaBoxes loose_, sorted_;  ///< by id, by cell
  std::vector<std::uint32_t> cells_, starts_;
  std::vector<Id> ids_;
  double crowd_ = 0;
  std::size_t gridded_ = 0, count_ = 0;  ///< of what is sorted
  std::size_t foreseen_ = 0;             ///< boxes too long when the shape was chosen
  std::size_t shaped_for_ = 0;           ///< boxes then
  unsigned age_ = 0;                     ///< builds since then
};

}  // namespace cdb::kernels
