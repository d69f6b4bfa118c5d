// A results file as tables for a terminal (`cdb show`).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/statistics/cycle_times.h"
#include "runtime/store/store.h"

namespace cdb::report {

struct ShowOptions {
  /// Axes that make the rows; everything else is pooled. Empty: all axes together if that is at
  /// most kMaxRows rows, else each axis separately.
  std::vector<std::string> by = {};
  /// The detector by which the others are divided. Empty: the first that has all cells.
  std::string baseline = {};
  /// Leave out runs whose timings are voided by their verdict.
  bool only_sound = false;
  /// The phases of the tables. Empty: all; ratios of detect and step.
  std::vector<measure::Phase> phases = {};
  statistics::CycleStatistic statistic = statistics::CycleStatistic::kMean;
  /// Add plots of characters: times over the cycles, and over axes of numbers.
  bool plots = false;
};

inline constexpr std::size_t kMaxRows = 60;

struct ShowText {
  std::string text;
  std::size_t bad_cells = 0;  ///< failed, crashed, timed out, or with void timings; including
                              ///< references
};

/// In this order: detectors that missed pairs; omissions, as far as they change the figures; the
/// mean of every phase, pairs and contacts, with spread and interval (cycle_times.h); the cost of
/// detectors, and the ratio between them. Void runs are in separate rows, marked, and in no mean or
/// ratio with others. Throws StoreError, also for an axis or a detector that the file does not
/// have.
ShowText Show(const store::ResultFile& file, const ShowOptions& options = {});

}  // namespace cdb::report
