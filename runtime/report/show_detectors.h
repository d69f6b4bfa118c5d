// What each detector of a comparison costs and how that grows, for `cdb show`.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::report {

/// Two tables. Of detect: mean and worst cycle, pairs, faults and memory of each detector, in the
/// order of their axis, at each point of the other axes, or of `by` where that is not empty; what
/// makes no rows is pooled. And where one axis of three numbers or more changes how many objects
/// there are: p of detect ~ objects^p, by least squares over the logarithms of means. Empty where
/// the file sweeps no detectors or holds no timings. Throws StoreError.
std::string ShowDetectors(const store::ResultFile& file,
                          const std::vector<statistics::MeasuredPoint>& points,
                          const std::vector<std::size_t>& by, statistics::CycleTimes& times);

/// One line: what calling a detector costs beside its own work, and what part of the fastest
/// detector's time that is. Empty where no run says it.
std::string HarnessText(const store::ResultFile& file,
                        const std::vector<statistics::MeasuredPoint>& points,
                        statistics::CycleTimes& times);

}  // namespace cdb::report
