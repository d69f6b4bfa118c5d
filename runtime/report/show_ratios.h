// Detectors of a comparison against one of them, for `cdb show`.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::report {

/// The place of `name` on the axis of detectors; nullopt for an empty one. Throws StoreError that
/// names the detectors of the file.
std::optional<std::size_t> FindBaseline(const store::ResultFile& file, const std::string& name);

/// Times of `phases` (detect and step where that is empty) over those of the baseline (by default
/// the first detector that has all cells), at each point of the other axes, with the interval of
/// each ratio, paired by repeat. The geometric mean is over the points that all detectors have,
/// sound and with the same omissions; ratios of other points are in parentheses. Empty where the
/// file sweeps no detectors or holds no timings. Throws StoreError.
std::string ShowRatios(const store::ResultFile& file,
                       const std::vector<statistics::MeasuredPoint>& points,
                       std::optional<std::size_t> baseline,
                       const std::vector<measure::Phase>& phases, statistics::CycleTimes& times);

}  // namespace cdb::report
