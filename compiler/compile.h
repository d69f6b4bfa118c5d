// A scenario file to plans: the compiler's front door.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compiler/analysis/scene_fault.h"
#include "compiler/grid/grid.h"
#include "compiler/plan/plan.h"
#include "compiler/scenario/scenario.h"
#include "dsl/diagnostics.h"

namespace cdb::compiler {

struct CompileOptions {
  std::string library;  ///< folder of the scenarios that `use` reaches from anywhere; may be empty
  std::optional<std::string> benchmark;  ///< only this one; nullopt: every benchmark of the file
  scenario::PluginSource plugins = {};
  analysis::ReadTrace read_trace = {};  ///< without it no `trace` can be read
  /// Without it, objects that cannot be placed and wrong closed forms show in runs only.
  analysis::FindSceneFault find_fault = {};
  analysis::ReadPoses read_poses = {};  ///< without it no `location poses("file")` can be read
  /// Fills Compilation::plans; a benchmark with more than kMostListed runs is an error then.
  bool lists_runs = true;
};

/// Runs of a plan that is held in memory run by run.
inline constexpr std::uint64_t kMostListed = 100'000;

/// What came of it. Diagnostics point into `scenario`, which has to be kept as long as they are.
struct Compilation {
  std::shared_ptr<const scenario::Scenario> scenario;
  dsl::Diagnostics diagnostics;
  std::vector<grid::Grid> grids;        ///< empty where there are errors
  std::vector<plan::Plan> plans;        ///< of `grids`, run by run, where that was asked for
  std::vector<std::string> benchmarks;  ///< of the file, by name
};

/// Checks the file whole and reports every error, also of benchmarks that were not asked for. Never
/// throws.
Compilation Compile(const std::string& path, const scenario::ReadFile& read,
                    const CompileOptions& options = {});

/// Reads from the disk.
std::optional<std::string> ReadFromDisk(const std::string& path, std::string& why);

}  // namespace cdb::compiler
