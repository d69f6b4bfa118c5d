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
  bool only_sound = false;  ///< without runs whose timings a verdict voids
};

/// A line for each point that some run was made at, below a head: its axes, verdict, mark, repeats;
/// of each phase the statistic over the cycles and the ends of its interval, ns; means of counts,
/// peak memory, errors. Six digits, whatever the locale; empty where there is no value. Throws
/// StoreError.
report::ShowText CsvText(const store::ResultFile& file, const CsvOptions& options);

/// A field as RFC 4180 quotes it.
std::string CsvField(std::string_view text);

}  // namespace cdb::document
