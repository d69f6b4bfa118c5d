#include "library/detectors/kernels/grid_shape.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>

#include "library/detectors/kernels/bodies.h"

namespace cdb::kernels {
namespace {

// In nanoseconds, measured once on one machine; only their ratios matter.
constexpr double kScanCost = 5, kTestCost = 0.5;
constexpr std::size_t kMinSample = 64;
constexpr double kNoCost = std::numeric_limits<double>::infinity();
/// Bins of the histogram of lengths. It counts all boxes, because a sample misses an oversized box
/// among a thousand, which costs as much as all the others.
constexpr std::uint32_t kShift = 20, kBins = 1u << (31 - kShift);

float LongestSide(const Columns& boxes, std::size_t i) {
  float longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    longest = std::max(longest, boxes.upper[axis][i] - boxes.lower[axis][i]);
  return longest;
}

}  // namespace

void GridShapeChooser::Start(const Columns& boxes, std::size_t count) {
  boxes_ = boxes;
  TakeSample(count);
  counts_.assign(kBins, 0);
  limit_ = 0;
  reach_ = {};
  if (sample_.size > 0) region_ = RegionOf(count);
}

void GridShapeChooser::TakeSample(std::size_t count) {
  sample_.size = 0;
  const std::size_t size = std::min(count, std::clamp(count / 8, kMinSample, kMaxSample));
  for (std::size_t k = 0; k < size; ++k) {
    const std::size_t i = size < count ? SampleIndex(k, count) : k;
    bool is_finite = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float lower = boxes_.lower[axis][i], extent = boxes_.upper[axis][i] - lower;
      sample_.lower[axis][sample_.size] = lower;
      sample_.extent[axis][sample_.size] = extent;
      is_finite &= std::isfinite(lower) && std::isfinite(extent);
    }
    sample_.longest[sample_.size] = LongestSide(boxes_, i);
    sample_.size += is_finite;
  }
}

/// The region of the grid: the range of most boxes, extended by its width on both sides, but not
/// beyond the outermost boxes. The density is that of most boxes: a few that are far away must not
/// make cells so large that all others share one.
GridShapeChooser::Region GridShapeChooser::RegionOf(std::size_t count) const {
  const std::size_t n = sample_.size;
  Region region;
  double dense_volume = 1;  // the range of the middle 7/8 of the boxes along each axis, times 8/7
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto x = sample_.lower[axis];
    const auto begin = x.begin(), end = begin + static_cast<std::ptrdiff_t>(n);
    const auto few = static_cast<std::ptrdiff_t>(n / 16);
    std::nth_element(begin, begin + few, end);
    const double low = begin[few], least = *std::min_element(begin, begin + few + 1);
    std::nth_element(begin + few, end - 1 - few, end);
    const double high = end[-1 - few], most = *std::max_element(end - 1 - few, end);
    const double width = high - low;
    region.from[axis] = std::max(least, low - width);
    region.spread[axis] = std::min(most, high + width) - region.from[axis];
    dense_volume *= std::max(width * 8 / 7, 1e-30);
  }
  region.total = static_cast<double>(count);
  region.density = region.total / dense_volume;
  return region;
}

void GridShapeChooser::CountLengths(std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    const float longest = LongestSide(boxes_, i);
    if (std::isfinite(longest)) ++counts_[std::bit_cast<std::uint32_t>(longest) >> kShift];
  }
}

/// Calls see(limit, beyond) for each limit that makes a difference; `beyond` boxes are longer.
template <typename See>
void GridShapeChooser::ForEachLimit(const See& see) const {
  std::size_t beyond = 0;
  for (std::uint32_t bin = kBins; bin-- > 0;) {
    if (counts_[bin] == 0) continue;
    see(std::bit_cast<float>(((bin + 1) << kShift) - 1), beyond);
    beyond += counts_[bin];
  }
}

// With each limit, boxes within it cost the tests in a cell, and boxes beyond it cost a scan of all
// boxes.
void GridShapeChooser::FixLimit() {
  if (sample_.size == 0) return;
  double best = kNoCost;
  ForEachLimit([&](float length, std::size_t beyond) {
    const double share = 1 - static_cast<double>(beyond) / region_.total;
    double volume = 1;
    for (std::size_t axis = 0; axis < 3; ++axis)
      volume *= std::min<double>(2 * length, region_.spread[axis] + length);
    const double cost =
        share * (volume * region_.density * kTestCost) + (1 - share) * region_.total / 8;
    if (cost >= best) return;
    best = cost;
    limit_ = length;
  });
}

void GridShapeChooser::MeasureReach(std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    if (!(LongestSide(boxes_, i) <= limit_)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis)
      reach_[axis] = std::max(reach_[axis], boxes_.upper[axis][i] - boxes_.lower[axis][i]);
  }
}

GridShapeChooser::Vector GridShapeChooser::MeanExtent() const {
  const auto longest = std::span(sample_.longest).first(sample_.size);
  const auto kept = static_cast<double>(
      std::ranges::count_if(longest, [&](float length) { return length <= limit_; }));
  Vector mean = {};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < sample_.size; ++i)
      if (sample_.longest[i] <= limit_) mean[axis] += sample_.extent[axis][i] / kept;
  return mean;
}

/// Cells with sides of `width` times the largest extent. The cost of a query is that of the rows
/// that it scans and of the boxes that it tests in them.
GridShapeChooser::Cells GridShapeChooser::CellsOfWidth(double width) const {
  const Vector& spread = region_.spread;
  Cells cells = {{}, kNoCost};
  Vector& sides = cells.sides;
  double rows = 1, area = 1;
  for (std::size_t axis = 1; axis < 3; ++axis) {
    sides[axis] = std::max(width * usual_, spread[axis] / 1023);
    const double crossed = 1 + (reach_[axis] + mean_[axis]) / sides[axis];
    const double scanned = std::min(crossed, spread[axis] / sides[axis] + 1);
    rows *= scanned;
    area *= std::min(scanned * sides[axis], spread[axis] + usual_);
  }
  // Along x, cells are as short as about two cells per box permit.
  const double columns =
      (std::floor(spread[1] / sides[1]) + 1) * (std::floor(spread[2] / sides[2]) + 1);
  const double most = 2 * region_.total + 64;
  if (columns > most) return cells;
  sides[0] = std::max({mean_[0] / 4, spread[0] * columns / most, spread[0] / 65535});
  const double length = std::min(reach_[0] + mean_[0] + sides[0], spread[0] + usual_);
  const double tests = area * length * region_.density / rows;  // in one row
  cells.cost = rows * (kScanCost + kTestCost * std::ceil(tests / 8) * 8);
  return cells;
}

GridShapeChooser::Vector GridShapeChooser::CheapestSides() const {
  Cells best = {{}, kNoCost};
  for (const double width : {0.35, 0.5, 0.7, 1., 1.4, 2., 2.8, 4., 5.6, 8., 16., 32., 64.}) {
    const Cells cells = CellsOfWidth(width);
    if (cells.cost < best.cost) best = cells;
  }
  if (!(best.cost < kNoCost))
    for (std::size_t axis = 0; axis < 3; ++axis)
      best.sides[axis] = std::max({usual_, region_.spread[axis] / std::cbrt(region_.total + 64)});
  return best.sides;
}

GridShape GridShapeChooser::Shape() {
  GridShape shape = {};
  if (sample_.size == 0) {  // no finite box
    for (std::size_t axis = 0; axis < 3; ++axis) {
      shape.reach[axis] = -1;
      shape.n[axis] = 1;
    }
    return shape;
  }
  // The largest extents, with room for boxes to grow until the next shape.
  for (float& extent : reach_) extent = extent * 1.25f + std::numeric_limits<float>::min();
  mean_ = MeanExtent();
  usual_ = *std::ranges::max_element(reach_);
  const Vector sides = CheapestSides();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double side = std::max(sides[axis], 1e-30);
    const double cells = std::clamp(std::floor(region_.spread[axis] / side) + 1, 1., 65536.);
    shape.origin[axis] = static_cast<float>(region_.from[axis]);
    shape.inverse[axis] = static_cast<float>(std::min(1 / side, 1e30));
    shape.n[axis] = static_cast<std::uint32_t>(cells);
    shape.last[axis] = static_cast<float>(shape.n[axis] - 1);
    shape.reach[axis] = reach_[axis];
  }
  return shape;
}

}  // namespace cdb::kernels
