// A results file as comma-separated values (`cdb show --csv`).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "runtime/report/show.h"
#include "runtime/statistics/cycle_times.h"
#include "runtime/store/store.h"

namespace cdb::document {

struct CsvOptions {
  std::vector<measure::Phase> phases = {};  ///< empty: all
  statistics::CycleStatistic statistic = statistics::CycleStatistic::kMean;
  bool only_sound = false;  ///< leave out runs whose timings are voided by their verdict
};

/// A header line, then a line for each point with at least one run: its axes, verdict, mark,
/// repeats; for each phase the statistic over the cycles and the ends of its interval, ns; means of
/// counts, peak memory, errors. Six digits, independent of the locale; empty if there is no value.
/// Throws StoreError.
report::ShowText CsvText(const store::ResultFile& file, const CsvOptions& options);

/// A field, quoted as RFC 4180 requires.
std::string CsvField(std::string_view text);

}  // namespace cdb::document
