// The race of a scenario (`race( )`): which of several configurations is the fastest?
// compiler/plan/race_bounds.h has its rules, runtime/figures/races/ runs it.
#pragma once

#include "compiler/plan/requirement.h"

namespace cdb::plan {

/// The race of an axis. The configurations are the combinations of the values of all axes with a
/// race. All repeats have runs in the plan; those that the race does not need are not executed.
struct Race {
  Figure by;             ///< a time, of each run by itself; the less the better
  double tolerance = 0;  ///< times whose ratio is closer to 1 need not be told apart
  bool operator==(const Race&) const = default;
};

/// The tolerance of a race that states none.
inline constexpr double kRaceTolerance = 0.01;

}  // namespace cdb::plan
