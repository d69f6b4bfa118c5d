// The runs of a benchmark as a function of their position on the grid: each setting is stored once
// for each combination of the axes that it depends on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::grid {

// The combinations of values of some axes of a grid.

/// An index on each axis of a grid.
using Point = std::vector<std::size_t>;
/// Indices of axes, ascending.
using AxisSet = std::vector<std::size_t>;

AxisSet Union(const AxisSet& a, const AxisSet& b);
AxisSet AllAxes(std::size_t count);
/// The axes with more than one value.
AxisSet WithoutConstants(const AxisSet& axes, const Point& extents);
/// A double, because the count may exceed 64 bits.
double CountOf(const Point& extents);

/// The combinations of the values on `axes`, numbered with the last axis fastest.
class Subgrid {
 public:
  Subgrid() = default;
  /// `extents`: the number of values on each axis of the whole grid.
  Subgrid(AxisSet axes, const Point& extents);

  const AxisSet& axes() const { return axes_; }
  std::uint64_t size() const { return size_; }
  /// The number of the point's combination.
  std::uint64_t IndexOf(const Point& point) const {
    std::uint64_t index = 0;
    for (std::size_t i = 0; i < axes_.size(); ++i) index += strides_[i] * point[axes_[i]];
    return index;
  }
  /// Moves the point to the combination `index`; its indices on other axes stay.
  void MoveTo(std::uint64_t index, Point& point) const;
  /// Moves the point to the next combination; false at the end, where it wraps around.
  bool Advance(Point& point) const;

 private:
  AxisSet axes_;
  std::vector<std::uint64_t> strides_;
  Point extents_;  ///< of `axes_`
  std::uint64_t size_ = 1;
};

/// A condition, as a table over the axes that it reads, or as a combination of other conditions.
struct PointCondition {
  enum class Kind { kTable, kNot, kAnd, kOr };
  Kind kind = Kind::kTable;
  Subgrid by;                ///< kTable
  std::vector<bool> values;  ///< kTable: for each combination
  std::vector<PointCondition> items;

  bool Holds(const Point& point) const;
  /// The axes it reads, including those of its items.
  AxisSet axes() const;
};

/// A setting whose value varies along some axes.
struct VaryingSetting {
  static constexpr std::size_t kWorld = static_cast<std::size_t>(-1);
  std::size_t group = kWorld;  ///< index into Scene::groups, then joints, then queries
  const schema::Parameter* parameter = nullptr;
  Subgrid by;
  std::vector<schema::Value> values = {};  ///< for each combination that has a run
  bool completes = false;                  ///< Block::complete reads it

  plan::Settings& SettingsIn(plan::Scene& scene) const;
};

/// The part of the grid with one choice of cases. A point of it has a local index on each axis of
/// the grid.
struct Block {
  std::vector<Point> places;  ///< for each axis: the grid indices of the block's values
  Point extents;              ///< their numbers
  std::vector<PointCondition> skips;
  plan::Scene base;  ///< settings that do not vary
  std::vector<VaryingSetting> varying;
  /// Sets the seeds and plug-ins that follow from the settings of a scene.
  std::function<void(plan::Scene&)> complete;
  /// Turns a scene into that of its trace, or of its configurations (IsLaid).
  std::function<void(plan::Scene&)> lay;

  bool IsSkipped(const Point& local) const;
  /// The axes read by conditions of `skip`.
  AxisSet SkipAxes() const;
  /// The axes on which the value of a parameter depends, in any group.
  AxisSet AxesOf(const schema::Parameter& parameter) const;
  /// The position on the grid.
  Point PlaceOf(const Point& local) const;
};

/// True if the settings of a scene are not yet those of its runs: it is run on a trace, or checked
/// in configurations.
bool IsLaid(const plan::Scene& configured);

/// For each combination of some axes of a block: the number of points with a run, and the first.
struct Remaining {
  Subgrid by;
  std::vector<std::uint64_t> counts;
  std::vector<std::uint64_t> firsts;  ///< numbered over the whole block
};
Remaining RemainingBy(const Block& block, const AxisSet& axes);

/// All blocks, and the data they share. Immutable after construction.
struct Grid {
  /// The plan without runs, skipped points and references.
  plan::Plan head;
  std::vector<Block> blocks;
  /// The axes of cases; the first varies slowest in the order of `blocks`.
  AxisSet case_axes;
  std::uint64_t point_count = 0;  ///< points with a run
  Point extents() const;

  std::uint64_t run_count() const { return point_count * head.repeats; }
};

/// Visits points of a grid and makes their scenes; the parts shared with the previous point are
/// reused. Not thread-safe.
class Cursor {
 public:
  explicit Cursor(const Grid& grid);

  bool HasRun(const Point& place) const;
  /// Moves to a position on the grid; false if it has no run.
  bool MoveTo(const Point& place);
  /// Moves to a point, given by its block and local indices, that has a run.
  void MoveTo(std::size_t block, const Point& local);

  std::size_t block() const { return block_; }
  const Point& local() const { return local_; }
  /// The scene as configured: a scene on a trace lacks the facts of the trace.
  const plan::Scene& configured() const { return states_[block_].scene; }
  /// The scene as it is run.
  plan::Scene MakeScene() const;

 private:
  /// The scene of a block at the last point visited in it.
  struct State {
    plan::Scene scene;
    std::vector<std::uint64_t> chosen;  ///< for each varying setting
    bool is_begun = false;
  };

  std::size_t BlockAt(const Point& place) const;
  /// False if the position has no run.
  bool FindLocal(const Point& place, Point& local) const;

  const Grid& grid_;
  std::vector<State> states_;
  std::vector<std::vector<Point>> locals_;  ///< by block and axis: the local index of each value
  std::size_t block_ = 0;
  Point local_;
};

/// Visits the points with a run, in grid order; `visit` returns false to stop.
void ForEachPoint(const Grid& grid,
                  const std::function<bool(const Cursor& cursor, const Point& place)>& visit);
/// Visits the points without a run, in grid order.
void ForEachSkipped(const Grid& grid, const std::function<void(const Point& place)>& visit);

/// A list of every run of the grid, with references; or of the first `most` points only.
plan::Plan ListRuns(const Grid& grid, std::uint64_t most = static_cast<std::uint64_t>(-1));

/// Writes the plan as YAML, in pieces; only one run at a time is in memory.
void WriteYaml(const Grid& grid, const std::function<void(std::string_view)>& write);

}  // namespace cdb::grid
