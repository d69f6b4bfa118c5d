// A results file as tables on a terminal (`cdb show`).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/statistics/cycle_times.h"
#include "runtime/store/store.h"

namespace cdb::report {

struct ShowOptions {
  /// Axes that make the rows; everything else is pooled. Empty: all axes together where that is at
  /// most kMaxRows rows, else each axis by itself.
  std::vector<std::string> by = {};
  /// The detector that the others are divided by. Empty: the first that has all cells.
  std::string baseline = {};
  /// Without runs whose timings a verdict voids.
  bool only_sound = false;
  /// The phases of the tables. Empty: all; ratios of detect and step.
  std::vector<measure::Phase> phases = {};
  statistics::CycleStatistic statistic = statistics::CycleStatistic::kMean;
  /// With plots of characters: times over the cycles, and over axes of numbers.
  bool plots = false;
};

inline constexpr std::size_t kMaxRows = 60;

struct ShowText {
  std::string text;
  std::size_t bad_cells = 0;  ///< failed, crashed, timed out, or with void timings; references too
};

/// Detectors that missed pairs, first; what runs did without, as far as it changes the figures;
/// the mean of every phase, pairs and contacts, with spread and interval (cycle_times.h); what
/// detectors cost, the ratio between them. Void runs are in rows of their own, marked, and in no
/// mean or ratio with others. Throws StoreError, also for an axis or a detector that the file has
/// not got.
ShowText Show(const store::ResultFile& file, const ShowOptions& options = {});

}  // namespace cdb::report
