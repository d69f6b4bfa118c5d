// Rows of a table: points that share their values on some axes, pooled over the others, and matched
// so that all rows of a kind are over the same cells.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/figures/points.h"

namespace cdb::figures {

/// Points that share a value on each axis of the rows, and the mark.
struct Row {
  Point at;
  std::string mark;
  bool is_void;
  std::vector<const MeasuredPoint*> points;  ///< the matched points; not empty
  std::size_t own = 0;                       ///< number of points before matching

  /// `3 of 5`: the number of pooled cells, out of all its cells.
  std::string CellsText() const;
};

struct Rows {
  std::vector<std::size_t> by;  ///< the axes that make the rows
  std::vector<Row> rows;        ///< in grid order, void ones after sound ones
  bool pools = false;           ///< some row has, or had, several points
  /// No cell is common to all rows of a kind, so the rows are not matched.
  bool is_unmatched = false;

  /// Sentences for below a table; none for rows of one point each.
  std::vector<std::string> MatchNotes() const;
};
/// Rows for the axes `by`. Axes that make no rows are pooled; a cell is pooled only if all rows of
/// the same mark have it. `points` must outlive the rows.
Rows MatchRows(const std::vector<const MeasuredPoint*>& points, std::vector<std::size_t> by);
Rows MatchRows(const std::vector<MeasuredPoint>& points, std::vector<std::size_t> by);

}  // namespace cdb::figures
