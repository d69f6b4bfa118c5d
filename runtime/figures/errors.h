// Errors against run times, before formatting (`cdb show --error`).
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "compiler/schema/metrics.h"
#include "runtime/figures/bootstrap.h"
#include "runtime/figures/model.h"

namespace cdb::figures {

struct ErrorOptions {
  std::string error;  ///< an array of /accuracy, for example `position`
  /// Axes that make the rows; errors and times are averaged over the others. Empty: all but seeds.
  std::vector<std::string> by;
  /// Axes with a separate table and front for each value. If neither these nor `by` are given:
  /// those whose values are different scenes.
  std::vector<std::string> each;
};

/// One configuration: all repeats, and the matched points of the axes that are not shown.
struct ErrorRow {
  Row row;
  Estimate ms_per_s;  ///< for a simulated second: the mean of a cycle over its
                      ///< time step
  double error, floor;
  Interval time_interval, error_interval;  ///< NaN if there is none
  double horizon = kNone;                  ///< the shortest
  std::string unsound;  ///< UnsoundText; a motion that is not sound has no place on a front
  bool on_front = false;
  /// Not on the front, but each row that is as fast and as accurate is so only within the
  /// intervals.
  bool is_tie = false;

  bool MayBeOnFront() const { return !row.is_void && unsound.empty(); }
  /// The error, but at least its floor: a smaller value is not better.
  double Known() const;
  /// The range of the true error: its interval, if it has one, extended by its floor on both sides.
  Interval PossibleErrors() const;
  /// Simulated seconds per second.
  double RealTimeFactor() const { return 1000 / ms_per_s.value; }
  bool IsBelowFloor() const { return error < floor; }
};

struct ErrorRows {
  std::vector<ErrorRow> rows;  ///< the fastest first, void ones last; the front is marked
  Rows matched;                ///< without its rows
};

struct ErrorFigures {
  /// A point without an error or a time, or whose run failed.
  struct LeftOut {
    Point at;
    std::string why;
  };
  std::vector<std::size_t> rows, each, seeds;  ///< axes
  /// False if the rows of a table are different scenes, none of which is better than another.
  bool has_fronts = true;
  std::size_t seed_count = 0;         ///< number of seeds in the intervals of errors
  std::map<Point, ErrorRows> tables;  ///< by the coordinates on the axes `each`
  std::vector<LeftOut> left_out;
  std::vector<LeftOut> marked;  ///< void points in the tables
};

/// The power of the time step as which an error falls, in one case: configurations of a scene that
/// differ in the time step alone.
struct ErrorOrder {
  Point scene;                    ///< on the axes `each` of the figures
  std::vector<std::size_t> axes;  ///< of the rows, without those that change the time step
  Point at;                       ///< on `axes`
  PowerFit fit;                   ///< over the sound errors above the floor
};
/// Those of at least three such errors; none for an error that needs no truth.
std::vector<ErrorOrder> OrdersOf(const Model& model, const schema::ErrorInfo& error,
                                 const ErrorFigures& figures);

/// Marks the front and its ties. Void rows are not on it. `rows`: the fastest first.
void MarkFront(std::vector<ErrorRow>& rows);

/// A point for each reason, the first one, with the number of points that have it.
std::vector<std::pair<const ErrorFigures::LeftOut*, std::size_t>> ByReason(
    const std::vector<ErrorFigures::LeftOut>& points);

/// Sentences on the reference runs that failed or are not sound.
std::vector<std::string> ReferenceTexts(const Model& model);

/// Throws StoreError, also for an error or an axis that the file does not have.
ErrorFigures CollectErrors(const Model& model, const ErrorOptions& options);

/// The figures of each error of the file, with a table for each scene. None without times.
std::vector<std::pair<const schema::ErrorInfo*, ErrorFigures>> CollectAllErrors(const Model& model);

}  // namespace cdb::figures
