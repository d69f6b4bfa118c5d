// Phrases of conclusions (conclusions.h).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::report {

/// `a`, `a and b`, `a, b and c`.
std::string JoinWords(const std::vector<std::string>& words);
/// ` (95 % interval 0.98 .. 1.02)`, ` (range 0.98 .. 1.02)`; empty if there is none.
std::string IntervalNote(const statistics::CycleTimes& times, const statistics::Estimate& estimate,
                         double scale = 1);
/// `1.23 ms`.
std::string TimeText(double ns);
/// `hz 240, iterations 20`: values on the axes `axes`, at the point `at` on them.
std::string SettingText(const store::ResultFile& file, const std::vector<std::size_t>& axes,
                        const statistics::Point& at);
/// All axes of a file except one.
std::vector<std::size_t> OtherAxes(const store::ResultFile& file, std::size_t axis);
/// `the number of objects`, `hz`: an axis in a sentence.
std::string AxisWords(const plan::Axis& axis);

}  // namespace cdb::report
