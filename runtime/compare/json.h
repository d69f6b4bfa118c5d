// Comparisons of results files for scripts (`cdb compare --json`).
#pragma once

#include <string>
#include <vector>

#include "runtime/compare/history.h"

namespace cdb::compare {

/// Every number of the comparisons; NaN is null. `cdb doc compare` describes the members.
std::string CompareJson(const std::vector<BenchmarkHistory>& benchmarks,
                        const std::vector<std::string>& unmatched, const CompareOptions& options);

}  // namespace cdb::compare
