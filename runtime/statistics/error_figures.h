// Errors against run times, before they are formatted (`cdb show --error`).
#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::statistics {

struct ErrorOptions {
  std::string error;  ///< an array of /accuracy: `position`
  /// Axes that make the rows; over the others errors and times are averaged. Empty: all but seeds.
  std::vector<std::string> by;
  /// Axes each value of which has a table and a front of its own: other scenes than the rest.
  std::vector<std::string> each;
  /// Without runs whose timings a verdict voids.
  bool only_sound = false;
};

/// One configuration: its repeats together, and the matched points of the axes that are not shown.
struct ErrorRow {
  Row row;
  Estimate ms_per_s;  ///< of a simulated second: the mean of a cycle over its time step
  double error, floor;
  Interval time_interval, error_interval;                     ///< NaN where there is none
  double horizon = std::numeric_limits<double>::quiet_NaN();  ///< the shortest
  bool on_front = false;
  /// Off the front, and each row that is as fast and as accurate is so within the intervals.
  bool is_tie = false;

  /// What is known of the error: a smaller one than its floor is not better.
  double Known() const;
  /// Where the error may lie: its interval, if it has one, and its floor to both sides.
  Interval PossibleErrors() const;
  /// Simulated seconds in a second.
  double RealTimeFactor() const { return 1000 / ms_per_s.value; }
  bool IsBelowFloor() const { return error < floor; }
};

struct ErrorRows {
  std::vector<ErrorRow> rows;  ///< the fastest first, void ones last; the front is marked
  Rows matched;                ///< without its rows
};

struct ErrorFigures {
  /// A point without an error or a time, or whose run did not end well.
  struct LeftOut {
    Point at;
    std::string why;
  };
  std::vector<MeasuredPoint> points;           ///< that the rows are of
  std::vector<std::size_t> rows, each, seeds;  ///< axes
  std::size_t seed_count = 0;                  ///< that intervals of errors are of
  std::map<Point, ErrorRows> tables;           ///< by the point on the axes `each`
  std::vector<LeftOut> left_out;
  std::vector<LeftOut> marked;  ///< void points in the tables
  std::size_t bad_cells = 0;
};

/// Marks the front, and what ties with it. Void rows are not on it. `rows`: the fastest first.
void MarkFront(std::vector<ErrorRow>& rows);

/// Throws StoreError, also for an error or an axis that the file has not got.
ErrorFigures CollectErrors(const store::ResultFile& file, const ErrorOptions& options,
                           CycleTimes& times);

}  // namespace cdb::statistics
