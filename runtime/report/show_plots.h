// Small plots of characters, for `cdb show --plot`.
#pragma once

#include <string>
#include <vector>

#include "runtime/measure/series.h"
#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::report {

/// Bars from the least to the greatest of `values`, which are averaged in at most `width` bins; a
/// space for a bin without values.
std::string Sparkline(const std::vector<double>& values, std::size_t width);

/// The phases (only the step if `phases` is empty) over the cycles, a line for each of at most 24
/// points; and over each axis of at least three numbers. Empty for a file without timings.
std::string ShowPlots(const store::ResultFile& file,
                      const std::vector<statistics::MeasuredPoint>& points,
                      const std::vector<measure::Phase>& phases, statistics::CycleTimes& times);

}  // namespace cdb::report
