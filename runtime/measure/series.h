// The table of series: the values that a run can record in each cycle. Used by worker, store and
// `cdb show`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::measure {

enum class SeriesType { kInt32, kFloat64 };

/// A dimension of series in addition to the axes of the sweep.
enum class Dimension { kPhase, kCycle, kBody, kPose, kBoxBody, kBound, kFilter, kSample };

struct DimensionInfo {
  std::string_view name;
  std::string_view doc;                           ///< the coordinate's long_name
  std::span<const std::string_view> labels = {};  ///< empty if the extent depends on the run
  /// The unit of each label, separated by spaces; empty if the series has the same one for all.
  std::string_view units = {};
};
const DimensionInfo& InfoOf(Dimension dimension);

/// The dimensions of a series (DimensionsOf).
enum class SeriesShape {
  kScalar,  ///< a value for each cycle
  kPhase,
  kPose,
  kBox,
  kFilter,  ///< once per run
  kSample,  ///< errors, which are not part of a recording
};
std::span<const Dimension> DimensionsOf(SeriesShape shape);

/// Extents of one run, or the largest of all runs of a plan.
struct RunExtents {
  std::uint64_t cycles = 0;
  std::uint64_t objects = 0;
  std::uint64_t bodies = 0;  ///< objects, and the walls that are present
};
RunExtents ExtentsOf(const plan::Scene& scene);

struct Series {
  std::string_view name;     ///< name of the dataset
  std::string_view records;  ///< space-separated words of `record`, each of which selects the
                             ///< series
  SeriesType type = SeriesType::kFloat64;
  SeriesShape shape = SeriesShape::kScalar;
  std::string_view unit;   ///< in the notation of results files; empty if there is none
  std::string_view doc;    ///< the dataset's long_name
  bool on_traces = false;  ///< also recorded by a detector that runs on a trace

  std::size_t ItemBytes() const { return type == SeriesType::kInt32 ? 4 : 8; }
  /// The position of the cycle among its dimensions; nullopt if it has one value per run.
  std::optional<std::size_t> CycleDimension() const;
  bool HasCycles() const { return CycleDimension().has_value(); }
  /// The extent of each of its dimensions in a recording, outermost first.
  std::vector<std::uint64_t> Extents(const RunExtents& run) const;
  std::size_t ValueCount(const RunExtents& run) const;
  /// True if `scene` requests it.
  bool IsRecordedBy(const plan::Scene& scene) const;
  /// True if any run of `plan` requests it.
  bool IsRecordedBy(const plan::Plan& plan) const;
};

std::span<const Series> AllSeries();
/// Null if there is none.
const Series* FindSeries(std::string_view name);

/// The phases of a cycle, in the order of the `phase` axis. Each is timed separately, in
/// nanoseconds.
enum class Phase { kBroad, kNarrow, kDetect, kSolve, kIntegrate, kStep };
inline constexpr std::size_t kPhaseCount = 6;
/// The index of the phase on the axis `phase`.
constexpr std::size_t IndexOf(Phase phase) { return static_cast<std::size_t>(phase); }
std::span<const std::string_view> PhaseNames();

/// Labels of kPose, kBound, kFilter.
inline constexpr std::size_t kPoseSize = 7;
inline constexpr std::size_t kBoxSize = 6;
inline constexpr std::size_t kFilterSize = 3;

/// One contact point of `record contacts`, as the worker streams it. All fields are doubles, so
/// that a reader needs one type. body: index of the object, walls after the last object; point on
/// the first body's surface, m; unit normal from the second body to the first; distance, m,
/// negative if they overlap.
struct ContactRecord {
  double body_a, body_b;
  double point[3];
  double normal[3];
  double distance;
};

}  // namespace cdb::measure
