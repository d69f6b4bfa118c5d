// The points of a results file, matched for tables: rows hold points of one kind, and all rows of a
// kind have the same cells.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::statistics {

/// Indices of values on the axes of a file, or on some of them.
using Point = std::vector<std::size_t>;

Point Project(const Point& at, const std::vector<std::size_t>& axes);
Point Without(Point at, std::size_t axis);

/// A point of the grid with its repeats.
struct MeasuredPoint {
  Point at;
  /// The repeats used for its figures: the sound ones, or the void ones if there are none.
  std::vector<store::ResultFile::Cell> cells;
  std::string fault;  ///< for a void point: `frozen`, `timed_out`; else empty
  /// Visible components (schema/components.h) that it omitted, and those that it kept.
  std::vector<std::string> left_out, kept;
  /// Those of `left_out` that other points of the file kept.
  std::vector<std::string> unlike;

  bool IsSound() const { return fault.empty(); }
  /// A remark that distinguishes it from the rest: `frozen, without solver`; empty for most.
  std::string Mark() const;
  /// Components that one of the two omitted and the other kept.
  std::vector<std::string> UnlikeComponents(const MeasuredPoint& other) const;
};

/// In grid order: each point with a repeat that has cycles. `only_sound`: without void points.
/// Throws StoreError.
std::vector<MeasuredPoint> MeasuredPoints(const store::ResultFile& file, bool only_sound);

/// A row of a table: points that share a value on each axis of the rows, and the mark.
struct Row {
  Point at;
  std::string mark;
  bool is_void;
  std::vector<const MeasuredPoint*> points;  ///< the matched points; not empty
  std::size_t own = 0;                       ///< number of points before matching
};

struct Rows {
  std::vector<Row> rows;  ///< in grid order, void ones after sound ones
  bool pools = false;     ///< some row has, or had, several points
  bool has_marks = false;
  /// No cell is common to all rows of a kind, so the rows are not matched.
  bool is_unmatched = false;

  /// `3 of 5`: the number of pooled cells of a row, out of all its cells.
  static std::string CellsText(const Row& row);
  /// Lines for below a table; empty for rows of one point each.
  std::string MatchLines() const;
};
/// Rows for the axes `by`. Axes that make no rows are pooled; a cell is pooled only if all rows of
/// the same mark have it. `points` must outlive the rows.
Rows MatchRows(const std::vector<const MeasuredPoint*>& points, const std::vector<std::size_t>& by);
Rows MatchRows(const std::vector<MeasuredPoint>& points, const std::vector<std::size_t>& by);

}  // namespace cdb::statistics
