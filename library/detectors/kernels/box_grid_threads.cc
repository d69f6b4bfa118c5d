// The counting sort of a grid on several threads: each bins a part of the boxes, moves their ids to
// the buckets of all threads, and sorts a bucket. The order is that of one thread, as ids ascend in
// every part and every bucket.
#include <algorithm>
#include <atomic>
#include <limits>
#include <utility>

#include "library/detectors/kernels/box_grid.h"

namespace cdb::kernels {
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
