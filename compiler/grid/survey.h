// Evaluates functions of scenes over a whole grid, once for all runs that agree in the settings
// read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "compiler/grid/grid.h"
#include "compiler/plan/settings.h"

namespace cdb::grid {

/// A point that represents all points that agree with it.
struct Sample {
  std::size_t block = 0;
  Point local;
  std::uint64_t place = 0;   ///< its number on the grid
  std::uint64_t points = 0;  ///< the number of points that it represents, including itself
};

/// The samples of one pass over a grid.
struct Samples {
  std::vector<Sample> samples;  ///< in grid order
  bool is_whole = true;         ///< they represent every point with a run
};

/// Chooses the points of a grid at which a function must be evaluated. Not thread-safe.
class Survey {
 public:
  explicit Survey(const Grid& grid) : grid_(grid), cursor_(grid) {}

  /// Calls `begin`, then `look` for points in grid order with all settings of their scenes. If
  /// `look` reads a parameter that varies along an axis not yet included, everything starts again,
  /// so that it is finally called once for each combination that it can distinguish. If there are
  /// more than `most` combinations, it is called for about `most` points spread over the grid
  /// instead, and `is_whole` is false. `begin` must discard earlier findings. `axes`: axes that
  /// `look` is known to read. Returns `is_whole`.
  bool Look(std::uint64_t most, AxisSet axes, const std::function<void(bool is_whole)>& begin,
            const std::function<void(const Sample&, const plan::Scene&)>& look);

 private:
  Samples Choose(const AxisSet& axes, std::uint64_t most) const;
  Samples Whole(const AxisSet& axes) const;
  Samples Spread(std::uint64_t most) const;
  std::uint64_t NumberOf(const Point& place) const;
  /// The axes along which a parameter that was read varies.
  AxisSet AxesRead(const plan::ReadRecorder& recorder) const;

  const Grid& grid_;
  Cursor cursor_;
};

}  // namespace cdb::grid
