// Remembers which objects blocked earlier draws, by position.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "library/objects/solid.h"

namespace cdb::layouts {

inline constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();

/// The last object that blocked a draw in each cell of a fine grid, so that most failed draws test
/// only one object. It may forget or be wrong: it only determines which object is tested first. Not
/// thread-safe.
class Hints {
 public:
  Hints(double side, std::size_t objects) : half_side_(side / 2) {
    const double along =
        std::clamp(std::floor(2 * std::cbrt(static_cast<double>(objects))), 1.0, double{kMaxAlong});
    along_ = static_cast<std::size_t>(along);
    per_metre_ = along / side;
    ids_.assign(along_ * along_ * along_, kNobody);
  }

  std::uint32_t At(const Eigen::Vector3d& place) const {
    return ids_[(Cell(place.x()) * along_ + Cell(place.y())) * along_ + Cell(place.z())];
  }

  void Set(const objects::Box& box, std::uint32_t id) {
    for (std::size_t x = Cell(box.lower.x()); x <= Cell(box.upper.x()); ++x)
      for (std::size_t y = Cell(box.lower.y()); y <= Cell(box.upper.y()); ++y)
        for (std::size_t z = Cell(box.lower.z()); z <= Cell(box.upper.z()); ++z)
          ids_[(x * along_ + y) * along_ + z] = id;
  }

 private:
  static constexpr std::size_t kMaxAlong = 512;  ///< 0.5 GB
  std::size_t Cell(double coordinate) const {
    const double cell = (coordinate + half_side_) * per_metre_;
    if (!(cell > 0)) return 0;
    return std::min(static_cast<std::size_t>(cell), along_ - 1);
  }

  double half_side_, per_metre_;
  std::size_t along_;
  std::vector<std::uint32_t> ids_;
};

}  // namespace cdb::layouts
