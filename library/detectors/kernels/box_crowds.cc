// Crowds of a grid: a cell that holds far more boxes than most gets a nested grid, which may have
// crowds again. A box of a crowd is looked up in the nested grid, and then outside: among the boxes
// that are in no crowd, and in the crowds that follow its own.
#include <algorithm>
#include <limits>
#include <utility>

#include "library/detectors/kernels/box_grid.h"

namespace cdb::kernels {
namespace {

/// A cell with more than kCrowd boxes is a crowd. Crowds are searched for only if, on average, a
/// box shares its cell with more than kMostShared: testing fewer boxes, eight at once, costs less
/// than a nested grid.
constexpr std::uint32_t kCrowd = 512;
constexpr std::size_t kMostShared = 1024;
/// Fraction of a crowd that each of its boxes overlaps, above which a nested grid is not worth it.
constexpr double kMostShare = 0.25;
constexpr unsigned kDeepest = 8;
/// The cost of looking a box up outside its crowd, as a number of boxes in a cell.
constexpr std::size_t kOutside = 150;
constexpr double kNestCost = 5;  ///< of a box, in the unit of Arrange

}  // namespace

bool BoxGrid::IsCrowded(std::size_t squares) const {
  return depth_ < kDeepest && squares > kMostShared * boxes_;
}

/// Lists the crowds among the cells `begin` to `end`. starts_[cell + 1] is a cell's first box.
void BoxGrid::FindCrowds(std::size_t begin, std::size_t end) {
  is_split_ = true;
  if (begin == 0) crowding_ = static_cast<double>(sums_.squares) / static_cast<double>(boxes_);
  for (std::size_t cell = begin; cell < end; ++cell) {
    if (starts_[cell + 2] - starts_[cell + 1] <= kCrowd) continue;
    if (crowd_count_ == crowds_.size()) crowds_.emplace_back();
    Crowd& crowd = crowds_[crowd_count_++];
    crowd.cell = static_cast<std::uint32_t>(cell);
    crowd.size = starts_[cell + 2] - starts_[cell + 1];
    crowd.is_nested = false;
    crowd.boxes.clear();
    std::ranges::fill(crowd.least, std::numeric_limits<float>::infinity());
    std::ranges::fill(crowd.most, -std::numeric_limits<float>::infinity());
    std::ranges::fill(crowd.extents, 0.);
  }
}

BoxGrid::Crowd* BoxGrid::CrowdAt(std::uint32_t cell) {
  const std::span<Crowd> crowds = std::span(crowds_).first(crowd_count_);
  const auto at = std::ranges::lower_bound(crowds, cell, {}, &Crowd::cell);
  return at != crowds.end() && at->cell == cell ? &*at : nullptr;
}

BoxGrid::Crowd* BoxGrid::CrowdOf(Id id) {
  return crowd_of_.empty() || crowd_of_[id] == 0 ? nullptr : &crowds_[crowd_of_[id] - 1];
}

void BoxGrid::MeasureCrowds(std::size_t begin, std::size_t end) {
  const Columns& boxes = loose_.get();
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint32_t cell = cells_[i];
    if (cell >= shape_.cells() || starts_[cell + 2] - starts_[cell + 1] <= kCrowd) continue;
    Crowd& crowd = *CrowdAt(cell);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float lower = boxes.lower[axis][i];
      crowd.least[axis] = std::min(crowd.least[axis], lower);
      crowd.most[axis] = std::max(crowd.most[axis], lower);
      crowd.extents[axis] += boxes.upper[axis][i] - lower;
    }
  }
}

/// Drops the crowds whose boxes mostly overlap one another, which a finer grid does not separate.
/// False if no crowds are left.
bool BoxGrid::KeepCrowds() {
  const auto is_hopeless = [](const Crowd& crowd) {
    double share = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double spread = static_cast<double>(crowd.most[axis]) - crowd.least[axis];
      const double reach = 2 * crowd.extents[axis] / crowd.size;
      if (spread > reach) share *= reach / spread;
    }
    return share > kMostShare;
  };
  const std::span<Crowd> crowds = std::span(crowds_).first(crowd_count_);
  std::size_t kept = 0;
  for (Crowd& crowd : crowds)
    if (!is_hopeless(crowd)) std::swap(crowds[kept++], crowd);
  crowd_count_ = kept;
  return kept > 0;
}

/// Moves the boxes of crowds from their cells to the crowds.
void BoxGrid::MoveCrowds(std::size_t begin, std::size_t end) {
  if (begin == 0) crowd_of_.assign(boxes_, 0);
  const std::uint32_t cells = shape_.cells();
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint32_t cell = cells_[i];
    if (cell >= cells || starts_[cell + 2] - starts_[cell + 1] <= kCrowd) continue;
    Crowd* crowd = CrowdAt(cell);
    if (crowd == nullptr) continue;
    crowd->boxes.push_back(static_cast<std::uint32_t>(i));
    crowd_of_[i] = static_cast<std::uint32_t>(crowd - crowds_.data()) + 1;
    cells_[i] = cells + 1;
  }
}

/// False if the budget is used up before all crowds have grids.
bool BoxGrid::NestCrowds(double& budget) {
  for (; cursor_ < crowd_count_; ++cursor_) {
    Crowd& crowd = crowds_[cursor_];
    if (!crowd.is_nested) {
      if (budget <= 0) return false;
      StartNesting(crowd);
      budget -= kNestCost * crowd.size;
    }
    if (!crowd.grid->Arrange(budget)) return false;
  }
  FinishCrowds();
  return true;
}

void BoxGrid::StartNesting(Crowd& crowd) {
  if (crowd.grid == nullptr) {
    crowd.grid = std::make_unique<BoxGrid>(kernels_);
    crowd.grid->depth_ = depth_ + 1;
    crowd.grid->chooser_ = chooser_;
  }
  BoxGrid& grid = *crowd.grid;
  const Columns &from = loose_.get(), &to = grid.Room(crowd.size);
  grid.names_.resize(crowd.size);
  for (std::size_t i = 0; i < crowd.size; ++i) grid.names_[i] = NameOf(crowd.boxes[i]);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < crowd.size; ++i) {
      to.lower[axis][i] = from.lower[axis][crowd.boxes[i]];
      to.upper[axis][i] = from.upper[axis][crowd.boxes[i]];
    }
  grid.Reshape();
  grid.StartArranging(crowd.size);
  crowd.is_nested = true;
}

void BoxGrid::FinishCrowds() {
  double occupancy = mean_occupancy_ * static_cast<double>(boxes_);
  std::size_t step = count_;
  for (Crowd& crowd : std::span(crowds_).first(crowd_count_)) {
    occupancy += crowd.grid->MeanOccupancy() * crowd.size;
    crowd.inside = step;
    step += crowd.grid->Size();
  }
  for (Crowd& crowd : std::span(crowds_).first(crowd_count_)) {
    crowd.outside = step;
    step += crowd.size;
  }
  crowd_steps_ = step - count_;
  mean_occupancy_ = occupancy / static_cast<double>(std::max<std::size_t>(boxes_, 1));
}

/// Visits the crowds in whose cells there may be boxes that overlap this one. Searches the same
/// cells as the kernel query_one: boxes that grew are still in the cell that they were sorted into.
template <typename See>
void BoxGrid::ForEachCrowd(const FatBox& box, const See& see) const {
  std::uint32_t from[3], to[3];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::uint32_t own = CellOf(box.lower[axis], axis), last = shape_.n[axis] - 1;
    from[axis] = std::min(CellOf(box.lower[axis] - shape_.reach[axis], axis),
                          own - std::min(shape_.up[axis], own));
    const std::uint32_t end = CellOf(box.upper[axis], axis);
    to[axis] = end + std::min(shape_.down[axis], last - end);
  }
  const std::span<const Crowd> crowds = Crowds();
  for (std::uint32_t z = from[2]; z <= to[2]; ++z) {
    for (std::uint32_t y = from[1]; y <= to[1]; ++y) {
      const std::uint32_t row = (z * shape_.n[1] + y) * shape_.n[0];
      auto at = std::ranges::lower_bound(crowds, row + from[0], {}, &Crowd::cell);
      for (; at != crowds.end() && at->cell <= row + to[0]; ++at) see(*at);
    }
  }
}

void BoxGrid::QueryOne(const FatBox& box, Id id, PairSink& sink, bool is_ordered) const {
  kernels_.query_one(Rows(), shape_, box.lower, box.upper, id, is_ordered, sink);
  if (crowd_count_ == 0) return;
  ForEachCrowd(box, [&](const Crowd& crowd) { crowd.grid->QueryOne(box, id, sink, is_ordered); });
}

std::size_t BoxGrid::OccupancyAt(std::size_t place) const {
  if (place >= count_) {
    const std::span<const Crowd> crowds = Crowds();
    auto at = std::ranges::upper_bound(crowds, place, {}, &Crowd::inside);
    if (at == crowds.begin()) return 0;
    --at;
    const std::size_t inside = place - at->inside;
    return inside < at->grid->Size() ? at->grid->OccupancyAt(inside) : kOutside;
  }
  if (place >= gridded_) return place;
  const auto end = std::upper_bound(
      starts_.begin(), starts_.begin() + static_cast<std::ptrdiff_t>(shape_.cells()) + 1, place);
  return *end - *(end - 1);
}

/// Executes the steps of Query that follow those of the boxes in cells.
void BoxGrid::QueryCrowds(std::size_t begin, std::size_t end, PairSink& sink) const {
  const std::span<const Crowd> crowds = Crowds();
  const auto for_each = [&](std::size_t Crowd::*first, const auto& size_of, const auto& query) {
    auto at = std::ranges::upper_bound(crowds, begin, {}, first);
    if (at != crowds.begin()) --at;
    for (; at != crowds.end() && (*at).*first < end; ++at) {
      const std::size_t own = (*at).*first, size = size_of(*at);
      const std::size_t from = std::max(begin, own) - own, to = std::min(end - own, size);
      if (from < to) query(*at, from, to);
    }
  };
  for_each(
      &Crowd::inside, [](const Crowd& crowd) { return crowd.grid->Size(); },
      [&](const Crowd& crowd, std::size_t from, std::size_t to) {
        crowd.grid->Query(from, to, sink);
      });
  for_each(
      &Crowd::outside, [](const Crowd& crowd) { return std::size_t{crowd.size}; },
      [&](const Crowd& crowd, std::size_t from, std::size_t to) {
        const Columns& boxes = crowd.grid->loose_.get();
        for (std::size_t i = from; i < to; ++i) {
          FatBox box;
          for (std::size_t axis = 0; axis < 3; ++axis) {
            box.lower[axis] = boxes.lower[axis][i];
            box.upper[axis] = boxes.upper[axis][i];
          }
          const Id id = crowd.grid->NameOf(i);
          kernels_.query_one(Rows(), shape_, box.lower, box.upper, id, true, sink);
          ForEachCrowd(box, [&](const Crowd& other) {
            if (other.cell > crowd.cell) other.grid->QueryOne(box, id, sink, true);
          });
        }
      });
}

}  // namespace cdb::kernels
