#include "compiler/compile.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/checks/file_lets.h"
#include "compiler/checks/unreachable.h"
#include "compiler/expand.h"
#include "compiler/plan/input_file.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::compiler {
Compilation Compile(const std::string& path, const scenario::ReadFile& read,
                    const CompileOptions& options) {
  Compilation result;
  const auto scenario = std::make_shared<const scenario::Scenario>(
      path, options.library, read, options.plugins, options.read_trace, options.read_poses,
      result.diagnostics);
  result.scenario = scenario;
  if (scenario->main() == nullptr) return result;
  const auto benchmarks = scenario->Benchmarks();
  const bool is_read = !result.diagnostics.has_errors();
  scenario->CheckNames(result.diagnostics);
  for (const scenario::BenchmarkRef& benchmark : benchmarks)
    result.benchmarks.push_back(benchmark.benchmark->name.text);
  if (benchmarks.empty() && is_read) {
    const text::Span start = {scenario->main()->tree.source.get(), 0, 0};
    result.diagnostics.Report(scenario::kNoRuns, start, "there is no benchmark in this file",
                              "`benchmark name { }` is a complete benchmark");
  }
  checks::CheckFileLets(*scenario, result.diagnostics);
  for (const scenario::BenchmarkRef& benchmark : benchmarks) {
    const bool is_asked_for =
        !options.benchmark || *options.benchmark == benchmark.benchmark->name.text;
    auto grid = Expand(scenario, benchmark, options.find_fault, result.diagnostics, is_asked_for);
    if (!grid || !is_asked_for) continue;
    checks::ReportUnreachable(*scenario, benchmark, *grid, result.diagnostics);
    if (options.lists_runs && grid->run_count() > kMostListed)
      result.diagnostics.Report(scenario::kTooManyRuns, benchmark.benchmark->name.span,
                                fmt::format("this benchmark has {} runs", grid->run_count()),
                                fmt::format("commands that list runs take at most {}; skip some by "
                                            "`skip`, or split the benchmark",
                                            kMostListed));
    grid->head.benchmark = benchmark.benchmark->name.text;
    grid->head.title = benchmark.benchmark->title;
    grid->head.source = path;
    grid->head.scenario_text = scenario->FullText();
    result.grids.push_back(std::move(*grid));
  }
  if (result.diagnostics.has_errors()) result.grids.clear();
  if (options.lists_runs)
    for (const grid::Grid& grid : result.grids) result.plans.push_back(grid::ListRuns(grid));
  return result;
}

std::optional<std::string> ReadFromDisk(const std::string& path, std::string& why) {
  return plan::ReadInputFile(path, why);
}

}  // namespace cdb::compiler
