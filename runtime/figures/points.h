// The points of a results file: each point of the grid with its repeats, how they ended, its
// verdict and its mark.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/protocol/verdict.h"
#include "runtime/results/store.h"

namespace cdb::figures {

using Cell = results::ResultFile::Cell;
/// Indices of values on the axes of a file, or on some of them.
using Point = std::vector<std::size_t>;

Point Project(const Point& at, const std::vector<std::size_t>& axes);
Point Without(Point at, std::size_t axis);

/// In grid order, also those that were skipped.
std::vector<Point> AllPoints(const results::ResultFile& file);
/// In grid order, repeats innermost.
std::vector<Cell> AllCells(const results::ResultFile& file);
/// The cells of a point that were run; one that was skipped or is missing was not.
std::vector<Cell> CellsThatRan(const results::ResultFile& file, const Point& at);

/// `quantity 10, detector dbvt, rep 0`.
std::string PlaceText(const results::ResultFile& file, const Cell& cell);
/// `hz 240, iterations 20`: the values on the axes `axes`, at the point `at` on them.
std::string PlaceText(const results::ResultFile& file, const std::vector<std::size_t>& axes,
                      const Point& at);
/// A shell command that runs only this cell: `cdb run crowd.cdb -b crowd --only 0123…`.
std::string OnlyCommand(const results::ResultFile& file, const Cell& cell);

/// The axis of detectors; nullopt if the file does not sweep them.
std::optional<std::size_t> DetectorAxis(const results::ResultFile& file);
/// The axes whose values are different scenes, which must not share a front: parameters of objects
/// and of the world, and a `let` or `cases` on which these depend. Throws StoreError.
std::vector<std::size_t> SceneAxes(const results::ResultFile& file);
/// The index of an axis. Throws StoreError that names the axes of the file.
std::size_t FindAxis(const results::ResultFile& file, const std::string& name);
std::vector<std::size_t> AllAxes(const results::ResultFile& file);

/// How a run ended, or the worst ending of several.
struct Ending {
  results::Status status = results::Status::kMissing;
  protocol::Judgement judgement;

  /// A worse ending has a larger rank: -1 for no run, then the verdicts, then a run that did not
  /// end well and has none.
  int Rank() const;
  /// The verdict of a run that is done, else its status (`failed`).
  std::string Word() const;
  /// True if the run was judged, or did not end well.
  bool IsKnown() const;
};
Ending EndingOf(const results::ResultFile& file, const Cell& cell);
/// The worst of the repeats that were run, with the earliest bad cycle of those that ended so. If
/// none was run: missing or skipped. Throws StoreError.
Ending WorstEnding(const results::ResultFile& file, const Point& at);
/// `one` or `other`, by the same rule.
Ending WorseOf(const Ending& one, const Ending& other);

/// True if the machine was noisy in the run (protocol/machine/noise.h).
bool IsNoisy(const results::ResultFile& file, const Cell& cell);
std::size_t CountNoisy(const results::ResultFile& file, const std::vector<Cell>& cells);

/// The reason why the figures of a cell that was not skipped do not count; nullopt if they do.
std::optional<std::string> Trouble(const results::ResultFile& file, const Cell& cell);

/// A point of the grid with the repeats that have cycles.
struct MeasuredPoint {
  Point at;
  /// The repeats used for its figures: the sound ones, or the void ones if there are none.
  std::vector<Cell> cells;
  std::string fault;  ///< for a void point its worst ending, `frozen`,
                      ///< `timed_out`; else empty
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
std::vector<MeasuredPoint> MeasuredPoints(const results::ResultFile& file, bool only_sound);

/// Cells by the endings of their runs.
struct CellGroups {
  struct Bad {
    Cell cell;
    std::string why;
  };
  struct Judged {
    Cell cell;
    std::int64_t first_bad_cycle;
  };
  std::vector<Cell> good;
  std::vector<Bad> bad;                                       ///< failed, or with void timings
  std::map<protocol::Verdict, std::vector<Judged>> verdicts;  ///< of the sound ones
  std::size_t skipped = 0, missing = 0;

  std::size_t NotSkipped() const { return good.size() + bad.size() + missing; }
};
CellGroups GroupCells(const results::ResultFile& file);

/// The plan of the results, with the measured runs that are selected; nullopt if it belongs to
/// another version of cdb, whose results are shown as far as possible. A large plan takes seconds
/// to read, so each thread keeps the last one. Throws StoreError.
std::optional<plan::Plan> ReadPlan(const results::ResultFile& file);

/// True if the times in the file are numbers of instructions.
bool CountsInstructions(const results::ResultFile& file);
/// True if the times in the file include those of reading the counters of `record counters`; they
/// are not compared with times that do not.
bool HasCounters(const results::ResultFile& file);
/// A line that says what results without these numbers leave out. `name`: of the file.
std::string CountsText(const std::string& name);
/// Throws StoreError if they are: for what states times. `name`: of the file.
void RequireTimes(const results::ResultFile& file, const std::string& name);

/// The detector of each cell. Without an axis of detectors it is taken from the plan, which is read
/// once; if the plan cannot be read, there are no names. Throws StoreError.
class CellDetectors {
 public:
  explicit CellDetectors(const results::ResultFile& file);
  /// Empty if it is unknown.
  std::string Of(const Cell& cell) const;

 private:
  const results::ResultFile& file_;
  const std::optional<std::size_t> axis_;
  std::map<std::string, std::string> by_run_;
};

// Rows of a table: points that share their values on some axes, pooled over the others, and matched
// so that all rows of a kind are over the same cells.

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

// Values of an axis as the user writes them: `detector=dbvt`, `hz=60,120`, `quantity=10..100`
// (`--select` of `cdb show`, `cdb compare` and `cdb view`); and a part of a results file by such
// values.

/// `axis=text`.
struct AxisSelection {
  std::string axis, text;
};
/// Throws files::StoreError for a word of another form.
AxisSelection ParseSelection(const std::string& word);

struct NamedValues {
  std::vector<std::size_t> indices;  ///< ascending
  std::vector<std::string> unknown;  ///< parts of the text that match no value of the axis
};
/// The text is a value, several values separated by commas, or, on an axis of numbers, `a..b`
/// including both ends. A number is written as its label or in full. If neither matches, it denotes
/// the nearest value within 1e-4 of its size, because tables show four digits.
NamedValues FindValues(const plan::Axis& axis, const std::string& text);

/// The labels of the values at `indices`, or of all: `1, 2, 5`.
std::string ValuesText(const plan::Axis& axis, const std::vector<std::size_t>& indices);
std::string ValuesText(const plan::Axis& axis);

/// Each of `selections` is `axis=value`, `axis=a,b` or `axis=a..b` (FindValues). Throws
/// StoreError that names the axes of the file, or the values of the axis.
void SelectPart(results::ResultFile& file, const std::vector<std::string>& selections);

}  // namespace cdb::figures
