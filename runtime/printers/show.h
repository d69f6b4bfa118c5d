// A results file as tables (`cdb show`).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/figures/errors.h"
#include "runtime/figures/times.h"
#include "runtime/printers/document.h"
#include "runtime/results/store.h"

namespace cdb::printers {

struct ShowOptions {
  /// Axes that make the rows; everything else is pooled. Empty: all axes together if that is at
  /// most kMaxRows rows, else each axis separately.
  std::vector<std::string> by = {};
  /// The detector by which the others are divided. Empty: the first that has all cells.
  std::string baseline = {};
  /// Leave out runs whose timings are voided by their verdict.
  bool only_sound = false;
  /// The phases of the tables. Empty: all; ratios of detect and step.
  std::vector<protocol::Phase> phases = {};
  figures::CycleStatistic statistic = figures::CycleStatistic::kMean;
  /// Add plots of characters: times over the cycles, and over axes of numbers.
  bool plots = false;
  Format format = Format::kTerminal;
};

inline constexpr std::size_t kMaxRows = 60;

/// In this order: detectors that missed pairs; omissions, as far as they change the figures; the
/// mean of every phase, pairs and contacts, with spread and interval (figures/times.h); the cost of
/// detectors, and the ratio between them. Void runs are in separate rows, marked, and in no mean or
/// ratio with others. Throws StoreError, also for an axis or a detector that the file does not
/// have.
Printed Show(const results::ResultFile& file, const ShowOptions& options = {});

struct ShowErrorOptions {
  figures::ErrorOptions errors;
  bool only_sound = false;
  Format format = Format::kTerminal;
};
/// Error against run time (`cdb show --error`): each configuration, the fastest first, with its
/// speed relative to real time, the time of a simulated second (the statistic of figures/times.h
/// over the time step), its error, and whether it is on the Pareto front, that is, no other is both
/// faster and as accurate. A configuration that is worse than those of the front only within the
/// intervals ties with it. Intervals of times are over repeats; those of errors are over seeds, if
/// the file sweeps them. Void configurations are last, marked and not on the front; those without
/// the error or without a time are listed separately. Throws StoreError, also for an error or an
/// axis that the file does not have.
Printed ShowError(const results::ResultFile& file, const ShowErrorOptions& options);

/// The part of one benchmark: the verdicts along its graded axis, the last one of numbers, in a
/// line for each combination of the other axes, with equal neighbours joined: `single  stable 1 ..
/// 5 | penetrating 10 | collapsed 20 .. 1000` The worst verdict of the repeats counts. Throws
/// StoreError.
std::string StabilityMap(const results::ResultFile& file);

struct VerifyText {
  std::string text;
  bool is_good = false;  ///< nothing is missed, and every run succeeded
};

/// A row for each detector: first those that missed pairs, then those that missed contacts, then
/// those that failed, otherwise in the file's order. Below: the first bad cycle of each, the
/// command that replays it, and `left_out`. The file holds runs with `record pairs`. Throws
/// StoreError.
VerifyText VerifyTable(const results::ResultFile& file, const std::vector<std::string>& left_out);

}  // namespace cdb::printers
