// What `cdb trace` runs in place of a benchmark's plan, and the files that it writes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::plans {

/// Every point of the plan once, recording what a trace holds and nothing else. Throws CommandError
/// for a plan that runs on traces itself.
plan::Plan MakeTracePlan(plan::Plan plan);

/// A file for each run, no two the same. `out`: a file if the command has one run, else a folder,
/// which is made; empty: named after the benchmark. `plan_count`: of the command. Throws
/// CommandError.
std::vector<std::filesystem::path> TraceFiles(const plan::Plan& plan, const std::string& out,
                                              std::size_t plan_count);

}  // namespace cdb::plans
