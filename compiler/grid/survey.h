// Functions of scenes over a whole grid, each evaluated once for all runs that agree in the
// settings that it reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "compiler/grid/grid.h"
#include "compiler/plan/settings.h"

namespace cdb::grid {

/// A point that stands for all that agree with it.
struct Sample {
  std::size_t block = 0;
  Point local;
  std::uint64_t place = 0;   ///< its number on the grid
  std::uint64_t points = 0;  ///< that it stands for, itself included
};

/// The samples of one look at a grid.
struct Samples {
  std::vector<Sample> samples;  ///< in grid order
  bool is_whole = true;         ///< they stand for every point that has a run
};

/// Chooses the points of a grid at which a function has to be evaluated. Not for several threads.
class Survey {
 public:
  explicit Survey(const Grid& grid) : grid_(grid), cursor_(grid) {}

  /// Calls `look` for points in grid order, with the whole scene's settings, after `begin`. If
  /// `look` reads a parameter that varies along an axis that was left out, all begins again, so
  /// that in the end it has been called once for each combination that it can tell apart. If these
  /// are more than `most`, it is called for about `most` points instead, spread over the grid, and
  /// `is_whole` is false. `begin` forgets what earlier calls have found. `axes`: of which it is
  /// known that `look` reads them. Returns `is_whole`.
  bool Look(std::uint64_t most, AxisSet axes, const std::function<void(bool is_whole)>& begin,
            const std::function<void(const Sample&, const plan::Scene&)>& look);

 private:
  Samples Choose(const AxisSet& axes, std::uint64_t most) const;
  Samples Whole(const AxisSet& axes) const;
  Samples Spread(std::uint64_t most) const;
  std::uint64_t NumberOf(const Point& place) const;
  /// Axes along which something that was read varies.
  AxisSet AxesRead(const plan::ReadRecorder& recorder) const;

  const Grid& grid_;
  Cursor cursor_;
};

}  // namespace cdb::grid
