// Compiles a scenario file to plans: the entry point of the compiler.
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
  std::string library;  ///< folder of the scenarios that any file can `use`; may be empty
  std::optional<std::string> benchmark;  ///< the only one to compile; nullopt: all of the file
  scenario::PluginSource plugins = {};
  analysis::ReadTrace read_trace = {};  ///< if empty, no `trace` can be read
  /// If empty, impossible placements and wrong closed forms show only in runs.
  analysis::FindSceneFault find_fault = {};
  analysis::ReadPoses read_poses = {};  ///< if empty, no `location poses("file")` can be read
  /// Fills Compilation::plans; a benchmark with more than kMostListed runs is then an error.
  bool lists_runs = true;
};

/// The maximum number of runs of a plan held in memory run by run.
inline constexpr std::uint64_t kMostListed = 100'000;

/// The result of a compilation. Diagnostics point into `scenario`, which must outlive them.
struct Compilation {
  std::shared_ptr<const scenario::Scenario> scenario;
  dsl::Diagnostics diagnostics;
  std::vector<grid::Grid> grids;        ///< empty after errors
  std::vector<plan::Plan> plans;        ///< of `grids`, run by run, if requested
  std::vector<std::string> benchmarks;  ///< names of those in the file
};

/// Checks the whole file and reports every error, also of benchmarks that are not compiled. Never
/// throws.
Compilation Compile(const std::string& path, const scenario::ReadFile& read,
                    const CompileOptions& options = {});

/// Reads a file from disk.
std::optional<std::string> ReadFromDisk(const std::string& path, std::string& why);

}  // namespace cdb::compiler
