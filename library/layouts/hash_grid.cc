#include "library/layouts/hash_grid.h"

#include <algorithm>
#include <bit>

#include "dsl/text/check.h"

namespace cdb::layouts {

HashGrid::HashGrid(std::size_t boxes) : heads_(std::bit_ceil(2 * boxes + 1), kNone) {
  entries_.reserve(boxes);
}

std::int64_t HashGrid::Cell(double coordinate) {
  // All cells beyond this share one, so that differences do not overflow.
  constexpr double kFar = 0x1p60;
  return static_cast<std::int64_t>(std::floor(std::clamp(coordinate, -kFar, kFar)));
}

std::size_t HashGrid::Bucket(int level, std::int64_t x, std::int64_t y, std::int64_t z) const {
  // Neighbours along x stay neighbours in memory; rows, planes and levels are scattered.
  std::uint64_t row = static_cast<std::uint64_t>(y) * 0x9e3779b97f4a7c15 +
                      static_cast<std::uint64_t>(z) * 0xc2b2ae3d27d4eb4f +
                      static_cast<std::uint64_t>(level) * 0x165667b19e3779f9;
  row ^= row >> 32;
  return (row + static_cast<std::uint64_t>(x)) & (heads_.size() - 1);
}

void HashGrid::Add(std::uint32_t id, int level, const objects::Box& box) {
  if (levels_.empty() || levels_.back() != level) {
    CDB_CHECK(levels_.empty() || levels_.back() > level);
    levels_.push_back(level);
  }
  const Eigen::Vector3d centre = (box.lower + box.upper) / (2 * std::ldexp(1.0, level));
  std::uint32_t& head = heads_[Bucket(level, Cell(centre.x()), Cell(centre.y()), Cell(centre.z()))];
  entries_.push_back({id, head});
  head = static_cast<std::uint32_t>(entries_.size() - 1);
}

}  // namespace cdb::layouts
