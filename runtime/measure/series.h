// The table of series: everything that a run can record in each cycle. Read by worker, store and
// `cdb show`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "compiler/plan/plan.h"

namespace cdb::measure {

enum class SeriesType { kInt32, kFloat64 };

/// The dimension a series has beside the cycle.
enum class SeriesShape {
  kScalar,  ///< [cycle]
  kPhase,   ///< [phase, cycle]
  kPose,    ///< [cycle, body, pose]: x y z qx qy qz qw
  kBox,     ///< [cycle, box_body, bound]: lower x y z, upper x y z
  kFilter,  ///< [box_body, filter]: group, mask, fixed; once a run
  kSample,  ///< [sample]; errors, of which a run's recording knows nothing
};

struct Series {
  std::string_view name;     ///< the dataset
  std::string_view records;  ///< space-separated words of `record`, any of which asks for it
  SeriesType type = SeriesType::kFloat64;
  SeriesShape shape = SeriesShape::kScalar;
  std::string_view unit;   ///< as results files write it; empty where it has none
  std::string_view doc;    ///< the dataset's long_name
  bool on_traces = false;  ///< a detector that is run on a trace has it too

  std::size_t ItemBytes() const { return type == SeriesType::kInt32 ? 4 : 8; }
  bool HasCycles() const { return shape != SeriesShape::kFilter && shape != SeriesShape::kSample; }
  /// Values of one run of so many cycles and objects; `bodies`: with the walls that stand.
  std::size_t ValueCount(std::uint64_t cycles, std::uint64_t objects, std::uint64_t bodies) const;
  /// `scene` asks for it.
  bool IsRecordedBy(const plan::Scene& scene) const;
  /// Any run of `plan` asks for it.
  bool IsRecordedBy(const plan::Plan& plan) const;
};

std::span<const Series> AllSeries();
/// Null where there is none.
const Series* FindSeries(std::string_view name);

/// The phases of a cycle, in the order of the `phase` axis. Each is stamped by itself, in
/// nanoseconds.
enum class Phase { kBroad, kNarrow, kDetect, kSolve, kIntegrate, kStep };
inline constexpr std::size_t kPhaseCount = 6;
/// The phase's place on the axis `phase`.
constexpr std::size_t IndexOf(Phase phase) { return static_cast<std::size_t>(phase); }
std::span<const std::string_view> PhaseNames();

/// Components of a pose, of a box, of a filter.
inline constexpr std::size_t kPoseSize = 7;
inline constexpr std::size_t kBoxSize = 6;
inline constexpr std::size_t kFilterSize = 3;

/// One contact point of `record contacts`, as the worker streams it; doubles throughout so that a
/// reader needs one type. body: index of the object, walls after the last object; point on the
/// first body's surface, m; unit normal from the second body to the first; distance, m, negative
/// where they overlap.
struct ContactRecord {
  double body_a, body_b;
  double point[3];
  double normal[3];
  double distance;
};

}  // namespace cdb::measure
