// The model behind every figure: the points of a results file, or of the selected part of it, with
// their times, counts, memory and errors, each computed once, and pooled in one way. What prints
// figures (printers/) and what concludes from them reads them here.
//
// Times in ns, memory in bytes; NaN where the file has no value. Throws StoreError. Not
// thread-safe.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/figures/detectors.h"
#include "runtime/figures/points.h"
#include "runtime/figures/times.h"
#include "runtime/results/store.h"

namespace cdb::figures {

struct ModelOptions {
  /// Leave out points whose timings are voided by their verdict.
  bool only_sound = false;
  CycleStatistic statistic = CycleStatistic::kMean;
  std::optional<std::size_t> fastest_of = {};  ///< as of CycleTimes
};

struct JudgedRequirement;

/// A point with at least one run.
struct GridPoint {
  Point at;
  Ending ending;                  ///< the worst of its repeats
  const MeasuredPoint* measured;  ///< null if no repeat has cycles

  bool IsVoid() const { return measured == nullptr || !measured->IsSound(); }
  std::string Mark() const { return measured != nullptr ? measured->Mark() : ending.Word(); }
};

class Model {
 public:
  explicit Model(const results::ResultFile& file, const ModelOptions& options = {});
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  const results::ResultFile& file() const { return file_; }
  const plan::Axis& axis(std::size_t index) const { return file_.axes()[index]; }
  bool only_sound() const { return options_.only_sound; }
  /// In grid order.
  const std::vector<MeasuredPoint>& points() const { return points_; }
  /// Null if no repeat of the point has cycles.
  const MeasuredPoint* Find(const Point& at) const;
  /// In grid order; without void points if these are left out.
  const std::vector<GridPoint>& grid() const;
  /// The index of a point in `grid()`.
  std::size_t IndexOf(const Point& at) const;
  CycleTimes& times() const { return times_; }
  const CellGroups& runs() const;
  const std::vector<DetectorFindings>& findings() const;
  /// The requirements of the scenario, judged (requirements.h).
  const std::vector<JudgedRequirement>& requirements() const;
  /// Reference runs that failed or are not sound.
  const std::vector<results::ReferenceTrouble>& reference_troubles() const;
  /// `reference drifting from 0.35 s on` if the truth that a point is compared with is not sound;
  /// else empty.
  std::string ReferenceFaultOf(const MeasuredPoint& point) const;
  /// Runs that failed or are void, references that failed, and detectors that missed pairs but are
  /// not known to.
  std::size_t bad_count() const;

  /// The same points by the 99th percentile of their cycles, which budgets are about.
  const Model& slow() const;

  bool HasTimes() const { return file_.Has("duration"); }
  /// Whether narrow phases ran on the pairs of a trace, and were timed.
  bool HasNarrowTraces() const { return HasTimes() && file_.Has("unhandled_pairs"); }
  /// The phases that have a time at some point, in order: on a trace, a few.
  std::vector<protocol::Phase> TimedPhases() const;
  const std::optional<std::size_t>& detector_axis() const { return detector_axis_; }
  /// The axes whose values are different scenes.
  const std::vector<std::size_t>& scene_axes() const;
  /// The axis of detectors, if times of several can be compared.
  std::optional<std::size_t> ComparedDetectors() const;

  // Values of a point. Repeats have the same motion, and so the same counts and errors.
  const Estimate& TimeOf(const MeasuredPoint& point, protocol::Phase phase) const {
    return times_.FigureOf(point, phase);
  }
  /// The mean of a series over the cycles.
  double CountOf(const MeasuredPoint& point, const std::string& series) const;
  /// Of a narrow phase on a trace: its time per pair that it handles.
  double NsPerPairOf(const MeasuredPoint& point) const;
  /// `peak_rss` or `heap`: the largest of the repeats.
  double MemoryOf(const MeasuredPoint& point, const std::string& name) const;
  /// `position`, `position_floor`, `horizon`.
  double ErrorOf(const MeasuredPoint& point, const std::string& name) const;
  /// The simulated time of a cycle, s.
  double TimeStepOf(const MeasuredPoint& point) const;
  /// The run time of a simulated second, ms.
  Estimate MsPerSecondOf(const MeasuredPoint& point) const;

  // Values of a row: the mean over its points, and the largest of memory.
  Estimate TimeOf(const Row& row, protocol::Phase phase) const;
  double CountOf(const Row& row, const std::string& series) const;
  double MemoryOf(const Row& row, const std::string& name) const;

 private:
  void ReadTimeSteps() const;

  const results::ResultFile& file_;
  const ModelOptions options_;
  const std::vector<MeasuredPoint> points_;
  std::map<Point, const MeasuredPoint*> by_place_;
  const std::optional<std::size_t> detector_axis_;
  // Computed on demand.
  mutable std::unique_ptr<const Model> slow_;
  mutable CycleTimes times_;
  mutable std::optional<std::vector<GridPoint>> grid_;
  mutable std::optional<std::vector<std::size_t>> scene_axes_;
  mutable std::optional<CellGroups> runs_;
  mutable std::optional<std::vector<DetectorFindings>> findings_;
  mutable std::shared_ptr<const std::vector<JudgedRequirement>> requirements_;
  mutable std::optional<std::vector<results::ReferenceTrouble>> reference_troubles_;
  mutable std::optional<std::map<std::string, double>> time_steps_;  ///< by run
};

// Figures of queries (`queries { }`): times, hits, and errors against exact answers.

/// Of one type of queries, over the cycles of some points and their repeats. NaN: not recorded.
struct QueryFigures {
  double count, hits;              ///< means of a cycle
  double time_ns, update_ns;       ///< means of a cycle: of the queries, and of cdb's own tree
  double ns_per_query;             ///< over all queries
  double compared, missed, wrong;  ///< sums; of `wrong`, false hits
  double error, normal_error;      ///< the largest; m, rad

  /// True if any such query was asked.
  bool HasQueries() const { return count > 0 || compared > 0 || time_ns > 0; }
};

/// True if some run has queries.
bool HasQueries(const results::ResultFile& file);

/// Throws StoreError.
QueryFigures QueriesOf(const results::ResultFile& file,
                       std::span<const MeasuredPoint* const> points, schema::QueryType type);

/// The mean number of events of a phase in a cycle, over points and their repeats. NaN: the machine
/// did not count them. Throws StoreError.
double CounterOf(const results::ResultFile& file, std::span<const MeasuredPoint* const> points,
                 schema::Counter counter, protocol::Phase phase);

}  // namespace cdb::figures
