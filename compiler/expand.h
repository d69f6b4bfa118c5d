// Expands a benchmark to the grid of its runs, with all settings as values.
#pragma once

#include <memory>
#include <optional>

#include "compiler/analysis/scene_fault.h"
#include "compiler/grid/grid.h"
#include "compiler/scenario/scenario.h"

namespace cdb::compiler {

/// Nullopt after diagnostics. `Compile` fills in title and texts of the plan. `find_fault` checks
/// scenes; may be empty. `lints`: warn of numbers that Bullet cannot simulate accurately
/// (compiler/lints/lints.h), each once with its worst run.
std::optional<grid::Grid> Expand(std::shared_ptr<const scenario::Scenario> scenario,
                                 const scenario::BenchmarkRef& benchmark,
                                 const analysis::FindSceneFault& find_fault,
                                 dsl::Diagnostics& diagnostics, bool lints);

}  // namespace cdb::compiler
