// A race among configurations, by the rules of compiler/plan/race_bounds.h: who is dropped when,
// and which repeats to run next. Pure functions of the times that there are, so that a race resumes
// wherever it was stopped, and comes to the same decisions. Threads: any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "compiler/plan/race_bounds.h"
#include "runtime/figures/bootstrap.h"

namespace cdb::races {

/// `flag_values` of the array `race/outcome`, in this order.
enum class Outcome : std::int8_t {
  kNotKnown,  ///< no configuration of a race, or runs are missing
  kWon,       ///< the others were dropped
  kDropped,   ///< surely slower than the one it was compared with
  kTied,      ///< as fast as the leader, within the tolerance
  kOpen,      ///< too close to call with all repeats
  kFailed,    ///< a run failed, or its times are void
};

/// How one configuration did.
struct Standing {
  Outcome outcome = Outcome::kNotKnown;
  std::uint64_t repeats = 0;  ///< by which that was decided
  std::size_t against = 0;    ///< the configuration with which it is compared
  /// The median, over the repeats of both, of its time divided by that of `against`; and bounds of
  /// it, each of which holds for all configurations compared with the fastest one with a
  /// probability of 1 - plan::kRaceError. NaN if there are too few repeats.
  double ratio = figures::kNone;
  figures::Interval bounds = {figures::kNone, figures::kNone};
};

/// A repeat of a configuration.
using Repeat = std::pair<std::size_t, std::uint64_t>;

struct Race {
  std::vector<Standing> standings;  ///< of each configuration
  std::size_t leader = 0;           ///< the winner; or the fastest one so far, by the median
  std::vector<Repeat> next;         ///< to be run next; empty once the race has ended

  bool HasEnded() const { return next.empty(); }
};

/// A repeat that was not run is NaN; one that failed is infinite.
using Times = std::vector<std::vector<double>>;

/// `times[c][r]`: of configuration c in repeat r; all have as many repeats as the race may take.
///
/// First, one repeat of all is run, and those that fail are out; then as many as it takes until one
/// can be dropped. From there on the repeats grow by an eighth a round, and by no fewer than it
/// takes to drop another one. The race ends when one is left, when all that are left are within the
/// tolerance of the leader, or when there are no more repeats.
/// `bounds`: for as many repeats, and no fewer configurations.
Race RunRace(const Times& times, const plan::RaceBounds& bounds, double tolerance);

}  // namespace cdb::races
