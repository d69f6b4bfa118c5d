#include "library/detectors/kernels/box_grid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "library/detectors/kernels/bodies.h"

namespace cdb::kernels {
namespace {

constexpr unsigned kMaxAge = 16;
constexpr std::size_t kMaxSample = 256;
/// Each is tested with all boxes; so many more than foreseen cost as much as a new shape.
constexpr std::size_t kMoreTooLong = 32;
// In nanoseconds, measured once on one machine; only their ratios matter.
constexpr double kScanCost = 5, kTestCost = 0.5;

/// The box from which the shape is chosen: a share of the boxes, spread evenly over the ids.
struct Sample {
  std::array<std::array<float, kMaxSample>, 3> lower, extent;
  std::array<float, kMaxSample> longest;
  std::size_t size = 0;
};

float Longest(const Columns& boxes, std::size_t i) {
  float longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    longest = std::max(longest, boxes.upper[axis][i] - boxes.lower[axis][i]);
  return longest;
}

Sample Take(const Columns& boxes, std::size_t count) {
  Sample sample;
  const std::size_t size = std::min(count, kMaxSample);
  for (std::size_t k = 0; k < size; ++k) {
    const std::size_t i = size < count ? SamplePlace(k, count) : k;
    bool is_finite = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float lower = boxes.lower[axis][i], extent = boxes.upper[axis][i] - lower;
      sample.lower[axis][sample.size] = lower;
      sample.extent[axis][sample.size] = extent;
      is_finite &= std::isfinite(lower) && std::isfinite(extent);
    }
    sample.longest[sample.size] = Longest(boxes, i);
    sample.size += is_finite;
  }
  return sample;
}

/// All boxes by their longest side, eight bins an octave: one in a thousand that is too long for
/// the grid is missed by a sample, and costs as much as all the others.
class Lengths {
 public:
  Lengths(const Columns& boxes, std::size_t count) : counts_(kBins, 0) {
    for (std::size_t i = 0; i < count; ++i) {
      const float longest = Longest(boxes, i);
      if (std::isfinite(longest)) ++counts_[std::bit_cast<std::uint32_t>(longest) >> kShift];
    }
  }
  /// `see(limit, beyond)`: how many boxes are longer, for each limit that makes a difference.
  template <typename See>
  void ForEachLimit(const See& see) const {
    std::size_t beyond = 0;
    for (std::uint32_t bin = kBins; bin-- > 0;) {
      if (counts_[bin] == 0) continue;
      see(std::bit_cast<float>(((bin + 1) << kShift) - 1), beyond);
      beyond += counts_[bin];
    }
  }

 private:
  static constexpr std::uint32_t kShift = 20, kBins = 1u << (31 - kShift);
  std::vector<std::size_t> counts_;
};

using Vector = std::array<double, 3>;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Where the grid is, and how many boxes it holds.
struct Region {
  Vector from, spread;
  double total;    ///< number of boxes
  double density;  ///< boxes per volume
};

/// Most of the boxes, and as much again on both sides, but no further than the last. The density
/// is that of the middle of the boxes: a few that are far away must not make cells so large that
/// all others share one.
Region RegionOf(const Sample& sample, std::size_t count) {
  const std::size_t n = sample.size;
  Region region;
  double dense_volume = 1;  // where the middle half of each axis lies, doubled
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto x = sample.lower[axis];
    std::sort(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(n));
    const double low = x[n / 16], high = x[n - 1 - n / 16], width = high - low;
    region.from[axis] = std::max<double>(x[0], low - width);
    region.spread[axis] = std::min<double>(x[n - 1], high + width) - region.from[axis];
    dense_volume *= std::max(width * 8 / 7, 1e-30);
  }
  region.total = static_cast<double>(count);
  region.density = region.total / dense_volume;
  return region;
}

/// The longest side that a box in a cell may have. With each limit, the boxes within it cost the
/// tests of a cell, those beyond it a scan of all boxes.
float CheapestLimit(const Lengths& lengths, const Region& region) {
  double best = kInfinity;
  float limit = 0;
  lengths.ForEachLimit([&](float length, std::size_t beyond) {
    const double share = 1 - static_cast<double>(beyond) / region.total;
    double volume = 1;
    for (std::size_t axis = 0; axis < 3; ++axis)
      volume *= std::min<double>(2 * length, region.spread[axis] + length);
    const double cost =
        share * (volume * region.density * kTestCost) + (1 - share) * region.total / 8;
    if (cost >= best) return;
    best = cost;
    limit = length;
  });
  return limit;
}

/// The extent of the boxes within `limit`: the largest, with room to grow until the next shape.
std::array<float, 3> Reach(const Columns& boxes, std::size_t count, float limit) {
  std::array<float, 3> reach = {};
  for (std::size_t i = 0; i < count; ++i) {
    if (!(Longest(boxes, i) <= limit)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis)
      reach[axis] = std::max(reach[axis], boxes.upper[axis][i] - boxes.lower[axis][i]);
  }
  for (float& extent : reach) extent = extent * 1.25f + std::numeric_limits<float>::min();
  return reach;
}

/// The mean extent of the boxes within `limit`.
Vector MeanExtent(const Sample& sample, float limit) {
  const auto longest = std::span(sample.longest).first(sample.size);
  const auto kept = static_cast<double>(
      std::ranges::count_if(longest, [&](float length) { return length <= limit; }));
  Vector mean = {};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < sample.size; ++i)
      if (sample.longest[i] <= limit) mean[axis] += sample.extent[axis][i] / kept;
  return mean;
}

/// The boxes of a grid whose cells are to be chosen.
struct Contents {
  Region region;
  std::array<float, 3> reach;
  Vector mean;
  double usual;  ///< the largest reach
};

struct Cells {
  Vector sides = {};
  double cost = kInfinity;  ///< of a query; infinite if there would be too many rows
};

/// Cells as wide as `width` of the largest boxes: the rows that a query scans, and the boxes that
/// it tests in them.
Cells CellsOfWidth(const Contents& it, double width) {
  const Vector& spread = it.region.spread;
  Cells cells;
  Vector& sides = cells.sides;
  double rows = 1, area = 1;
  for (std::size_t axis = 1; axis < 3; ++axis) {
    sides[axis] = std::max(width * it.usual, spread[axis] / 1023);
    const double crossed = 1 + (it.reach[axis] + it.mean[axis]) / sides[axis];
    const double scanned = std::min(crossed, spread[axis] / sides[axis] + 1);
    rows *= scanned;
    area *= std::min(scanned * sides[axis], spread[axis] + it.usual);
  }
  // Along x a row is cut as often as there are boxes to pay for it.
  const double columns =
      (std::floor(spread[1] / sides[1]) + 1) * (std::floor(spread[2] / sides[2]) + 1);
  const double most = 2 * it.region.total + 64;
  if (columns > most) return cells;
  sides[0] = std::max({it.mean[0] / 4, spread[0] * columns / most, spread[0] / 65535});
  const double length = std::min(it.reach[0] + it.mean[0] + sides[0], spread[0] + it.usual);
  const double tests = area * length * it.region.density / rows;  // in one row
  cells.cost = rows * (kScanCost + kTestCost * std::ceil(tests / 8) * 8);
  return cells;
}

Vector CheapestSides(const Contents& it) {
  Cells best;
  for (const double width : {0.35, 0.5, 0.7, 1., 1.4, 2., 2.8, 4., 5.6, 8., 16., 32., 64.}) {
    const Cells cells = CellsOfWidth(it, width);
    if (cells.cost < best.cost) best = cells;
  }
  if (!(best.cost < kInfinity))
    for (std::size_t axis = 0; axis < 3; ++axis)
      best.sides[axis] =
          std::max({it.usual, it.region.spread[axis] / std::cbrt(it.region.total + 64)});
  return best.sides;
}

GridShape ShapeOf(const Contents& it, const Vector& sides) {
  GridShape shape = {};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double side = std::max(sides[axis], 1e-30);
    const double cells = std::clamp(std::floor(it.region.spread[axis] / side) + 1, 1., 65536.);
    shape.origin[axis] = static_cast<float>(it.region.from[axis]);
    shape.inverse[axis] = static_cast<float>(std::min(1 / side, 1e30));
    shape.n[axis] = static_cast<std::uint32_t>(cells);
    shape.last[axis] = static_cast<float>(shape.n[axis] - 1);
    shape.reach[axis] = it.reach[axis];
  }
  return shape;
}

}  // namespace

void BoxGrid::ChooseShape(std::size_t count) {
  age_ = 0;
  shaped_for_ = count;
  const Columns& boxes = loose_.get();
  const Sample sample = Take(boxes, count);
  if (sample.size == 0) {  // no box that could be in a cell
    shape_ = {.origin = {}, .inverse = {}, .last = {}, .reach = {-1, -1, -1}, .n = {1, 1, 1}};
    return;
  }
  Contents contents;
  contents.region = RegionOf(sample, count);
  const float limit = CheapestLimit(Lengths(boxes, count), contents.region);
  contents.reach = Reach(boxes, count, limit);
  contents.mean = MeanExtent(sample, limit);
  contents.usual = *std::ranges::max_element(contents.reach);
  shape_ = ShapeOf(contents, CheapestSides(contents));
}

bool BoxGrid::Build(const Box* boxes, std::size_t count) {
  const bool is_exact = kernels_.narrow(boxes, count, Room(count));
  Arrange(count);
  return is_exact;
}

const Columns& BoxGrid::Room(std::size_t count) {
  loose_.Reserve(count);
  return loose_.get();
}

void BoxGrid::Arrange(std::size_t count) {
  sorted_.Reserve(count);
  if (cells_.size() < count + 8) cells_.resize(count + count / 8 + 8);
  if (ids_.size() < count + 8) ids_.resize(count + count / 8 + 8);
  bool is_new = false;
  if (++age_ >= kMaxAge || count > 2 * shaped_for_ || 2 * count < shaped_for_) {
    ChooseShape(count);
    is_new = true;
  }
  for (;;) {
    const std::uint32_t cells = shape_.cells();
    kernels_.bin(loose_.get(), count, shape_, cells_.data());
    // After the cells, those too long, and those that are not numbers.
    starts_.assign(cells + 3, 0);
    for (std::size_t i = 0; i < count; ++i) ++starts_[cells_[i] + 1];
    const std::size_t long_ones = starts_[cells + 1];
    if (is_new || long_ones <= foreseen_ + kMoreTooLong) {
      if (is_new) foreseen_ = long_ones;
      break;
    }
    ChooseShape(count);
    is_new = true;
  }
  const std::uint32_t cells = shape_.cells();
  // starts_[c + 1] becomes where the next box of c goes, and so, once all are there, its end.
  std::uint32_t sum = 0;
  std::size_t squares = 0;
  for (std::uint32_t& start : starts_) {
    squares += std::size_t{start} * start;
    sum += std::exchange(start, sum);
  }
  mean_occupancy_ = count > 0 ? static_cast<double>(squares) / static_cast<double>(count) : 0;
  const Columns &from = loose_.get(), &to = sorted_.get();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t at = starts_[cells_[i] + 1]++;
    for (int axis = 0; axis < 3; ++axis) {
      to.lower[axis][at] = from.lower[axis][i];
      to.upper[axis][at] = from.upper[axis][i];
    }
    ids_[at] = static_cast<Id>(i);
  }
  gridded_ = starts_[cells];
  count_ = starts_[cells + 1];
}

GridRows BoxGrid::Rows() const {
  return {sorted_.get(), ids_.data(), starts_.data(), gridded_, count_};
}

void BoxGrid::Query(std::size_t begin, std::size_t end, PairSink& sink) const {
  kernels_.query(Rows(), shape_, begin, end, sink);
}

void BoxGrid::QueryOne(const FatBox& box, Id id, PairSink& sink) const {
  kernels_.query_one(Rows(), shape_, box.lower, box.upper, id, sink);
}

}  // namespace cdb::kernels
