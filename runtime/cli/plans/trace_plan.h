// The plan that `cdb trace` executes in place of that of a benchmark, and the files that it writes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::plans {

/// Every point of the plan once; it records the series of a trace and nothing else. Throws
/// CommandError for a plan that runs on traces itself.
plan::Plan MakeTracePlan(plan::Plan plan);

/// A different file for each run. `out`: a file if the command has one run, else a folder, which is
/// created; empty: named after the benchmark. `plan_count`: the number of plans of the command.
/// Throws CommandError.
std::vector<std::filesystem::path> TraceFiles(const plan::Plan& plan, const std::string& out,
                                              std::size_t plan_count);

}  // namespace cdb::plans
