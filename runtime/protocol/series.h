// The series (compiler/schema/series.h) that the runs of a plan record, and their extents. Used by
// worker, store and `cdb show`.
#pragma once

#include <cstddef>
#include <iterator>
#include <span>
#include <string_view>
#include <vector>

#include "compiler/analysis/recorded.h"
#include "compiler/plan/plan.h"
#include "compiler/schema/series.h"

namespace cdb::protocol {

using schema::Dimension;
using schema::DimensionInfo;
using schema::DimensionsOf;
using schema::FindSeries;
using schema::InfoOf;
using schema::Phase;
using schema::RunExtents;
using schema::Series;
using schema::SeriesShape;
using schema::SeriesType;

inline std::span<const Series> AllSeries() { return schema::kSeries; }

RunExtents ExtentsOf(const plan::Scene& scene);

using analysis::IsRecordedBy;
/// True if any run of `plan` records the series.
bool IsRecordedBy(const Series& series, const plan::Plan& plan);

/// The series that some run records, in the order of AllSeries, found in one pass over the runs.
std::vector<const Series*> RecordedSeries(const plan::Plan& plan);

/// The same for one run after the other. Computed again only if a run records other series than the
/// one before. Not thread-safe.
class RecordedSeriesOf {
 public:
  const std::vector<const Series*>& Find(const plan::Scene& scene);

 private:
  int kind_ = -1;  ///< of run: in a live world, on a trace and so on; -1 before the first
  schema::Value record_;
  bool asks_ = false;  ///< it has queries
  std::vector<const Series*> series_;
};

inline constexpr std::size_t kPhaseCount = std::size(schema::kPhases);
/// The index of the phase on the axis `phase`.
constexpr std::size_t IndexOf(Phase phase) { return static_cast<std::size_t>(phase); }
inline std::span<const std::string_view> PhaseNames() { return schema::kPhases; }

inline constexpr std::size_t kCounterCount = std::size(schema::kCounters);
inline constexpr std::size_t kQueryTypeCount = std::size(schema::kQueryTypes);
inline constexpr std::size_t kAnswerSize = std::size(schema::kAnswerParts);
inline constexpr std::size_t kPoseSize = std::size(schema::kPoseParts);
inline constexpr std::size_t kBoxSize = std::size(schema::kBounds);
inline constexpr std::size_t kFilterSize = std::size(schema::kFilterParts);

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

}  // namespace cdb::protocol
