// Phrases for figures: in conclusions, notes and tables.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/figures/times.h"
#include "runtime/store/store.h"

namespace cdb::figures {

/// `a`, `a and b`, `a, b and c`.
std::string JoinWords(const std::vector<std::string>& words);
/// ` (95 % interval 0.98 .. 1.02)`, ` (range 0.98 .. 1.02)`; empty if there is none.
std::string IntervalNote(const CycleTimes& times, const Estimate& estimate, double scale = 1);
/// `1.23 ms`.
std::string TimeText(double ns);
/// All axes of a file except one.
std::vector<std::size_t> OtherAxes(const store::ResultFile& file, std::size_t axis);
/// `the number of objects`, `hz`: an axis in a sentence.
std::string AxisWords(const plan::Axis& axis);

}  // namespace cdb::figures
