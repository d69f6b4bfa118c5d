// Comparisons of results files for scripts (`cdb compare --json`).
#pragma once

#include <string>
#include <vector>

#include "runtime/report/compare_history.h"

namespace cdb::report {

/// Every number of the comparisons; NaN is null. `cdb doc statistics` describes the members.
std::string CompareJson(const std::vector<BenchmarkHistory>& benchmarks,
                        const std::vector<std::string>& unmatched, const CompareOptions& options);

}  // namespace cdb::report
