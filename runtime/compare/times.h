// The run times of two results files: the statistic of cycle_times.h at each matched point, in each
// phase, and the ratio b / a of it (`cdb compare`).
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/compare/match.h"
#include "runtime/compare/statistics.h"
#include "runtime/measure/series.h"

namespace cdb::compare {

/// A test and what follows from it.
struct JudgedChange {
  TestedChange tested;
  double adjusted_p = terminal::kNone;
  ChangeVerdict verdict = ChangeVerdict::kCannotTell;
  /// Slower, and the whole interval by more than `margin`.
  bool IsSlowerThan(double margin) const {
    return verdict == ChangeVerdict::kSlower && tested.interval.low > 1 + margin;
  }
};

/// One phase, of a point or a group.
struct TimeChange {
  measure::Phase phase;
  double a_ns, b_ns;  ///< of a group: geometric means over its points
  Change change;
  JudgedChange absolute;
  /// Over the median of all groups in this phase, which a change of the machine or of common code
  /// moves; a ratio of NaN where there are fewer than kLeastGroups.
  JudgedChange relative;
};

struct TimedPoint {
  std::size_t point;  ///< of the match
  std::vector<TimeChange> phases;
};

/// Points with the same detector, or the same value on the axis PointMatch::group.
struct TimedGroup {
  std::string name;
  std::size_t points = 0;
  std::vector<TimeChange> phases;
};

struct TimeComparison {
  /// A median of fewer groups would follow one that changed.
  static constexpr std::size_t kLeastGroups = 3;

  bool has_intervals = false;  ///< both files have enough repeats
  std::vector<TimedPoint> points;
  std::vector<TimedGroup> groups;
  /// The median of the groups in `common_phase`.
  std::optional<TestedChange> common;
  measure::Phase common_phase = measure::Phase::kStep;
  /// cdb's own overhead of a cycle, which no detector changes.
  std::optional<TestedChange> harness;
  /// Points whose times are not compared, and why.
  std::vector<std::pair<std::size_t, std::string>> left_out;

  /// All groups moved together.
  bool HasCommonShift() const { return common && common->p <= kSignificance; }
};

/// `phase`: that alone; by default all. Not judged yet.
TimeComparison CompareTimes(const ComparedFile& a, const ComparedFile& b, const PointMatch& match,
                            std::optional<measure::Phase> phase);

/// Corrects for all tests of `comparisons` together, and judges: groups by Holm, points by
/// Benjamini and Hochberg. `margin`: as of JudgeChange.
void JudgeTimes(const std::vector<TimeComparison*>& comparisons, double margin);

}  // namespace cdb::compare
