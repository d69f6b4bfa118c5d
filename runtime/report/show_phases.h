// The time of each phase of a cycle, for `cdb show`.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::report {

/// Up to three tables with a row for each value on the axes `by`: the time of every phase, or of
/// those in `phases` if that is not empty, and the means of pairs and contacts; the 5th and 95th
/// percentile over the cycles; and the intervals of the means. Empty for a file without timings and
/// pairs. Throws StoreError.
std::string ShowPhases(const store::ResultFile& file,
                       const std::vector<statistics::MeasuredPoint>& points,
                       const std::vector<std::size_t>& by,
                       const std::vector<measure::Phase>& phases, statistics::CycleTimes& times);

}  // namespace cdb::report
