#include "library/detectors/kernels/box_grid.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <numeric>
#include <utility>

namespace cdb::kernels {
namespace {

constexpr unsigned kMaxAge = 16;
/// Oversized boxes in excess of those expected, above which new cells pay off: each oversized box
/// is tested with all boxes.
constexpr std::size_t kMoreTooLong = 32;
/// Number of boxes from which several threads sort faster than one.
constexpr std::size_t kWorthThreads = 10000;
/// Smallest number of elements that a step processes; a multiple of the kernels' width.
constexpr std::size_t kLeast = 64;
constexpr std::size_t kPlaceBlock = 64;

}  // namespace

bool BoxGrid::Build(const Box* boxes, std::size_t count, ThreadPool* pool) {
  if (pool != nullptr && pool->size() > 1 && !pool->IsResting() && count >= kWorthThreads)
    return BuildOnThreads(boxes, count, *pool);
  const bool is_exact = kernels_.narrow(boxes, count, Room(count));
  StartArranging(count);
  double budget = std::numeric_limits<double>::infinity();
  Arrange(budget);
  return is_exact;
}

const Columns& BoxGrid::Room(std::size_t count) {
  loose_.Reserve(count);
  return loose_.get();
}

void BoxGrid::Reserve(std::size_t count) {
  loose_.Reserve(count);
  sorted_.Reserve(count);
  if (cells_.size() < count + 8) cells_.resize(count + count / 8 + 8);
  if (ids_.size() < count + 8) ids_.resize(count + count / 8 + 8);
  if (starts_.size() < 2 * count) starts_.resize(2 * count + 128);
}

void BoxGrid::TakeShape(const BoxGrid& other) {
  shape_ = other.shape_;
  foreseen_ = other.foreseen_;
  shaped_for_ = other.shaped_for_;
  age_ = other.age_;
}

void BoxGrid::StartArranging(std::size_t count) {
  Reserve(count);
  boxes_ = count;
  cursor_ = 0;
  crowd_count_ = crowd_steps_ = 0;
  is_split_ = false;
  crowd_of_.clear();
  std::ranges::fill(shape_.down, 0u);
  std::ranges::fill(shape_.up, 0u);
  is_new_ = ++age_ >= kMaxAge || count > 2 * shaped_for_ || 2 * count < shaped_for_;
  stage_ = is_new_ ? Stage::kSample : Stage::kBin;
}

bool BoxGrid::Arrange(double& budget) {
  while (stage_ != Stage::kDone) {
    if (!(stage_ == Stage::kNest ? NestCrowds(budget) : Advance(budget))) return false;
    stage_ = Next(stage_);
    cursor_ = 0;
  }
  return true;
}

/// False if the budget is used up before the stage is over.
bool BoxGrid::Advance(double& budget) {
  const std::size_t size = SizeOf(stage_), left = size - std::min(cursor_, size);
  if (left > 0 && budget <= 0) return false;
  const double cost = CostOf(stage_), most = budget / cost;
  std::size_t step = left;
  if (most < static_cast<double>(left))
    step = std::min(left, (static_cast<std::size_t>(std::max(most, 0.)) / kLeast + 1) * kLeast);
  Execute(cursor_, cursor_ + step);
  budget -= cost * static_cast<double>(step);
  cursor_ += step;
  return cursor_ >= size;
}

std::size_t BoxGrid::SizeOf(Stage stage) const {
  switch (stage) {
    case Stage::kSample:
    case Stage::kLimit:
    case Stage::kShape:
    case Stage::kCheck:
      return 1;
    case Stage::kClear:
    case Stage::kSum:
      return std::size_t{shape_.cells()} + 3;
    case Stage::kFindCrowds:
      return shape_.cells();
    default:
      return boxes_;
  }
}

/// Cost of an element of a stage, in nanoseconds, measured once on one machine.
double BoxGrid::CostOf(Stage stage) const {
  switch (stage) {
    case Stage::kSample:
      return 2500;
    case Stage::kLimit:
      return 2000;
    case Stage::kLengths:
    case Stage::kReach:
      return 3;
    case Stage::kBin:
      return 1.5;
    case Stage::kClear:
      return 0.2;
    case Stage::kPlace:
      return 10;
    case Stage::kMeasureCrowds:
    case Stage::kMoveCrowds:
      return 5;
    default:
      return 1;
  }
}

/// True if this number of oversized boxes requires new cells.
bool BoxGrid::NeedsShape(std::size_t too_long) {
  if (!is_new_ && too_long > foreseen_ + kMoreTooLong) {
    is_new_ = true;
    return true;
  }
  if (is_new_) foreseen_ = too_long;
  return false;
}

BoxGrid::Stage BoxGrid::Next(Stage stage) {
  if (stage == Stage::kCheck && NeedsShape(starts_[shape_.cells() + 1])) return Stage::kSample;
  if (stage == Stage::kSum && (is_split_ || !IsCrowded(sums_.squares))) return Stage::kPlace;
  if (stage == Stage::kMeasureCrowds && !KeepCrowds()) return Stage::kPlace;
  if (stage == Stage::kMoveCrowds) return Stage::kClear;
  return static_cast<Stage>(static_cast<int>(stage) + 1);
}

void BoxGrid::Execute(std::size_t begin, std::size_t end) {
  switch (stage_) {
    case Stage::kSample:
      age_ = 0;
      shaped_for_ = boxes_;
      return chooser_->Start(loose_.get(), boxes_);
    case Stage::kLengths:
      return chooser_->CountLengths(begin, end);
    case Stage::kLimit:
      return chooser_->FixLimit();
    case Stage::kReach:
      return chooser_->MeasureReach(begin, end);
    case Stage::kShape:
      shape_ = chooser_->Shape();
      return;
    case Stage::kBin:
      return Bin(begin, end);
    case Stage::kClear:
      if (starts_.size() < SizeOf(stage_)) starts_.resize(SizeOf(stage_));
      std::fill(starts_.begin() + static_cast<std::ptrdiff_t>(begin),
                starts_.begin() + static_cast<std::ptrdiff_t>(end), 0);
      return;
    case Stage::kCount:
      // The last two counts, after the cells, are of oversized boxes and of boxes with a NaN.
      for (std::size_t i = begin; i < end; ++i) ++starts_[cells_[i] + 1];
      return;
    case Stage::kSum:
      if (begin == 0) sums_ = {};
      Sum(begin, end, sums_);
      return;
    case Stage::kFindCrowds:
      return FindCrowds(begin, end);
    case Stage::kMeasureCrowds:
      return MeasureCrowds(begin, end);
    case Stage::kMoveCrowds:
      return MoveCrowds(begin, end);
    case Stage::kPlace:
      Place(begin, end);
      if (end == boxes_) Finish(sums_.squares);
      return;
    case Stage::kNest:
    case Stage::kCheck:
    case Stage::kDone:
      return;
  }
}

void BoxGrid::Bin(std::size_t begin, std::size_t end) {
  kernels_.bin(From(loose_.get(), begin), end - begin, shape_, cells_.data() + begin);
}

// starts_[c + 1] becomes the place of the next box of cell c; once all boxes are placed, it is the
// end of the cell.
void BoxGrid::Sum(std::size_t begin, std::size_t end, Sums& sums) {
  for (std::size_t c = begin; c < end; ++c) {
    const std::uint32_t count = starts_[c];
    sums.squares += std::size_t{count} * count;
    starts_[c] = sums.boxes;
    sums.boxes += count;
  }
}

// All places of a block are known before anything is written there; see BitsWhere in
// kernels_impl.h.
void BoxGrid::Place(std::span<const Id> boxes) {
  const Columns &from = loose_.get(), &to = sorted_.get();
  std::uint32_t places[kPlaceBlock];
  for (; !boxes.empty(); boxes = boxes.subspan(std::min(boxes.size(), kPlaceBlock))) {
    const std::span<const Id> block = boxes.first(std::min(boxes.size(), kPlaceBlock));
    for (std::size_t k = 0; k < block.size(); ++k) places[k] = starts_[cells_[block[k]] + 1]++;
    for (std::size_t k = 0; k < block.size(); ++k) {
      const Id i = block[k];
      const std::uint32_t at = places[k];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        to.lower[axis][at] = from.lower[axis][i];
        to.upper[axis][at] = from.upper[axis][i];
      }
      ids_[at] = i;
    }
  }
}

void BoxGrid::Place(std::size_t begin, std::size_t end) {
  Id boxes[kPlaceBlock];
  for (; begin < end; begin += kPlaceBlock) {
    const std::span<Id> block = std::span(boxes).first(std::min(end - begin, kPlaceBlock));
    std::iota(block.begin(), block.end(), static_cast<Id>(begin));
    Place(block);
  }
}

void BoxGrid::Finish(std::size_t squares) {
  gridded_ = starts_[shape_.cells()];
  count_ = starts_[shape_.cells() + 1];
  const std::size_t left_out = boxes_ - count_;
  squares -= left_out * left_out;
  mean_occupancy_ = boxes_ > 0 ? static_cast<double>(squares) / static_cast<double>(boxes_) : 0;
  if (crowd_count_ == 0) crowding_ = mean_occupancy_;
  if (!names_.empty())
    for (std::size_t at = 0; at < boxes_; ++at) ids_[at] = names_[ids_[at]];
}

GridRows BoxGrid::Rows() const {
  return {sorted_.get(), ids_.data(), starts_.data(), gridded_, count_};
}

void BoxGrid::Query(std::size_t begin, std::size_t end, PairSink& sink) const {
  if (begin < count_) kernels_.query(Rows(), shape_, begin, std::min(end, count_), sink);
  if (end > count_) QueryCrowds(std::max(begin, count_), end, sink);
}

/// The same cell as the kernels compute.
std::uint32_t BoxGrid::CellOf(float x, std::size_t axis) const {
  const float cell = (x - shape_.origin[axis]) * shape_.inverse[axis];
  return static_cast<std::uint32_t>(cell > 0 ? std::min(cell, shape_.last[axis]) : 0);
}

bool BoxGrid::Grow(Id id, const FatBox& box) {
  Crowd* crowd = CrowdOf(id);
  const std::uint32_t cell = crowd != nullptr ? crowd->cell : cells_[id], cells = shape_.cells();
  if (cell > cells) return false;
  if (crowd != nullptr) {
    const auto at = std::ranges::lower_bound(crowd->boxes, id);
    crowd->grid->Grow(static_cast<Id>(at - crowd->boxes.begin()), box);
  } else {
    // Within a cell, ids are in ascending order.
    const auto first = ids_.begin() + static_cast<std::ptrdiff_t>(starts_[cell]);
    const auto last = ids_.begin() + static_cast<std::ptrdiff_t>(starts_[cell + 1]);
    const auto at =
        static_cast<std::size_t>(std::lower_bound(first, last, NameOf(id)) - ids_.begin());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sorted_.get().lower[axis][at] = box.lower[axis];
      sorted_.get().upper[axis][at] = box.upper[axis];
    }
  }
  if (cell == cells) return true;  // oversized: tested in every query
  const std::uint32_t place[3] = {cell % shape_.n[0], cell / shape_.n[0] % shape_.n[1],
                                  cell / shape_.n[0] / shape_.n[1]};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::uint32_t lower = CellOf(box.lower[axis], axis),
                        upper = CellOf(box.upper[axis], axis);
    shape_.down[axis] = std::max(shape_.down[axis], place[axis] - std::min(lower, place[axis]));
    shape_.up[axis] = std::max(shape_.up[axis], std::max(upper, place[axis]) - place[axis]);
  }
  return true;
}

// The counting sort of a grid on several threads: each bins a part of the boxes, moves their ids to
// the buckets of all threads, and sorts a bucket. The order is that of one thread, as ids ascend in
// every part and every bucket.

namespace {

/// Number of ranges of cells; buckets consist of whole ranges.
constexpr std::uint32_t kRanges = 1024;

/// The first box of a part; a multiple of the kernels' width.
std::size_t BeginOf(unsigned part, unsigned parts, std::size_t count) {
  constexpr std::size_t kBlock = 8;
  return part == parts ? count : count / kBlock * part / parts * kBlock;
}

}  // namespace

bool BoxGrid::BuildOnThreads(const Box* boxes, std::size_t count, ThreadPool& pool) {
  const unsigned parts = pool.size();
  const Columns& room = Room(count);
  StartArranging(count);
  order_.resize(count);
  std::atomic<bool> is_exact = true;
  const auto narrow = [&](unsigned part) {
    const std::size_t begin = BeginOf(part, parts, count), end = BeginOf(part + 1, parts, count);
    if (!kernels_.narrow(boxes + begin, end - begin, From(room, begin))) is_exact = false;
  };
  const bool has_shape = stage_ == Stage::kBin;
  if (!has_shape) pool.Run(parts, narrow);
  for (bool is_first = true;; is_first = false) {
    for (; stage_ != Stage::kBin; stage_ = Next(stage_)) Execute(0, SizeOf(stage_));
    PrepareThreads(parts);
    pool.Run(parts, [&](unsigned part) {
      if (has_shape && is_first) narrow(part);
      BinPart(part, parts);
    });
    SplitForThreads(pool);
    pool.Run(parts, [&](unsigned part) { SortBucket(part); });
    if (!NeedsShape(starts_[shape_.cells() + 1] - starts_[shape_.cells()])) break;
    stage_ = Stage::kSample;
  }
  std::size_t squares = 0;
  for (const Bucket& bucket : buckets_) squares += bucket.squares;
  if (IsCrowded(squares)) {  // crowds are handled on this thread
    stage_ = Stage::kBin;
    double budget = std::numeric_limits<double>::infinity();
    Arrange(budget);
    return is_exact;
  }
  Finish(squares);
  stage_ = Stage::kDone;
  return is_exact;
}

void BoxGrid::PrepareThreads(unsigned parts) {
  starts_.resize(std::max(starts_.size(), SizeOf(Stage::kClear)));
  for (coarse_shift_ = 0; (shape_.cells() + 2) >> coarse_shift_ >= kRanges;) ++coarse_shift_;
  coarse_.assign(std::size_t{parts} * kRanges, 0);
}

void BoxGrid::BinPart(unsigned part, unsigned parts) {
  const std::size_t begin = BeginOf(part, parts, boxes_), end = BeginOf(part + 1, parts, boxes_);
  Bin(begin, end);
  std::uint32_t* counts = coarse_.data() + std::size_t{part} * kRanges;
  for (std::size_t i = begin; i < end; ++i) ++counts[cells_[i] >> coarse_shift_];
}

/// Divides the cells into buckets of about as many boxes each, and moves the ids there.
void BoxGrid::SplitForThreads(ThreadPool& pool) {
  const unsigned parts = pool.size();
  std::vector<std::uint32_t> bucket_of(kRanges);
  std::vector<std::uint32_t> places(std::size_t{parts} * parts, 0);  // of each part in each bucket
  const std::uint32_t cells = shape_.cells() + 2;
  buckets_.assign(parts, {0, 0, 0, 0, 0});
  std::uint32_t seen = 0;
  for (std::uint32_t range = 0; range < kRanges; ++range) {
    const auto bucket =
        static_cast<std::uint32_t>(std::size_t{seen} * parts / std::max<std::size_t>(boxes_, 1));
    bucket_of[range] = std::min(bucket, parts - 1);
    for (unsigned part = 0; part < parts; ++part) {
      const std::uint32_t count = coarse_[std::size_t{part} * kRanges + range];
      seen += count;
      places[std::size_t{bucket_of[range]} * parts + part] += count;
    }
    buckets_[bucket_of[range]].end_cell = std::min((range + 1) << coarse_shift_, cells);
  }
  std::uint32_t sum = 0, cell = 0;
  for (unsigned bucket = 0; bucket < parts; ++bucket) {
    Bucket& it = buckets_[bucket];
    it.first_box = sum;
    for (unsigned part = 0; part < parts; ++part)
      sum += std::exchange(places[std::size_t{bucket} * parts + part], sum);
    it.end_box = sum;
    it.first_cell = cell;
    it.end_cell = cell = std::max(cell, it.end_cell);
  }
  pool.Run(parts, [&](unsigned part) {
    const std::size_t begin = BeginOf(part, parts, boxes_), end = BeginOf(part + 1, parts, boxes_);
    std::vector<std::uint32_t> at(parts);
    for (unsigned bucket = 0; bucket < parts; ++bucket)
      at[bucket] = places[std::size_t{bucket} * parts + part];
    for (std::size_t i = begin; i < end; ++i)
      order_[at[bucket_of[cells_[i] >> coarse_shift_]]++] = static_cast<Id>(i);
  });
}

void BoxGrid::SortBucket(unsigned bucket) {
  Bucket& it = buckets_[bucket];
  if (bucket == 0) starts_[0] = 0;
  const auto first = starts_.begin() + it.first_cell + 1;
  std::fill(first, starts_.begin() + it.end_cell + 1, 0);
  for (std::uint32_t k = it.first_box; k < it.end_box; ++k) ++starts_[cells_[order_[k]] + 1];
  Sums sums = {it.first_box, 0};
  Sum(it.first_cell + 1, it.end_cell + 1, sums);
  it.squares = sums.squares;
  Place(std::span(order_).subspan(it.first_box, it.end_box - it.first_box));
}

}  // namespace cdb::kernels
