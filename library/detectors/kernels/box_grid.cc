#include "library/detectors/kernels/box_grid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
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

}  // namespace

// The density is that of the middle of the boxes: a few that are far away must not make cells so
// large that all others share one.
void BoxGrid::ChooseShape(std::size_t count) {
  age_ = 0;
  shaped_for_ = count;
  Sample sample = Take(loose_.get(), count);
  const std::size_t n = sample.size;
  if (n == 0) {  // none that could stand in a grid
    shape_ = {.origin = {}, .inverse = {}, .last = {}, .reach = {-1, -1, -1}, .n = {1, 1, 1}};
    return;
  }
  // Where they are: most of them, and as much again on both sides, but no further than the last.
  double from[3], spread[3];
  double dense_volume = 1;  // where the middle half of each axis lies, doubled
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto x = sample.lower[axis];
    std::sort(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(n));
    const double low = x[n / 16], high = x[n - 1 - n / 16], width = high - low;
    from[axis] = std::max<double>(x[0], low - width);
    spread[axis] = std::min<double>(x[n - 1], high + width) - from[axis];
    dense_volume *= std::max(width * 8 / 7, 1e-30);
  }
  // What is too long: with each limit, the rest costs a cell's tests, those beyond a scan of all.
  const auto total = static_cast<double>(count);
  const double density = total / dense_volume;
  double best = std::numeric_limits<double>::infinity();
  float limit = 0;
  const Columns& boxes = loose_.get();
  Lengths(boxes, count).ForEachLimit([&](float length, std::size_t beyond) {
    const double share = 1 - static_cast<double>(beyond) / total;
    double volume = 1;
    for (std::size_t axis = 0; axis < 3; ++axis)
      volume *= std::min<double>(2 * length, spread[axis] + length);
    const double cost = share * (volume * density * kTestCost) + (1 - share) * total / 8;
    if (cost >= best) return;
    best = cost;
    limit = length;
  });
  float reach[3] = {};
  for (std::size_t i = 0; i < count; ++i) {
    if (!(Longest(boxes, i) <= limit)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis)
      reach[axis] = std::max(reach[axis], boxes.upper[axis][i] - boxes.lower[axis][i]);
  }
  double mean[3] = {};
  const auto kept = static_cast<double>(
      std::count_if(sample.longest.begin(), sample.longest.begin() + static_cast<std::ptrdiff_t>(n),
                    [&](float longest) { return longest <= limit; }));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < n; ++i)
      if (sample.longest[i] <= limit) mean[axis] += sample.extent[axis][i] / kept;
    // They may grow until the next shape.
    reach[axis] = reach[axis] * 1.25f + std::numeric_limits<float>::min();
  }
  // Cells as wide as costs least, the rows that are scanned against what is tested in them.
  double side[3];
  const double usual = std::max({reach[0], reach[1], reach[2]});
  best = std::numeric_limits<double>::infinity();
  for (const double width : {0.35, 0.5, 0.7, 1., 1.4, 2., 2.8, 4., 5.6, 8., 16., 32., 64.}) {
    double rows = 1, area = 1;
    double sides[3] = {};
    for (std::size_t axis = 1; axis < 3; ++axis) {
      sides[axis] = std::max(width * usual, spread[axis] / 1023);
      const double crossed = 1 + (reach[axis] + mean[axis]) / sides[axis];
      const double cells = std::min(crossed, spread[axis] / sides[axis] + 1);
      rows *= cells;
      area *= std::min(cells * sides[axis], spread[axis] + usual);
    }
    // Along x a row is cut as often as there are boxes to pay for it.
    const double columns =
        (std::floor(spread[1] / sides[1]) + 1) * (std::floor(spread[2] / sides[2]) + 1);
    if (columns > 2 * total + 64) continue;
    sides[0] = std::max({mean[0] / 4, spread[0] * columns / (2 * total + 64), spread[0] / 65535});
    const double length = std::min(reach[0] + mean[0] + sides[0], spread[0] + usual);
    const double tests = area * length * density / rows;  // in one row
    const double cost = rows * (kScanCost + kTestCost * std::ceil(tests / 8) * 8);
    if (cost < best) {
      best = cost;
      std::copy(std::begin(sides), std::end(sides), side);
    }
  }
  if (!(best < std::numeric_limits<double>::infinity()))
    for (std::size_t axis = 0; axis < 3; ++axis)
      side[axis] = std::max({usual, spread[axis] / std::cbrt(total + 64)});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double cells =
        std::clamp(std::floor(spread[axis] / std::max(side[axis], 1e-30)) + 1, 1., 65536.);
    shape_.origin[axis] = static_cast<float>(from[axis]);
    shape_.inverse[axis] = static_cast<float>(std::min(1 / std::max(side[axis], 1e-30), 1e30));
    shape_.n[axis] = static_cast<std::uint32_t>(cells);
    shape_.last[axis] = static_cast<float>(shape_.n[axis] - 1);
    shape_.reach[axis] = reach[axis];
  }
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
  crowd_ = count > 0 ? static_cast<double>(squares) / static_cast<double>(count) : 0;
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
