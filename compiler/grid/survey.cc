#include "compiler/grid/survey.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "compiler/schema/schema.h"

namespace cdb::grid {
namespace {

/// Numbers below `size`, spread evenly for every stride by the additive sequence of the golden
/// ratio, and both ends.
std::vector<std::uint64_t> SpreadNumbers(std::uint64_t size, std::uint64_t count) {
  constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15;  // 2^64 divided by the golden ratio
  std::vector<std::uint64_t> numbers = {0, size - 1};
  std::uint64_t at = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    at += kGolden;
    __extension__ using Wide = unsigned __int128;
    numbers.push_back(static_cast<std::uint64_t>(Wide{at} * size >> 64));
  }
  return numbers;
}

/// The corners of the grid, where problems are most likely.
std::vector<Point> CornersOf(const Point& extents, std::size_t most) {
  std::vector<Point> corners = {Point(extents.size(), 0)};
  for (std::size_t axis = 0; axis < extents.size(); ++axis) {
    if (extents[axis] == 1 || 2 * corners.size() > most) continue;
    const std::size_t before = corners.size();
    for (std::size_t i = 0; i < before; ++i) {
      corners.push_back(corners[i]);
      corners.back()[axis] = extents[axis] - 1;
    }
  }
  return corners;
}

}  // namespace

std::uint64_t Survey::NumberOf(const Point& place) const {
  const Point extents = grid_.extents();
  return Subgrid(AllAxes(extents.size()), extents).IndexOf(place);
}

Samples Survey::Whole(const AxisSet& axes) const {
  Samples all;
  for (std::size_t b = 0; b < grid_.blocks.size(); ++b) {
    const Block& block = grid_.blocks[b];
    const Remaining remaining = RemainingBy(block, axes);
    const Subgrid whole(AllAxes(block.extents.size()), block.extents);
    for (std::size_t i = 0; i < remaining.counts.size(); ++i) {
      if (remaining.counts[i] == 0) continue;
      Point local(block.extents.size(), 0);
      whole.MoveTo(remaining.firsts[i], local);
      const std::uint64_t place = NumberOf(block.PlaceOf(local));
      all.samples.push_back({b, std::move(local), place, remaining.counts[i]});
    }
  }
  std::ranges::sort(all.samples, {}, &Sample::place);
  return all;
}

Samples Survey::Spread(std::uint64_t most) const {
  Samples some;
  some.is_whole = false;
  const std::uint64_t each = std::max<std::uint64_t>(1, most / grid_.blocks.size());
  for (std::size_t b = 0; b < grid_.blocks.size(); ++b) {
    const Block& block = grid_.blocks[b];
    const Subgrid whole(AllAxes(block.extents.size()), block.extents);
    std::vector<Point> points = CornersOf(block.extents, each);
    for (const std::uint64_t number : SpreadNumbers(whole.size(), each)) {
      points.emplace_back(block.extents.size(), 0);
      whole.MoveTo(number, points.back());
    }
    for (Point& local : points) {
      if (block.IsSkipped(local)) continue;
      const std::uint64_t place = NumberOf(block.PlaceOf(local));
      some.samples.push_back({b, std::move(local), place, 1});
    }
  }
  std::ranges::sort(some.samples, {}, &Sample::place);
  const auto again = std::ranges::unique(some.samples, {}, &Sample::place);
  some.samples.erase(again.begin(), again.end());
  return some;
}

Samples Survey::Choose(const AxisSet& axes, std::uint64_t most) const {
  double count = 0;
  for (const Block& block : grid_.blocks)
    count += static_cast<double>(Subgrid(axes, block.extents).size());
  return count <= static_cast<double>(most) ? Whole(axes) : Spread(most);
}

AxisSet Survey::AxesRead(const plan::ReadRecorder& recorder) const {
  AxisSet axes;
  for (const Block& block : grid_.blocks)
    for (const VaryingSetting& setting : block.varying)
      if (recorder.HasRead(*setting.parameter)) axes = Union(axes, setting.by.axes());
  return axes;
}

bool Survey::Look(std::uint64_t most, AxisSet axes, const std::function<void(bool is_whole)>& begin,
                  const std::function<void(const Sample&, const plan::Scene&)>& look) {
  const plan::ReadRecorder recorder;
  for (;;) {
    const Samples samples = Choose(axes, most);
    begin(samples.is_whole);
    std::size_t known = 0;
    bool is_missing = false;
    for (const Sample& sample : samples.samples) {
      {
        const plan::ReadRecorder ignored;
        cursor_.MoveTo(sample.block, sample.local);
      }
      look(sample, cursor_.configured());
      if (std::exchange(known, recorder.count()) == recorder.count() || !samples.is_whole) continue;
      AxisSet read = Union(axes, AxesRead(recorder));
      is_missing = read != axes;
      axes = std::move(read);
      if (is_missing) break;
    }
    if (!is_missing) return samples.is_whole;
  }
}

}  // namespace cdb::grid
