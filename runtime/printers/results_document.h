// A results file for other programs: as comma-separated values, and as one JSON document, for `cdb
// show --json`, the page of `cdb report`, and notebook modules. `cdb doc document` describes it.
// All statistics are computed by figures/; readers only display them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/figures/times.h"
#include "runtime/printers/document.h"
#include "runtime/results/store.h"

namespace cdb::printers {

struct DocumentOptions {
  std::string file;           ///< the name of the results file, for display
  std::string baseline = {};  ///< the baseline of ratios; empty: as in show.h
  bool only_sound = false;    ///< leave out runs whose timings are voided by their verdict
  /// Include pooled rows, the times of each cycle, and distributions.
  bool for_page = false;
};

/// A document with more points is too large for a page.
inline constexpr std::size_t kMaxDocumentPoints = 100'000;

/// UTF-8, without a newline. Throws StoreError, also for a detector that the file does not contain,
/// and for more than kMaxDocumentPoints points.
Printed ResultsDocument(const results::ResultFile& file, const DocumentOptions& options);

struct CsvOptions {
  std::vector<protocol::Phase> phases = {};  ///< empty: all
  figures::CycleStatistic statistic = figures::CycleStatistic::kMean;
  bool only_sound = false;  ///< leave out runs whose timings are voided by their verdict
};
/// A header line, then a line for each point with at least one run: its axes, verdict, mark,
/// repeats; for each phase the statistic over the cycles and the ends of its interval, ns; means of
/// counts, peak memory, errors. Six digits, independent of the locale; empty if there is no value.
/// Throws StoreError.
Printed CsvText(const results::ResultFile& file, const CsvOptions& options);

}  // namespace cdb::printers
