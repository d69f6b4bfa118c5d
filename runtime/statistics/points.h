// The points of a results file, and which of them a table may set side by side: rows hold points of
// one kind, and all rows of a kind the same cells.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::statistics {

/// Values on the axes of a file, or on some of them.
using Point = std::vector<std::size_t>;

Point Project(const Point& at, const std::vector<std::size_t>& axes);
Point Without(Point at, std::size_t axis);

/// A point of the grid with its repeats.
struct MeasuredPoint {
  Point at;
  /// The repeats that its figures are of: the sound ones; where there are none, the void ones.
  std::vector<store::ResultFile::Cell> cells;
  std::string fault;  ///< of a void point: `frozen`, `timed_out`; else empty
  /// Visible components (schema/components.h) that it ran without, and those that it kept.
  std::vector<std::string> left_out, kept;
  /// Of `left_out`, those that other points of the file kept.
  std::vector<std::string> unlike;

  bool IsSound() const { return fault.empty(); }
  /// What sets it apart from the rest: `frozen, without solver`; empty for most.
  std::string Mark() const;
  /// Components that one of the two ran without, and the other with.
  std::vector<std::string> UnlikeComponents(const MeasuredPoint& other) const;
};

/// In grid order: each point with a repeat that has cycles. `only_sound`: without void ones.
/// Throws StoreError.
std::vector<MeasuredPoint> MeasuredPoints(const store::ResultFile& file, bool only_sound);

/// A row of a table: points that share a value on each axis of the rows, and the mark.
struct Row {
  Point at;
  std::string mark;
  bool is_void;
  std::vector<const MeasuredPoint*> points;  ///< the matched ones; not empty
  std::size_t own = 0;                       ///< points that it had before they were matched
};

struct Rows {
  std::vector<Row> rows;  ///< in grid order, void ones after sound ones
  bool pools = false;     ///< some row has, or had, several points
  bool has_marks = false;
  /// No cell is common to all rows of a kind; they have their own.
  bool is_unmatched = false;

  /// `3 of 5`: the cells that a row pools, of its own.
  static std::string CellsText(const Row& row);
  /// Lines for below a table; empty for rows of one point each.
  std::string MatchLines() const;
};
/// Rows for the axes `by`. What makes no row is pooled; a cell, a value on each of those axes, only
/// if all rows of the same mark have it. `points` must outlive the rows.
Rows MatchRows(const std::vector<const MeasuredPoint*>& points, const std::vector<std::size_t>& by);
Rows MatchRows(const std::vector<MeasuredPoint>& points, const std::vector<std::size_t>& by);

}  // namespace cdb::statistics
