// The cost of each detector in a comparison, and its growth, for `cdb show`.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::report {

/// Two tables. For detect: mean and worst cycle, pairs, faults and memory of each detector, in the
/// order of their axis, at each point of the other axes, or of `by` if that is not empty; axes that
/// make no rows are pooled. If one axis with at least three numbers changes the number of objects:
/// p of detect ~ objects^p, by least squares over the logarithms of means. Empty if the file does
/// not sweep detectors or has no timings. Throws StoreError.
std::string ShowDetectors(const store::ResultFile& file,
                          const std::vector<statistics::MeasuredPoint>& points,
                          const std::vector<std::size_t>& by, statistics::CycleTimes& times);

/// One line: the overhead of calling a detector, and its fraction of the fastest detector's time.
/// Empty if no run states it.
std::string HarnessText(const store::ResultFile& file,
                        const std::vector<statistics::MeasuredPoint>& points,
                        statistics::CycleTimes& times);

}  // namespace cdb::report
