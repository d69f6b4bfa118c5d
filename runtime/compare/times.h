// The run times of two results files: the statistic of runtime/figures/times.h at each matched
// point and in each phase, and its ratio b / a (`cdb compare`).
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/compare/match.h"
#include "runtime/compare/statistics.h"
#include "runtime/measure/series.h"

namespace cdb::compare {

/// A test and its verdict.
struct JudgedChange {
  TestedChange tested;
  double adjusted_p = figures::kNone;
  ChangeVerdict verdict = ChangeVerdict::kCannotTell;
  /// True if it is slower, and the whole interval is above `margin`.
  bool IsSlowerThan(double margin) const {
    return verdict == ChangeVerdict::kSlower && tested.interval.low > 1 + margin;
  }
};

/// The times of one phase, at a point or of a group.
struct TimeChange {
  measure::Phase phase;
  double a_ns, b_ns;  ///< for a group, geometric means over its points
  Change change;
  JudgedChange absolute;
  /// Relative to the median of all groups in this phase, which follows changes of the machine or of
  /// common code; the ratio is NaN if there are fewer than kLeastGroups groups.
  JudgedChange relative;
};

struct TimedPoint {
  std::size_t point;  ///< index in the match
  std::vector<TimeChange> phases;
};

/// Points with the same detector, or the same value on the axis PointMatch::group.
struct TimedGroup {
  std::string name;
  std::size_t points = 0;
  std::vector<TimeChange> phases;
};

struct TimeComparison {
  /// The median of fewer groups would follow a single group that changed.
  static constexpr std::size_t kLeastGroups = 3;

  bool has_intervals = false;  ///< both files have enough repeats
  std::vector<TimedPoint> points;
  std::vector<TimedGroup> groups;
  /// The median of all groups in `common_phase`.
  std::optional<TestedChange> common;
  measure::Phase common_phase = measure::Phase::kStep;
  /// cdb's own overhead per cycle, which does not depend on the detector.
  std::optional<TestedChange> harness;
  /// Points whose times are not compared, with the reason.
  std::vector<std::pair<std::size_t, std::string>> left_out;

  /// True if all groups changed together.
  bool HasCommonShift() const { return common && common->p <= kSignificance; }
};

/// `phase`: only that phase; all by default. The changes are not judged yet.
TimeComparison CompareTimes(const ComparedFile& a, const ComparedFile& b, const PointMatch& match,
                            std::optional<measure::Phase> phase);

/// Judges groups by Holm and points by Benjamini and Hochberg, corrected for all tests of
/// `comparisons` together. `margin`: as for JudgeChange.
void JudgeTimes(const std::vector<TimeComparison*>& comparisons, double margin);

}  // namespace cdb::compare
