// The runs of a benchmark as a function of their place on the grid: each setting is held once for
// each combination of the axes that it depends on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/grid/subgrid.h"
#include "compiler/plan/plan.h"

namespace cdb::grid {

/// A condition as a table over the axes that it reads, or one made from others.
struct PointCondition {
  enum class Kind { kTable, kNot, kAnd, kOr };
  Kind kind = Kind::kTable;
  Subgrid by;                ///< kTable
  std::vector<bool> values;  ///< kTable: for each combination
  std::vector<PointCondition> items;

  bool Holds(const Point& point) const;
  /// Those of its items too.
  AxisSet axes() const;
};

/// A setting that has other values along some axes.
struct VaryingSetting {
  static constexpr std::size_t kWorld = static_cast<std::size_t>(-1);
  std::size_t group = kWorld;  ///< index into Scene::groups
  const schema::Parameter* parameter = nullptr;
  Subgrid by;
  std::vector<schema::Value> values = {};  ///< for each combination that has a run
  bool completes = false;                  ///< Block::complete reads it
};

/// The part of the grid that has one choice of cases. A point of it has a local index on each axis
/// of the grid.
struct Block {
  std::vector<Point> places;  ///< for each axis: its values that the block has, as grid indices
  Point extents;              ///< their numbers
  std::vector<PointCondition> skips;
  plan::Scene base;  ///< settings that never vary
  std::vector<VaryingSetting> varying;
  /// Sets the seeds and plug-ins that follow from the settings of a scene.
  std::function<void(plan::Scene&)> complete;
  /// Lays the facts of its trace over a scene that has one.
  std::function<void(plan::Scene&)> lay_trace;

  bool IsSkipped(const Point& local) const;
  /// Those that conditions of `skip` read.
  AxisSet SkipAxes() const;
  /// Axes on which the value of a parameter depends, in any group.
  AxisSet AxesOf(const schema::Parameter& parameter) const;
  /// On the grid.
  Point PlaceOf(const Point& local) const;
};

/// For each combination of some axes of a block: the points that `skip` leaves, and the first.
struct Remaining {
  Subgrid by;
  std::vector<std::uint64_t> counts;
  std::vector<std::uint64_t> firsts;  ///< numbered over the whole block
};
Remaining RemainingBy(const Block& block, const AxisSet& axes);

/// Every block, and what is the same in all. Immutable once it is made.
struct Grid {
  /// Without runs, skipped points and references.
  plan::Plan head;
  std::vector<Block> blocks;
  /// The axes of cases, the first varies slowest in the order of `blocks`.
  AxisSet case_axes;
  std::uint64_t point_count = 0;  ///< that `skip` leaves
  Point extents() const;

  std::uint64_t run_count() const { return point_count * head.repeats; }
};

/// Walks over the points of a grid and makes their scenes; what stays the same from one point to
/// the next is not made again. Not for several threads.
class Cursor {
 public:
  explicit Cursor(const Grid& grid);

  bool HasRun(const Point& place) const;
  /// Moves to a place on the grid; false where it has no run.
  bool MoveTo(const Point& place);
  /// The same by a block and a point of it that has a run.
  void MoveTo(std::size_t block, const Point& local);

  std::size_t block() const { return block_; }
  const Point& local() const { return local_; }
  /// As it was configured: a scene on a trace lacks the facts of the trace.
  const plan::Scene& configured() const { return states_[block_].scene; }
  /// As it is run.
  plan::Scene MakeScene() const;

 private:
  /// A block's scene at the point it was moved to last.
  struct State {
    plan::Scene scene;
    std::vector<std::uint64_t> chosen;  ///< for each varying setting
    bool is_begun = false;
  };

  std::size_t BlockAt(const Point& place) const;
  /// False where the place has no run.
  bool FindLocal(const Point& place, Point& local) const;

  const Grid& grid_;
  std::vector<State> states_;
  std::vector<std::vector<Point>> locals_;  ///< by block and axis: the local index of each value
  std::size_t block_ = 0;
  Point local_;
};

/// Visits the points that have a run, in grid order; `visit` returns false to stop.
void ForEachPoint(const Grid& grid,
                  const std::function<bool(const Cursor& cursor, const Point& place)>& visit);
/// The points that have none, in grid order.
void ForEachSkipped(const Grid& grid, const std::function<void(const Point& place)>& visit);

/// Every run of the grid in a list, with references; or only the first `most` points.
plan::Plan ListRuns(const Grid& grid, std::uint64_t most = static_cast<std::uint64_t>(-1));

/// The plan as YAML, in pieces; one run at a time is in memory.
void WriteYaml(const Grid& grid, const std::function<void(std::string_view)>& write);

}  // namespace cdb::grid
