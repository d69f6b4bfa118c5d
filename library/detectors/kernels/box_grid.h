// A uniform grid of boxes, rebuilt on request: the basis of `grid` and `skin`.
//
// Method: each box is counted into the cell of its lower corner. Cells along x are adjacent in
// memory, so that the candidates of a box are a few rows, each contiguous and tested eight boxes at
// once. Oversized boxes, much longer than most, are kept in a separate list and tested with all
// others. Origin, cell size and the limit for oversized boxes are chosen from the boxes, every
// sixteenth build or when far more boxes than expected are oversized. Where many boxes share a few
// cells, as in clusters far apart, each of these cells gets a nested grid (box_crowds.cc).
//
// Cost: linear in boxes, plus boxes times oversized boxes / 8, plus the pairs. Memory: about 70
// bytes a box, and 150 in a crowd.
//
// Errors: bad_alloc. Threads: one at a time; Query may run on several at once.
// Source: uniform grids as in Ericson, Real-Time Collision Detection, section 7.1; grids in cells
// as in Kalojanov, Billeter & Slusallek, Two-Level Grids for Ray Tracing on GPUs, 2011.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "library/detectors/kernels/grid_shape.h"
#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_buffer.h"
#include "library/detectors/kernels/soa_boxes.h"
#include "library/detectors/kernels/thread_pool.h"

namespace cdb::kernels {

/// The box in floats, rounded outwards; unchanged if its coordinates are floats.
inline FatBox Around(const Box& box, const Kernels& kernels) {
  FatBox around;
  kernels.narrow(&box, 1,
                 {{around.lower, around.lower + 1, around.lower + 2},
                  {around.upper, around.upper + 1, around.upper + 2}});
  return around;
}

/// The columns from box `begin` on.
inline Columns From(Columns columns, std::size_t begin) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    columns.lower[axis] += begin;
    columns.upper[axis] += begin;
  }
  return columns;
}

class BoxGrid {
 public:
  explicit BoxGrid(const Kernels& kernels)
      : kernels_(kernels), chooser_(std::make_shared<GridShapeChooser>()) {}

  /// Boxes with a NaN are left out. True if every coordinate is representable as float: then the
  /// pairs are exact; otherwise there may be a few false positives. Uses all threads of `pool`, if
  /// given and if there are enough boxes; the result does not depend on them.
  bool Build(const Box* boxes, std::size_t count, ThreadPool* pool = nullptr);

  /// The same for boxes that the caller writes into the memory returned by Room, in steps of
  /// bounded cost: call StartArranging, then Arrange until it returns true. `budget`, in
  /// nanoseconds of a typical machine, is reduced by the cost; the grid must not be queried before
  /// the end.
  void Reserve(std::size_t count);
  const Columns& Room(std::size_t count);
  void StartArranging(std::size_t count);
  bool Arrange(double& budget);
  /// Uses the cells of another grid, whose boxes are similar, instead of choosing them anew.
  void TakeShape(const BoxGrid& other);
  /// Makes the next build choose the cells again, because the boxes are unrelated to the last ones.
  void Reshape() { shaped_for_ = 0; }

  /// The pairs found from the boxes `begin` to `end` of Size(). Each pair is found from one of its
  /// two boxes; the concatenation of adjacent ranges is the same list however they are divided. Not
  /// valid after Grow.
  void Query(std::size_t begin, std::size_t end, PairSink& sink) const;
  void QueryPart(unsigned part, unsigned parts, PairSink& sink) const {
    Query(Size() * part / parts, Size() * (part + 1) / parts, sink);
  }
  /// Pairs (id, other) of a box with all boxes of the grid; the lower id first if `is_ordered`.
  void QueryOne(const FatBox& box, Id id, PairSink& sink, bool is_ordered = false) const;
  /// Replaces the box `id` by one that contains it. The box keeps its cell, and QueryOne searches
  /// further by as much as any box has grown. False if the box was left out.
  bool Grow(Id id, const FatBox& box);

  /// Mean number of boxes that share the cell of a box; small if the grid suits the boxes.
  double MeanOccupancy() const { return mean_occupancy_; }
  /// The same without nested grids.
  double Crowding() const { return crowding_; }
  /// Approximate number of boxes that Query tests with the box at this place of Size().
  std::size_t OccupancyAt(std::size_t place) const;
  /// Number of oversized boxes, which are tested with all others.
  std::size_t TooLong() const { return count_ - gridded_; }
  /// Number of boxes, in cells and oversized. Boxes of crowds count twice, because they are looked
  /// up inside and outside their cell.
  std::size_t Size() const { return count_ + crowd_steps_; }

 private:
  /// The stages of Arrange, in this order; those before kBin only if the cells are chosen anew.
  enum class Stage {
    kSample,
    kLengths,
    kLimit,
    kReach,
    kShape,
    kBin,
    kClear,
    kCount,
    kCheck,
    kSum,
    kFindCrowds,
    kMeasureCrowds,
    kMoveCrowds,  ///< continues with kClear
    kPlace,
    kNest,
    kDone
  };
  struct Sums {
    std::uint32_t boxes = 0;
    std::size_t squares = 0;  ///< of the numbers of boxes in cells
  };

  /// The boxes of a cell that has a grid of its own.
  struct Crowd {
    std::uint32_t cell;
    std::uint32_t size;                ///< number of boxes
    bool is_nested;                    ///< `grid` has the boxes, and is to be arranged
    float least[3], most[3];           ///< of the lower corners
    double extents[3];                 ///< sums
    std::size_t inside, outside;       ///< the first steps of Query
    std::unique_ptr<BoxGrid> grid;     ///< the nested grid, with the ids of this one
    std::vector<std::uint32_t> boxes;  ///< ascending
  };

  bool Advance(double& budget);
  Stage Next(Stage stage);
  bool NeedsShape(std::size_t too_long);
  std::size_t SizeOf(Stage stage) const;
  double CostOf(Stage stage) const;
  void Execute(std::size_t begin, std::size_t end);
  void Bin(std::size_t begin, std::size_t end);
  void Sum(std::size_t begin, std::size_t end, Sums& sums);
  void Place(std::size_t begin, std::size_t end);
  void Place(std::span<const Id> boxes);
  void Finish(std::size_t squares);
  bool BuildOnThreads(const Box* boxes, std::size_t count, ThreadPool& pool);
  void PrepareThreads(unsigned parts);
  void BinPart(unsigned part, unsigned parts);
  void SplitForThreads(ThreadPool& pool);
  void SortBucket(unsigned bucket);
  std::uint32_t CellOf(float x, std::size_t axis) const;
  GridRows Rows() const;
  Id NameOf(std::size_t i) const { return names_.empty() ? static_cast<Id>(i) : names_[i]; }

  std::span<const Crowd> Crowds() const { return std::span(crowds_).first(crowd_count_); }
  bool IsCrowded(std::size_t squares) const;
  void FindCrowds(std::size_t begin, std::size_t end);
  void MeasureCrowds(std::size_t begin, std::size_t end);
  bool KeepCrowds();
  void MoveCrowds(std::size_t begin, std::size_t end);
  bool NestCrowds(double& budget);
  void StartNesting(Crowd& crowd);
  void FinishCrowds();
  Crowd* CrowdAt(std::uint32_t cell);
  Crowd* CrowdOf(Id id);
  void QueryCrowds(std::size_t begin, std::size_t end, PairSink& sink) const;
  template <typename See>
  void ForEachCrowd(const FatBox& box, const See& see) const;

  const Kernels& kernels_;
  GridShape shape_ = {};
  std::shared_ptr<GridShapeChooser> chooser_;  ///< shared with the nested grids
  SoaBoxes loose_, sorted_;                    ///< in order of ids, in order of cells
  std::vector<std::uint32_t> cells_, starts_;
  std::vector<Id> ids_;
  double mean_occupancy_ = 0, crowding_ = 0;
  std::size_t gridded_ = 0, count_ = 0;  ///< of the sorted boxes
  std::size_t foreseen_ = 0;             ///< oversized boxes when the cells were chosen
  std::size_t shaped_for_ = 0;           ///< number of boxes at that time
  unsigned age_ = 0;                     ///< builds since that time

  Stage stage_ = Stage::kDone;
  std::size_t boxes_ = 0;   ///< to be arranged
  std::size_t cursor_ = 0;  ///< progress within the stage
  bool is_new_ = false;     ///< the cells were chosen for these boxes
  Sums sums_;

  /// For several threads: each sorts the boxes of a range of cells, its bucket.
  struct Bucket {
    std::uint32_t first_cell, end_cell, first_box, end_box;
    std::size_t squares;
  };
  std::vector<Bucket> buckets_;
  /// For each part of the boxes, the number in each range of cells.
  std::vector<std::uint32_t> coarse_;
  unsigned coarse_shift_ = 0;
  std::vector<Id> order_;  ///< ids by bucket, ascending in each

  unsigned depth_ = 0;         ///< number of grids that this one is nested in
  std::vector<Id> names_;      ///< ids of the boxes; empty if they are the indices
  std::vector<Crowd> crowds_;  ///< by cell; the first crowd_count_ are in use
  std::size_t crowd_count_ = 0, crowd_steps_ = 0;
  bool is_split_ = false;  ///< crowds have been searched for
  /// The index of each box's crowd plus one, or 0; empty without crowds.
  std::vector<std::uint32_t> crowd_of_;
};

}  // namespace cdb::kernels
