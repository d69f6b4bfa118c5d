// Ratios of the detectors in a comparison to a baseline, for `cdb show`.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::report {

/// The index of `name` on the axis of detectors; nullopt if it is empty. Throws StoreError that
/// names the detectors of the file.
std::optional<std::size_t> FindBaseline(const store::ResultFile& file, const std::string& name);

/// Times of `phases` (detect and step if that is empty) over those of the baseline (by default the
/// first detector that has all cells), at each point of the other axes, with the interval of each
/// ratio, paired by repeat. The geometric mean is over the points that all detectors have, sound
/// and with the same omissions; ratios of other points are in parentheses. Empty if the file does
/// not sweep detectors or has no timings. Throws StoreError.
std::string ShowRatios(const store::ResultFile& file,
                       const std::vector<statistics::MeasuredPoint>& points,
                       std::optional<std::size_t> baseline,
                       const std::vector<measure::Phase>& phases, statistics::CycleTimes& times);

}  // namespace cdb::report
